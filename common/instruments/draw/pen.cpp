#include "instruments/draw/pen.hpp"

#include <imgui.h>

#include <cctype>
#include <cfloat>
#include <numbers>

#include "instruments/draw/font_sizes.hpp"

namespace draw {
namespace {

ImU32 packed(Color c) { return IM_COL32(c.r, c.g, c.b, c.a); }

ImVec2 pixels(Point p) { return {static_cast<float>(p.x), static_cast<float>(p.y)}; }

std::size_t index(Font font) { return static_cast<std::size_t>(font); }

// The corners of a regular polygon.
std::vector<Point> circle_outline(Point center, double radius, int corners) {
  std::vector<Point> outline;
  for (int i = 0; i < corners; ++i) {
    const double phi = 2 * std::numbers::pi * i / corners;
    outline.push_back(center + radius * Point{std::cos(phi), std::sin(phi)});
  }
  return outline;
}

// Where each point moves when the edges at it move by 1 to their right (on the page: y is down);
// not further than 10 at sharp corners. Dear ImGui's own take a square root that differs between
// processors.
std::vector<Point> mitres(std::span<const Point> points, bool closed) {
  const std::size_t n = points.size();
  std::vector<Point> normals(n), result(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Point edge = points[(i + 1) % n] - points[i];
    const double l = length(edge);
    if (l > 0) normals[i] = 1 / l * Point{-edge.y, edge.x};
  }
  if (!closed) normals[n - 1] = normals[n - 2];
  for (std::size_t i = 0; i < n; ++i) {
    const Point before = normals[closed ? (i + n - 1) % n : std::max<std::size_t>(i, 1) - 1];
    const Point mean = 0.5 * (before + normals[i]);
    result[i] = 1 / std::max(mean.x * mean.x + mean.y * mean.y, 0.01) * mean;
  }
  return result;
}

struct Layer {
  double shift;  // pixels along the mitre
  ImU32 color;
};

// Fills between the layers along `points`, with colours that run from each to the next. Returns the
// number of the first vertex; they come point by point.
unsigned band(ImDrawList* list, std::span<const Point> points, bool closed,
              std::span<const Layer> layers) {
  const std::size_t n = points.size(), strips = closed ? n : n - 1;
  const auto width = static_cast<unsigned>(layers.size());
  list->PrimReserve(static_cast<int>(6 * strips * (width - 1)), static_cast<int>(n * width));
  const unsigned first = list->_VtxCurrentIdx;
  const std::vector<Point> shifts = mitres(points, closed);
  for (std::size_t i = 0; i < n; ++i)
    for (const Layer& layer : layers)
      list->PrimWriteVtx(pixels(points[i] + layer.shift * shifts[i]),
                         ImGui::GetFontTexUvWhitePixel(), layer.color);
  for (std::size_t i = 0; i < strips; ++i)
    for (unsigned k = 0; k + 1 < width; ++k) {
      const auto here = first + width * static_cast<unsigned>(i) + k;
      const auto next = first + width * static_cast<unsigned>((i + 1) % n) + k;
      for (const unsigned corner : {here, next, next + 1, next + 1, here + 1, here})
        list->PrimWriteIdx(static_cast<ImDrawIdx>(corner));
    }
  return first;
}

// A convex polygon with a soft rim.
void fill(ImDrawList* list, std::span<const Point> corners, ImU32 color) {
  double area = 0;
  for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
    area += corners[j].x * corners[i].y - corners[i].x * corners[j].y;
  }
  const double outwards = area < 0 ? 0.5 : -0.5;
  const std::array<Layer, 2> rim{{{-outwards, color}, {outwards, color & ~IM_COL32_A_MASK}}};
  const unsigned first = band(list, corners, true, rim);
  const auto count = static_cast<unsigned>(corners.size());
  list->PrimReserve(static_cast<int>(3 * (count - 2)), 0);
  for (unsigned i = 1; i + 1 < count; ++i)
    for (const unsigned corner : {0U, i, i + 1})
      list->PrimWriteIdx(static_cast<ImDrawIdx>(first + 2 * corner));
}

// A line with soft edges, `thickness` of at least 1 pixel.
void line_along(ImDrawList* list, std::span<const Point> points, bool closed, double thickness,
                ImU32 color) {
  const double inner = (thickness - 1) / 2, outer = (thickness + 1) / 2;
  const ImU32 none = color & ~IM_COL32_A_MASK;
  const std::array<Layer, 4> layers{
      {{-outer, none}, {-inner, color}, {inner, color}, {outer, none}}};
  band(list, points, closed, layers);
}

}  // namespace

