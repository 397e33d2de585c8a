#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "instruments/draw/geometry.hpp"
#include "instruments/draw/theme.hpp"

struct ImDrawList;
struct ImFont;

namespace draw {

enum class Font { small, text, bold, title };
enum class Align { left, center, right };
enum class Dash { solid, dashed, dotted };

/// One font for each value of `Font`, with Greek letters, sub- and superscripts, common signs.
using Fonts = std::array<ImFont*, 4>;

/// Adds the fonts, made for `scale` pixels a point, to the current Dear ImGui context. Throws
/// std::runtime_error when a font file is missing.
Fonts load_fonts(double scale);

/// Draws on a page measured in points: origin top left, x right, y down. All thicknesses, radii
/// and widths are in points. What is not finite is left out.
class Pen {
 public:
  /// Draws into `list`, which is in pixels: `scale` of them make a point.
  Pen(ImDrawList* list, const Fonts& fonts, const Theme& theme, double width, double height,
      double scale);

  double width() const { return width_; }
  double height() const { return height_; }
  const Theme& theme() const { return theme_; }

  /// The sentence under the picture, for those who read without seeing it.
  const std::string& caption() const { return caption_; }
  void set_caption(std::string_view caption) { caption_ = caption; }
  /// What is said at the end of the caption, whatever the picture.
  const std::string& remark() const { return remark_; }
  void set_remark(std::string_view remark) { remark_ = remark; }
  /// Whether pages show their captions; where not, whoever shows the picture says it.
  bool shows_caption() const { return shows_caption_; }
  void show_caption(bool show) { shows_caption_ = show; }

  void line(Point from, Point to, Color color, double thickness = 1.6, Dash dash = Dash::solid);
  /// Breaks where a point is not finite.
  void polyline(std::span<const Point> points, Color color, double thickness = 1.6,
                Dash dash = Dash::solid);
  /// Convex; in either sense of rotation.
  void polygon(std::span<const Point> corners, Color fill, Color edge = transparent,
               double thickness = 1.6);
  void circle(Point center, double radius, Color fill, Color edge = transparent,
              double thickness = 1.6);
  /// A shaft with a filled head, which shrinks with an arrow too short for it.
  void arrow(Point from, Point to, Color color, double thickness = 2.2);

  /// `at` is the vertical middle of the line of text. `halo`: outlined in the colour of the paper,
  /// to be readable over lines. In "k_d" and the like the `d` is a subscript.
  void text(Point at, std::string_view utf8, Color color, Font font = Font::text,
            Align align = Align::left, bool halo = false);
  double text_width(std::string_view utf8, Font font = Font::text) const;
  /// The height of a line of text.
  static double line_height(Font font);
  /// The lines of `utf8`, broken between words to be no wider than `width`.
  std::vector<std::string> wrap(std::string_view utf8, Font font, double width) const;

  /// What follows is drawn inside `area` only (and inside earlier clips), until `unclip`.
  void clip(const Rect& area);
  void unclip();

 private:
  class Stroke;

  ImDrawList* list_;
  Fonts fonts_;
  Theme theme_;
  double width_, height_, scale_;
  std::string caption_, remark_;
  bool shows_caption_ = true;
};

}  // namespace draw
