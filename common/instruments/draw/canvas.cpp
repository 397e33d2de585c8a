#include "instruments/draw/canvas.hpp"

#include <array>
#include <numbers>
#include <stdexcept>

#include "instruments/draw/ticks.hpp"

namespace draw {
namespace {

Point direction(double angle) { return {std::cos(angle), std::sin(angle)}; }

double widest_label(const Pen& pen, const std::vector<Tick>& ticks) {
  double widest = 0;
  for (const Tick& tick : ticks) {
    widest = std::max(widest, pen.text_width(tick.label, Font::small));
  }
  return widest;
}

}  // namespace

Canvas::Canvas(Pen& pen, const Rect& area, const View& view)
    : pen_(pen), view_(view), outer_(area) {
  const double width = view.right - view.left, height = view.bottom - view.top;
  if (!(width > 0 && height > 0 && std::isfinite(width) && std::isfinite(height))) {
    throw std::invalid_argument("the view of a canvas needs left < right and top < bottom");
  }
  fit(area.inset(8));  // so that what stands at the edge of the view is not cut off
  pen_.clip(area);
}

Canvas::~Canvas() {
  for (const ArrowLabel& label : labels_) place(label);
  pen_.unclip();
}

void Canvas::fit(const Rect& area) {
  // Margins may use up a small area; the scale must stay positive all the same.
  area_ = {area.left, area.top, std::max(area.width, 1.0), std::max(area.height, 1.0)};
  scale_ =
      std::min(area_.width / (view_.right - view_.left), area_.height / (view_.bottom - view_.top));
}

Lens Canvas::lens() const {
  return {area_, {(view_.left + view_.right) / 2, (view_.top + view_.bottom) / 2}, scale_};
}

Point Canvas::page(Point world) {
  drawn_ = true;
  return to_page(world.x, world.y);
}

void Canvas::axes(std::string_view unit) {
  if (drawn_) throw std::logic_error("the axes of a canvas must be drawn before its scene");
  const Theme& colors = theme();
  const double line = Pen::line_height(Font::small), mark = 4, gap = 4;
  const auto y_ticks = [&] {
    const double top = (view_.top + view_.bottom - area_.height / scale_) / 2;
    return fitting_ticks(pen_, top, top + area_.height / scale_, false, area_.height, false);
  };
  // The width of the numbers depends on the scale, and that on the room they leave.
  for (int pass = 0; pass < 2; ++pass) {
    const double left = widest_label(pen_, y_ticks()) + mark + 2 * gap;
    const double above = line + gap, below = 2 * line + mark + 2 * gap, right = 2 * gap;
    fit({outer_.left + left, outer_.top + above, outer_.width - left - right,
         outer_.height - above - below});
  }
  const double left = (view_.left + view_.right - area_.width / scale_) / 2;
  const auto x_ticks =
      fitting_ticks(pen_, left, left + area_.width / scale_, false, area_.width, true);

  const double bottom = area_.bottom();
  for (const Tick& tick : x_ticks) {
    const double x = to_page(tick.value, 0).x;
    const double half = pen_.text_width(tick.label, Font::small) / 2;
    pen_.line({x, area_.top}, {x, bottom}, colors.grid, 1);
    pen_.line({x, bottom}, {x, bottom + mark}, colors.muted, 1);
    pen_.text({std::clamp(x, outer_.left + half, outer_.right() - half),
               bottom + mark + gap / 2 + line / 2},
              tick.label, colors.muted, Font::small, Align::center);
  }
  for (const Tick& tick : y_ticks()) {
    const double y = to_page(0, tick.value).y;
    pen_.line({area_.left, y}, {area_.right(), y}, colors.grid, 1);
    pen_.line({area_.left - mark, y}, {area_.left, y}, colors.muted, 1);
    pen_.text({area_.left - mark - gap, y}, tick.label, colors.muted, Font::small, Align::right);
  }
  for (const double x : {area_.left, area_.right()}) {
    pen_.line({x, area_.top}, {x, bottom}, colors.muted.faded(0.6), 1);
  }
  for (const double y : {area_.top, bottom}) {
    pen_.line({area_.left, y}, {area_.right(), y}, colors.muted.faded(0.6), 1);
  }
  const std::string suffix = " [" + std::string(unit) + "]";
  pen_.text({area_.center().x, outer_.bottom() - line / 2}, "x" + suffix, colors.ink, Font::small,
            Align::center);
  pen_.text({outer_.left, outer_.top + line / 2}, "y" + suffix + ", down", colors.ink, Font::small);
  pen_.unclip();
  pen_.clip(area_);
}

void Canvas::curve(std::span<const Point> points, Color color, double thickness, Dash dash) {
  std::vector<Point> on_page;
  on_page.reserve(points.size());
  for (const Point& p : points) on_page.push_back(page(p));
  pen_.polyline(on_page, color, thickness, dash);
}

void Canvas::disc(Point center, double radius, Color fill, Color edge) {
  pen_.circle(page(center), scale_ * radius, fill, edge);
}

void Canvas::bead(Point center, double radius_points, Color fill, Color edge) {
  const Point at = page(center);
  beads_.push_back(centered(at, 2 * radius_points, 2 * radius_points));
  pen_.circle(at, radius_points, fill, edge);
}

void Canvas::box(Point center, double width, double height, double angle, Color fill, Color edge) {
  const Point along = width / 2 * direction(angle);
  const Point across = height / 2 * direction(angle + std::numbers::pi / 2);
  const std::array corners{page(center + along + across), page(center - along + across),
                           page(center - along - across), page(center + along - across)};
  pen_.polygon(corners, fill, edge);
}

void Canvas::link(Point a, Point b, double width_points, Color fill, Color edge) {
  const std::array ends{page(a), page(b)};
  const Point d = ends[1] - ends[0];
  if (!finite(d)) return;
  constexpr int steps = 16;
  const double start = std::atan2(d.y, d.x) + std::numbers::pi / 2;
  std::vector<Point> outline;
  for (int i = 0; i <= 2 * steps + 1; ++i) {
    const bool second = i > steps;
    const double phi = start + std::numbers::pi * (i - second) / steps;
    outline.push_back(ends[second] + width_points / 2 * direction(phi));
  }
  pen_.polygon(outline, fill, edge);
}

void Canvas::arrow(Point from, Point vector, Color color, std::string_view label) {
  const Point tail = page(from), head = page(from + vector), d = head - tail;
  pen_.arrow(tail, head, color);
  if (!finite(d) || !(length(d) > 0)) return;
  arrows_.push_back({tail, head});
  if (!label.empty()) labels_.push_back({{tail, head}, std::string(label), color});
}

double Canvas::cover(const Rect& text) const {
  double sum = area_.inset(2).contains(text) ? 0 : 100;
  for (const Rect& other : texts_) sum += 10 * text.overlaps(other);
  for (auto [a, b] : arrows_) sum += 4 * clip_segment(a, b, text);
  for (const Rect& bead : beads_) sum += 3 * text.overlaps(bead);
  return sum;
}

void Canvas::place(const ArrowLabel& label) {
  const double width = pen_.text_width(label.text), height = Pen::line_height(Font::text);
  const auto& [tail, head] = label.arrow;
  const Point d = head - tail, along = 1 / length(d) * d, across{-along.y, along.x};
  // The box of the text touches the ray from p along n with the edge or corner that looks back.
  const auto beyond = [&](Point p, Point n, double gap) {
    const double longest = std::max(std::abs(n.x), std::abs(n.y));
    return p + gap * n + 0.5 / longest * Point{n.x * width, n.y * height};
  };
  // Beyond the head at best, else beside it, beside the middle, behind the tail.
  const Point middle = tail + 0.5 * d, slant = std::sqrt(0.5) * (along + across),
              other_slant = std::sqrt(0.5) * (along - across);
  Point best;
  double least = 1e300;
  for (const Point at :
       {beyond(head, along, 6), beyond(head, across, 9), beyond(head, -1 * across, 9),
        beyond(head, slant, 8), beyond(head, other_slant, 8), beyond(middle, across, 9),
        beyond(middle, -1 * across, 9), beyond(tail, -1 * along, 14)}) {
    const double hidden = cover(centered(at, width, height));
    if (hidden >= least) continue;
    best = at;
    least = hidden;
  }
  text(best, label.text, label.color, Font::text, Align::center);
}

void Canvas::label(Point at, std::string_view what, Color color, Font font, Align align,
                   Point offset_points) {
  text(page(at) + offset_points, what, color, font, align);
}

void Canvas::text(Point at, std::string_view what, Color color, Font font, Align align) {
  const double width = pen_.text_width(what, font), margin = 3;
  const double before = align == Align::left ? 0 : align == Align::right ? width : width / 2;
  const double half = Pen::line_height(font) / 2;
  // min and max, not clamp: a text larger than the canvas has no room to be kept in.
  at.x = std::max(area_.left + margin + before,
                  std::min(at.x, area_.right() - margin - width + before));
  at.y = std::max(area_.top + margin + half, std::min(at.y, area_.bottom() - margin - half));
  texts_.push_back({at.x - before, at.y - half, width, 2 * half});
  pen_.text(at, what, color, font, align, true);
}

void Canvas::pin(Point at) {
  const Point center = page(at);
  beads_.push_back(centered(center, 9, 9));
  pen_.circle(center, 4.5, theme().paper, theme().ink, 1.6);
  pen_.circle(center, 1.4, theme().ink);
}

void Canvas::gap(Point a, Point b) {
  constexpr double visible = 2;  // points
  const std::array ends{page(a), page(b)};
  if (!(length(ends[1] - ends[0]) > visible)) return;
  const Color color = theme().warning;
  pen_.line(ends[0], ends[1], color);
  for (const Point& end : ends) {
    beads_.push_back(centered(end, 9, 9));
    pen_.circle(end, 4.5, theme().paper, color);
    pen_.circle(end, 1.4, color);
  }
}

void Canvas::ground(Point at, double angle, double width_points) {
  constexpr double depth = 9, spacing = 8;
  const double half = width_points / 2;
  const Point center = page(at), along = direction(angle), down{-along.y, along.x};
  const Color color = theme().track;
  for (double s = -half + spacing; s <= half; s += spacing) {
    const Point top = center + s * along;
    pen_.line(top, top - spacing * along + depth * down, color, 1.2);
  }
  pen_.line(center - half * along, center + half * along, color, 2);
}

void Canvas::force_scale(double metres_per_newton) {
  if (!(metres_per_newton > 0 && std::isfinite(metres_per_newton))) return;
  drawn_ = true;
  const double points = scale_ * metres_per_newton;
  const double wanted = std::min(area_.width / 4, 140.0) / points;
  // The first of the fewest ticks beyond zero: 1, 2 or 5 times a power of ten.
  std::vector<Tick> ticks;
  for (int n = 2; ticks.size() < 2; ++n) ticks = linear_ticks(0, wanted, n);
  const double size = ticks[1].value * points, line = Pen::line_height(Font::small);
  const Point right{area_.right() - 14, area_.bottom() - 14}, left{right.x - size, right.y};
  const Color color = theme().muted;
  pen_.line(left, right, color, 1.6);
  for (const Point& end : {left, right}) pen_.line(end - Point{0, 4}, end + Point{0, 4}, color);
  text({(left.x + right.x) / 2, right.y - 5 - line / 2}, ticks[1].label + " N", color, Font::small,
       Align::center);
}

void Canvas::turn(Point center, double radius, double from, double to, Color color,
                  std::string_view label) {
  const Point middle = page(center);
  constexpr int pieces = 48;
  std::vector<Point> arc;
  // The head covers the last of the way.
  const double head = std::min(14 / radius, 0.9 * std::abs(to - from)) * (to < from ? -1 : 1);
  for (int i = 0; i <= pieces; ++i)
    arc.push_back(middle + radius * direction(from + (to - 0.6 * head - from) * i / pieces));
  pen_.polyline(arc, color, 2.2);
  pen_.arrow(middle + radius * direction(to - head), middle + radius * direction(to), color);
  if (label.empty()) return;
  const Point out = direction((from + to) / 2);
  const double width = pen_.text_width(label);
  text(middle + (radius + 8) * out + Point{0.5 * width * out.x, 9 * out.y}, label, color,
       Font::text, Align::center);
}

void Canvas::origin(Point at) {
  constexpr double size = 34;
  const Point o = page(at), x = o + Point{size, 0}, y = o + Point{0, size};
  const Color color = theme().muted;
  pen_.arrow(o, x, color, 1.4);
  pen_.arrow(o, y, color, 1.4);
  pen_.circle(o, 2.2, color);
  text(x + Point{5, 0}, "x", color, Font::small, Align::left);
  text(y + Point{0, 8}, "y", color, Font::small, Align::center);
}

}  // namespace draw