// Strokes runs of pixels. A mitre at a sharp corner would be a thorn, and a line's ends are not
// soft: so lines are split at sharp corners and opaque ones get round joints and ends.
class Pen::Stroke {
 public:
  Stroke(ImDrawList* list, Color color, double thickness_pixels, double scale, Dash dash)
      : list_(list),
        color_(packed(color)),
        round_(color.a == 255),
        thickness_(std::max(thickness_pixels, 1.0)),
        scale_(scale),
        dash_(dash) {}

  void add(Point p) {
    last_ = p;
    if (run_.empty() || length(p - run_.back()) >= 0.25) run_.push_back(p);
  }

  void end() {
    if (!run_.empty() && length(last_ - run_.back()) > 0) run_.push_back(last_);
    if (run_.size() > 1) {
      if (dash_ == Dash::solid) solid(run_);
      if (dash_ == Dash::dashed) dashed();
      if (dash_ == Dash::dotted) dotted();
    }
    run_.clear();
  }

 private:
  void dot(Point p) {
    const int corners = std::clamp(static_cast<int>(2 * thickness_) + 8, 12, 64);
    fill(list_, circle_outline(p, thickness_ / 2, corners), color_);
  }

  void bar(Point a, Point b) {
    const double l = length(b - a);
    const Point n = thickness_ / 2 / l * Point{a.y - b.y, b.x - a.x};
    fill(list_, std::array{a + n, a - n, b - n, b + n}, color_);
  }

  void solid(std::span<const Point> run) {
    constexpr std::size_t piece = 8000;  // 4 vertices a point, numbered with 16 bits
    const auto sharp = [&](std::size_t i) {
      const Point in = run[i] - run[i - 1], out = run[i + 1] - run[i];
      return in.x * out.x + in.y * out.y < 0.5 * length(in) * length(out);
    };
    for (std::size_t first = 0; first + 1 < run.size();) {
      std::size_t last = first + 1;
      while (last + 1 < run.size() && last - first < piece && !sharp(last)) ++last;
      if (last == first + 1) {
        bar(run[first], run[last]);
      } else {
        line_along(list_, run.subspan(first, last - first + 1), false, thickness_, color_);
      }
      if (round_ && last + 1 < run.size()) dot(run[last]);
      first = last;
    }
    if (round_ && run.size() > 2 && dash_ == Dash::solid) {
      dot(run.front());
      dot(run.back());
    }
  }

  // Calls visit(point, distance along the run, true at a mark) for every corner and every mark.
  void walk(double first_mark, const auto& next_mark, const auto& visit) const {
    double at = 0, mark = first_mark;
    visit(run_.front(), mark <= 0);
    if (mark <= 0) mark = next_mark(mark);
    for (std::size_t i = 1; i < run_.size(); ++i) {
      const Point from = run_[i - 1], d = run_[i] - from;
      const double l = length(d);
      for (; mark < at + l; mark = next_mark(mark)) visit(from + (mark - at) / l * d, true);
      at += l;
      visit(run_[i], false);
    }
  }

  void dashed() {
    const double on = std::max(6 * scale_, 3 * thickness_), off = 0.7 * on;
    std::vector<Point> dash;
    bool down = true;
    walk(
        on, [&](double mark) { return mark + (down ? on : off); },
        [&](Point p, bool mark) {
          if (down && (dash.empty() || length(p - dash.back()) > 1e-9)) dash.push_back(p);
          if (!mark) return;
          if (down && dash.size() > 1) solid(dash);
          dash.clear();
          down = !down;
          if (down) dash.push_back(p);
        });
    if (dash.size() > 1) solid(dash);
  }

