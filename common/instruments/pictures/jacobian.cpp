#include "instruments/pictures/jacobian.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pictures {
namespace {

using draw::Align;
using draw::Font;

std::size_t count(const std::vector<Jacobian::Side>& sides) {
  std::size_t n = 0;
  for (const auto& side : sides) n += side.parts.size();
  return n;
}

std::string number(double value) {
  const std::string text = fmt::format("{:.5g}", value == 0.0 ? 0.0 : value);
  return text.starts_with('-') ? "−" + text.substr(1) : text;
}

}  // namespace

void draw_jacobian(draw::Pen& pen, const draw::Rect& area, const Jacobian& J) {
  const auto& theme = pen.theme();
  const std::size_t columns = count(J.things), rows = count(J.joints);
  constexpr double gap = 6.0;
  double names = 0.0, words = 0.0, head = 26.0;
  for (const auto& thing : J.things)
    for (const auto& word : thing.parts)
      if (!word.empty()) head = 46.0;
  for (const auto& joint : J.joints) {
    names = std::max(names, pen.text_width(joint.name, Font::bold));
    for (const auto& word : joint.parts) words = std::max(words, pen.text_width(word));
  }
  const double left = names + (words > 0.0 ? words + 12.0 : 0.0) + 14.0;
  const double width =
      std::min(100.0, (area.width - left - gap * static_cast<double>(J.things.size())) /
                          static_cast<double>(columns));
  const double height =
      std::min(120.0, (area.height - head - gap * static_cast<double>(J.joints.size())) /
                          static_cast<double>(rows));
  const auto along = [gap = gap](std::size_t cells, std::size_t groups, double size) {
    return static_cast<double>(cells) * size + static_cast<double>(groups) * gap;
  };
  const double total = left + along(columns, J.things.size(), width);
  const double x0 = area.left + std::max(0.0, 0.5 * (area.width - total)) + left;
  const double body = along(rows, J.joints.size(), height);
  const double y0 = area.top + head + std::max(0.0, 0.5 * (area.height - head - body));

  std::size_t first_column = 0;
  for (std::size_t t = 0; t < J.things.size(); ++t) {
    const auto& thing = J.things[t];
    const double x = x0 + along(first_column, t, width);
    const double middle = x + 0.5 * width * static_cast<double>(thing.parts.size());
    pen.text({middle, y0 - head + 12.0}, thing.name, theme.ink, Font::bold, Align::center);
    for (std::size_t i = 0; i < thing.parts.size(); ++i)
      pen.text({x + (static_cast<double>(i) + 0.5) * width, y0 - 14.0}, thing.parts[i], theme.muted,
               Font::text, Align::center);
    first_column += thing.parts.size();
  }

  std::size_t first_row = 0;
  for (std::size_t j = 0; j < J.joints.size(); ++j) {
    const auto& joint = J.joints[j];
    const std::size_t r = joint.parts.size();
    const double y = y0 + along(first_row, j, height);
    pen.text({x0 - left, y + 0.5 * height * static_cast<double>(r)}, joint.name, theme.ink,
             Font::bold);
    for (std::size_t i = 0; i < r; ++i)
      pen.text({x0 - 12.0, y + (static_cast<double>(i) + 0.5) * height}, joint.parts[i],
               theme.muted, Font::text, Align::right);
    first_column = 0;
    for (std::size_t t = 0; t < J.things.size(); ++t) {
      const std::size_t c = J.things[t].parts.size();
      const double x = x0 + along(first_column, t, width);
      const auto value = [&, first = first_column](std::size_t row, std::size_t column) {
        return J.values[(first_row + row) * columns + first + column];
      };
      bool stored = false;
      for (std::size_t row = 0; row < r; ++row)
        for (std::size_t column = 0; column < c; ++column) stored |= value(row, column) != 0.0;
      const double right = x + width * static_cast<double>(c);
      const double bottom = y + height * static_cast<double>(r);
      const draw::Color color = theme.series[j % theme.series.size()];
      const std::vector<draw::Point> box{{x, y}, {right, y}, {right, bottom}, {x, bottom}};
      pen.polygon(box, stored ? color.faded(0.14) : draw::transparent, stored ? color : theme.grid,
                  stored ? 1.6 : 1.0);
      if (stored)
        for (std::size_t row = 0; row < r; ++row)
          for (std::size_t column = 0; column < c; ++column)
            pen.text({x + (static_cast<double>(column) + 0.5) * width,
                      y + (static_cast<double>(row) + 0.5) * height},
                     number(value(row, column)),
                     value(row, column) != 0.0 ? theme.ink : theme.muted, Font::text,
                     Align::center);
      first_column += c;
    }
    first_row += r;
  }
}

}  // namespace pictures
