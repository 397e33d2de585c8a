#include <fmt/format.h>

#include <cmath>

#include "instruments/draw/page.hpp"
#include "instruments/pictures/stability_pictures.hpp"

namespace pictures {
namespace {

/// The line growth = 1 through the plane, by squares so small that it is straight in each; breaks
/// (points that are not finite) between its pieces.
std::vector<draw::Point> boundary(const measure::Plan& plan) {
  constexpr int across = 160;
  const double width = plan.x_max / across, height = plan.y_max / across;
  // The verdict flips a hair above 1, since a method that neither damps nor grows is stable.
  std::vector<double> level;
  for (int j = 0; j <= across; ++j)
    for (int i = 0; i <= across; ++i)
      level.push_back(plan.growth(i * width, j * height) - (1.0 + 1e-9));
  std::vector<draw::Point> line;
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < across; ++i) {
      struct Corner {
        int i, j;
      };
      const Corner corners[] = {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j + 1}};
      std::vector<draw::Point> crossings;
      for (int k = 0; k < 4; ++k) {
        const Corner a = corners[k], b = corners[(k + 1) % 4];
        const double la = level[static_cast<std::size_t>(a.j * (across + 1) + a.i)];
        const double lb = level[static_cast<std::size_t>(b.j * (across + 1) + b.i)];
        if ((la > 0.0) == (lb > 0.0)) continue;
        const double part = la / (la - lb);
        crossings.push_back(
            {(a.i + part * (b.i - a.i)) * width, (a.j + part * (b.j - a.j)) * height});
      }
      for (std::size_t k = 0; k + 1 < crossings.size(); k += 2) {
        line.push_back(crossings[k]);
        line.push_back(crossings[k + 1]);
        line.push_back({std::nan(""), std::nan("")});
      }
    }
  return line;
}

draw::Plot panel(const measure::Map& map, const draw::Theme& theme) {
  const measure::Plan& plan = map.plan;
  draw::Plot plot;
  plot.title = plan.title();
  plot.x = {.label = plan.x_label, .min = 0.0, .max = plan.x_max};
  plot.y = {.label = plan.y_label, .min = 0.0, .max = plan.y_max};
  plot.legend = draw::Legend::none;
  const double half_width = 0.5 * plan.x_max / map.across,
               half_height = 0.5 * plan.y_max / map.across;
  draw::Curve differ{.color = theme.ink, .markers = true, .line = false};  // first: a disc
  for (const measure::Cell& cell : map.cells) {
    if (cell.stable)
      plot.tiles.push_back({{cell.x - half_width, cell.y - half_height},
                            {cell.x + half_width, cell.y + half_height},
                            theme.series[0].faded(0.45)});
    if (cell.compared && cell.stable != cell.theory) differ.points.push_back({cell.x, cell.y});
  }
  plot.curves.push_back(differ);
  plot.curves.push_back({.points = boundary(plan), .color = theme.series[1], .thickness = 2.4});
  if (!plan.of_gains) return plot;
  draw::Curve critical{.color = theme.ink, .dash = draw::Dash::dashed};
  for (int i = 0; i <= 100; ++i) {
    const double x = plan.x_max * i / 100;
    if (x * x / 4 <= plan.y_max) critical.points.push_back({x, x * x / 4});
  }
  plot.curves.push_back(critical);
  return plot;
}

}  // namespace

Picture map_picture(const std::string& scene, const std::vector<measure::Map>& maps,
                    const std::string& remark) {
  int agreeing = 0, compared = 0;
  for (const measure::Map& map : maps) {
    agreeing += map.agreeing();
    compared += map.compared();
  }
  const std::string caption =
      fmt::format("Measured and theory agree in {} of the {} cells where they can be compared. {}",
                  agreeing, compared, remark);
  return {
      "stability_map", [=](draw::Pen& pen) {
        const draw::Theme& theme = pen.theme();
        const draw::Rect content = draw::page(pen, scene + ": where a run is stable", caption);
        constexpr double gap = 20.0;
        const double width = (content.width - 2.0 * gap) / 3.0,
                     height = (content.height - gap) / 2.0;
        const std::size_t columns = maps.size() > 4 ? 3 : 2;
        const auto place = [&](std::size_t k) {
          const std::size_t column = k % columns, row = k / columns;
          return draw::Rect{content.left + static_cast<double>(column) * (width + gap),
                            content.top + static_cast<double>(row) * (height + gap), width, height};
        };
        for (std::size_t k = 0; k < maps.size(); ++k)
          draw::draw_plot(pen, place(k), panel(maps[k], theme));
        // The legend stands where a sixth plane would, or beside four.
        static_assert(integrators::schemes.size() < 6);
        const draw::Rect beside{content.left + 2.0 * (width + gap), content.top, width, height};
        const draw::Rect legend = columns == 3 ? place(maps.size()) : beside;
        const double x = legend.left + 24.0, sample = 26.0;
        double y = legend.top + 40.0;
        const auto entry = [&](const std::string& label, const auto& draw_sample) {
          draw_sample();
          pen.text({x + sample + 10.0, y}, label, theme.ink);
          y += 30.0;
        };
        const auto tile = [&](draw::Color fill) {
          const std::vector<draw::Point> corners{
              {x, y - 8.0}, {x + sample, y - 8.0}, {x + sample, y + 8.0}, {x, y + 8.0}};
          pen.polygon(corners, fill, theme.grid, 1.0);
        };
        entry("stable, measured", [&] { tile(theme.series[0].faded(0.45)); });
        entry("unstable, measured", [&] { tile(theme.paper); });
        entry("limit of theory", [&] { pen.line({x, y}, {x + sample, y}, theme.series[1], 2.4); });
        if (!maps.empty() && maps.front().plan.of_gains)
          entry("critical damping: k_s h² = (k_d h)²/4", [&] {
            pen.line({x, y}, {x + sample, y}, theme.ink, 1.8, draw::Dash::dashed);
          });
        entry("they differ here", [&] {
          pen.circle({x + 0.5 * sample, y}, 4.0, theme.ink, theme.paper, 1.0);
        });
      }};
}

Picture long_run_picture(const std::string& scene, const std::vector<measure::LongCurve>& curves,
                         double step) {
  draw::Plot plot;
  plot.x = {.label = "time [s]", .log = true};
  plot.y = {.label = "largest energy error so far, as a part of the scene's kinetic energy",
            .log = true};
  plot.legend = draw::Legend::above;
  std::string growing, bounded;
  for (const measure::LongCurve& long_curve : curves) {
    draw::Curve curve{.label = long_curve.method, .markers = true, .mark_every = 12};
    for (const auto& [t, error] : long_curve.looks) curve.points.push_back({t, error});
    plot.curves.push_back(curve);
    std::string& list = long_curve.bounded() ? bounded : growing;
    list += (list.empty() ? "" : ", ") + long_curve.method;
  }
  const std::string caption =
      fmt::format("Steps of {:g} s. Grows: {}. Stays bounded: {}.", step,
                  growing.empty() ? "none" : growing, bounded.empty() ? "none" : bounded);
  return {"long_run", [=](draw::Pen& pen) {
            draw::Plot themed = plot;
            for (draw::Curve& curve : themed.curves) set_look(curve, pen.theme(), curve.label);
            draw::draw_plot(pen, draw::page(pen, scene + ": energy over a million steps", caption),
                            themed);
          }};
}

}  // namespace pictures