  void dotted() {
    const double step = std::max(2.4 * thickness_, 3.0);
    walk(
        0, [&](double mark) { return mark + step; },
        [&](Point p, bool mark) {
          if (mark) dot(p);
        });
  }

  ImDrawList* list_;
  ImU32 color_;
  bool round_;
  double thickness_, scale_;
  Dash dash_;
  Point last_;
  std::vector<Point> run_;
};

Pen::Pen(ImDrawList* list, const Fonts& fonts, const Theme& theme, double width, double height,
         double scale)
    : list_(list), fonts_(fonts), theme_(theme), width_(width), height_(height), scale_(scale) {}

void Pen::line(Point from, Point to, Color color, double thickness, Dash dash) {
  // A level or upright line is moved by less than a pixel so that its edges are crisp.
  const double width = std::max(std::round(thickness * scale_), 1.0);
  const auto snap = [&](double& a, double& b) {
    if (a != b || dash == Dash::dotted) return false;
    a = b = (std::round(a * scale_ - width / 2) + width / 2) / scale_;
    return true;
  };
  if (snap(from.x, to.x) || snap(from.y, to.y)) thickness = width / scale_;
  const std::array ends{from, to};
  polyline(ends, color, thickness, dash);
}

void Pen::polyline(std::span<const Point> points, Color color, double thickness, Dash dash) {
  if (color.a == 0 || thickness <= 0) return;
  // What is far off the page would cost precision, and a dashed line without end its time.
  const Rect page = Rect{0, 0, width_, height_}.inset(-2 * thickness - 8);
  Stroke stroke(list_, color, thickness * scale_, scale_, dash);
  for (std::size_t i = 1; i < points.size(); ++i) {
    Point a = points[i - 1], b = points[i];
    if (!clip_segment(a, b, page)) {
      stroke.end();
      continue;
    }
    if (a.x != points[i - 1].x || a.y != points[i - 1].y) stroke.end();
    stroke.add(scale_ * a);
    stroke.add(scale_ * b);
    if (b.x != points[i].x || b.y != points[i].y) stroke.end();
  }
  stroke.end();
}

void Pen::polygon(std::span<const Point> corners, Color inside, Color edge, double thickness) {
  if (corners.size() < 3) return;
  Point low = corners[0], high = corners[0];
  std::vector<Point> outline;
  for (const Point& p : corners) {
    if (!finite(p)) return;
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    outline.push_back(scale_ * p);
  }
  const Rect page = Rect{0, 0, width_, height_}.inset(-thickness);
  if (!page.overlaps({low.x, low.y, high.x - low.x, high.y - low.y})) return;
  if (inside.a > 0) fill(list_, outline, packed(inside));
  if (edge.a > 0 && thickness > 0)
    line_along(list_, outline, true, std::max(thickness * scale_, 1.0), packed(edge));
}

void Pen::circle(Point center, double radius, Color fill, Color edge, double thickness) {
  if (!(radius > 0) || !std::isfinite(radius)) return;
  // Leaves the circle by no more than a tenth of a pixel.
  const double angle = 2 * std::acos(1 - std::min(0.1 / (radius * scale_), 0.2));
  const int corners = std::clamp(static_cast<int>(2 * std::numbers::pi / angle), 12, 1000);
  polygon(circle_outline(center, radius, corners), fill, edge, thickness);
}

void Pen::arrow(Point from, Point to, Color color, double thickness) {
  const double size = length(to - from);
  if (!(size > 0) || !std::isfinite(size)) return;
  const double full_head = 3 + 4 * thickness;
  const double shrink = std::min(1.0, size / (1.4 * full_head));
  const double head = shrink * full_head, shaft = shrink * thickness / 2;
  const Point along = 1 / size * (to - from), across{-along.y, along.x};
  const Point neck = to - head * along, end = neck + std::min(0.5, head / 4) * along;
  const std::array bar{from + shaft * across, from - shaft * across, end - shaft * across,
                       end + shaft * across};
  const std::array tip{to, neck + 0.42 * head * across, neck - 0.42 * head * across};
  polygon(bar, color);
  polygon(tip, color);
}

