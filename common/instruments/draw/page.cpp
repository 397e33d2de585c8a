#include "instruments/draw/page.hpp"

namespace draw {

Rect page(Pen& pen, std::string_view title, std::string_view text) {
  const std::string caption =
      pen.remark().empty() ? std::string(text) : std::string(text) + " " + pen.remark();
  pen.set_caption(caption);
  constexpr double margin = 14, gap = 8, leading = 1.15;
  Rect content = Rect{0, 0, pen.width(), pen.height()}.inset(margin);

  const double title_line = leading * Pen::line_height(Font::title);
  double y = content.top + Pen::line_height(Font::title) / 2;
  const auto heading = pen.wrap(title, Font::title, content.width);
  for (const std::string& line : heading) {
    pen.text({content.left, y}, line, pen.theme().ink, Font::title);
    y += title_line;
  }
  const double above = heading.empty() ? 0 : title_line * static_cast<double>(heading.size()) + gap;

  const double caption_line = leading * Pen::line_height(Font::text);
  const auto footing = pen.wrap(pen.shows_caption() ? caption : "", Font::text, content.width);
  const double below =
      footing.empty() ? 0 : caption_line * static_cast<double>(footing.size()) + gap;
  y = content.bottom() - below + gap + caption_line / 2;
  for (const std::string& line : footing) {
    pen.text({content.left, y}, line, pen.theme().ink);
    y += caption_line;
  }
  return {content.left, content.top + above, content.width, content.height - above - below};
}

}  // namespace draw