namespace {

constexpr float subscript_size = 0.75f;  ///< of the line's

struct Run {
  std::string_view text;
  bool subscript;
};

/// A letter, `_` and one or two letters, alone as in "k_d h": these are a subscript. In a name with
/// `_` ("semi_implicit_euler") there is none.
std::vector<Run> runs_of(std::string_view utf8) {
  const auto in_word = [&](std::size_t i) {
    return i < utf8.size() && (std::isalnum(static_cast<unsigned char>(utf8[i])) || utf8[i] == '_');
  };
  std::vector<Run> runs;
  std::size_t begin = 0;
  for (std::size_t i = 1; i + 1 < utf8.size(); ++i) {
    if (utf8[i] != '_' || !in_word(i - 1) || !in_word(i + 1)) continue;
    const std::size_t letters = in_word(i + 2) ? 2 : 1;
    if ((i > 1 && in_word(i - 2)) || in_word(i + 1 + letters) || utf8[i + letters] == '_') continue;
    runs.push_back({utf8.substr(begin, i - begin), false});
    runs.push_back({utf8.substr(i + 1, letters), true});
    begin = i + 1 + letters;
  }
  runs.push_back({utf8.substr(begin), false});
  return runs;
}

double width_of(ImFont* face, float size, std::string_view utf8) {
  const char* begin = utf8.data();
  return face->CalcTextSizeA(size, FLT_MAX, 0, begin, begin + utf8.size()).x;
}

}  // namespace

void Pen::text(Point at, std::string_view utf8, Color color, Font font, Align align, bool halo) {
  if (!finite(at) || utf8.empty()) return;
  ImFont* face = fonts_[index(font)];
  const float size = font_pixels(index(font), scale_);
  if (align == Align::center) at.x -= text_width(utf8, font) / 2;
  if (align == Align::right) at.x -= text_width(utf8, font);
  const auto put = [&](Point pixel, Color ink) {
    for (const Run& run : runs_of(utf8)) {
      const float height = run.subscript ? subscript_size * size : size;
      const Point low{0, run.subscript ? std::round(0.45 * size) : 0.0};
      list_->AddText(face, height, pixels(pixel + low), packed(ink), run.text.data(),
                     run.text.data() + run.text.size());
      pixel.x += std::round(width_of(face, height, run.text));
    }
  };
  // Whole pixels keep the glyphs as sharp as they were made.
  const Point corner{std::round(at.x * scale_), std::round(at.y * scale_ - size / 2)};
  if (halo) {
    const double radius = std::max(2 * scale_, 1.0);
    for (int i = 0; i < 16; ++i) {
      const double phi = std::numbers::pi * i / 8;
      put(corner + Point{std::round(radius * std::cos(phi)), std::round(radius * std::sin(phi))},
          theme_.paper);
    }
  }
  put(corner, color);
}

double Pen::text_width(std::string_view utf8, Font font) const {
  const float size = font_pixels(index(font), scale_);
  double width = 0;
  for (const Run& run : runs_of(utf8))
    width += width_of(fonts_[index(font)], run.subscript ? subscript_size * size : size, run.text);
  return width / scale_;
}

double Pen::line_height(Font font) { return font_heights[index(font)]; }

std::vector<std::string> Pen::wrap(std::string_view utf8, Font font, double width) const {
  std::vector<std::string> lines;
  while (!utf8.empty()) {
    const std::string_view word = utf8.substr(0, utf8.find(' '));
    utf8.remove_prefix(std::min(word.size() + 1, utf8.size()));
    if (word.empty()) continue;
    if (lines.empty()) {
      lines.emplace_back(word);
    } else if (std::string longer = lines.back() + " " + std::string(word);
               text_width(longer, font) <= width) {
      lines.back() = std::move(longer);
    } else {
      lines.emplace_back(word);
    }
  }
  return lines;
}

void Pen::clip(const Rect& area) {
  // Whole pixels, which the window's renderer and the pictures' agree on.
  const auto whole = [&](double x, double y) {
    return pixels({std::round(scale_ * x), std::round(scale_ * y)});
  };
  list_->PushClipRect(whole(area.left, area.top), whole(area.right(), area.bottom()), true);
}

void Pen::unclip() { list_->PopClipRect(); }

}  // namespace draw
