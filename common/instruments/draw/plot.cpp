#include "instruments/draw/plot.hpp"

#include <array>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "instruments/draw/ticks.hpp"

namespace draw {
namespace {

constexpr double tick_mark = 4, gap = 5, sample_width = 30, marker_radius = 4;

struct Range {
  double low, high;
};

bool shown(double value, bool log) {
  return std::isfinite(value) && std::abs(value) < 1e280 && (!log || value > 1e-280);
}

// From the points, and a little wider where they would touch the frame. An empty or flat range
// gets some width, so that a single value stands in the middle.
Range range(const Plot& plot, double Point::*coordinate, const Axis& axis, bool pad) {
  const auto usable = [&](const std::optional<double>& limit) {
    return !limit || shown(*limit, axis.log);
  };
  if (!usable(axis.min) || !usable(axis.max) ||
      (axis.min && axis.max && !(*axis.min < *axis.max))) {
    throw std::invalid_argument("the axis \"" + axis.label + "\" needs finite limits, min < max" +
                                (axis.log ? ", both positive" : ""));
  }
  const auto to = [&](double v) { return axis.log ? std::log10(v) : v; };
  const auto from = [&](double v) { return axis.log ? std::pow(10, v) : v; };
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Curve& curve : plot.curves) {
    for (const Point& p : curve.points) {
      if (!shown(p.x, plot.x.log) || !shown(p.y, plot.y.log)) continue;
      low = std::min(low, to(p.*coordinate));
      high = std::max(high, to(p.*coordinate));
    }
  }
  if (low > high) {
    low = 0;
    high = 1;
  } else if (!(high - low > 1e-9 * std::max(std::abs(low), std::abs(high)))) {
    const double half = axis.log ? 0.5 : low != 0 ? 0.1 * std::abs(low) : 1;
    low -= half;
    high += half;
  }
  const double margin = pad ? 0.04 * (high - low) : 0;
  low = axis.min ? to(*axis.min) : low - margin;
  high = axis.max ? to(*axis.max) : high + margin;
  // One limit was set, and all points are on the other side of it.
  if (!(low < high)) (axis.max ? low : high) = axis.max ? high - 1 : low + 1;
  return {from(low), from(high)};
}

// From a value to its place on the page.
struct Scale {
  Range range;
  bool log;
  double from, to;

  double operator()(double value) const {
    if (!shown(value, log)) return std::numeric_limits<double>::quiet_NaN();
    const double part = log ? std::log(value / range.low) / std::log(range.high / range.low)
                            : (value - range.low) / (range.high - range.low);
    return from + part * (to - from);
  }
};

// Which cells of a fine grid over the plot the curves pass through.
class Occupancy {
 public:
  explicit Occupancy(const Rect& frame)
      : frame_(frame),
        columns_(static_cast<int>(frame.width / cell) + 1),
        rows_(static_cast<int>(frame.height / cell) + 1),
        taken_(static_cast<std::size_t>(columns_ * rows_)) {}

  void add(Point a, Point b) {
    if (!clip_segment(a, b, frame_)) return;
    const int steps = static_cast<int>(length(b - a) / (cell / 2)) + 1;
    for (int i = 0; i <= steps; ++i) {
      const Point p = a + static_cast<double>(i) / steps * (b - a);
      taken_[index(column(p.x), row(p.y))] = 1;
    }
  }

  int taken(const Rect& r) const {
    int count = 0;
    for (int j = row(r.top); j <= row(r.bottom()); ++j) {
      for (int i = column(r.left); i <= column(r.right()); ++i) count += taken_[index(i, j)];
    }
    return count;
  }

 private:
  static constexpr double cell = 5;

  int column(double x) const {
    return std::clamp(static_cast<int>((x - frame_.left) / cell), 0, columns_ - 1);
  }
  int row(double y) const {
    return std::clamp(static_cast<int>((y - frame_.top) / cell), 0, rows_ - 1);
  }
  std::size_t index(int i, int j) const { return static_cast<std::size_t>(j * columns_ + i); }

  Rect frame_;
  int columns_, rows_;
  std::vector<char> taken_;
};

// A shape for each curve, for readers who cannot tell the colours apart: disc, square, triangle,
// diamond, triangle on its point, star.
void draw_marker(Pen& pen, Point at, std::size_t shape, double size, Color fill) {
  const double radius = size * marker_radius;
  const auto polygon = [&](int corners, double turns, double inner = 1) {  // thin: an arm of a star
    std::vector<Point> outline;
    for (int k = 0; k < corners; ++k) {
      const double phi = 2 * std::numbers::pi * (turns + static_cast<double>(k) / corners);
      const double part = k % 2 == 1 ? inner : 1;
      outline.push_back(at + 1.25 * part * radius * Point{std::cos(phi), std::sin(phi)});
    }
    pen.polygon(outline, fill, inner < 1 ? transparent : pen.theme().paper, 1);
  };
  switch (shape % 6) {
    case 0:
      return pen.circle(at, radius, fill, pen.theme().paper, 1);
    case 1:
      return polygon(4, 0.125);
    case 2:
      return polygon(3, -0.25);
    case 3:
      return polygon(4, 0);
    case 4:
      return polygon(3, 0.25);
    default:
      polygon(4, 0, 0.4);
      return polygon(4, 0.25, 0.4);
  }
}

class Plotter {
 public:
  Plotter(Pen& pen, const Rect& area, const Plot& plot) : pen_(pen), area_(area), plot_(plot) {
    bool markers = false;
    for (const Curve& curve : plot.curves) markers = markers || curve.markers;
    x_range_ = range(plot, &Point::x, plot.x, markers || plot.x.log);
    y_range_ = range(plot, &Point::y, plot.y, true);
    if (!plot.slopes.empty() && !(plot.x.log && plot.y.log)) {
      throw std::invalid_argument("slopes need two logarithmic axes");
    }
    for (std::size_t i = 0; i < plot.curves.size(); ++i) {
      if (!plot.curves[i].label.empty()) entries_.push_back(i);
    }
  }

  void draw() {
    Legend legend = entries_.empty() ? Legend::none : plot_.legend;
    lay_out(legend == Legend::above);
    if (legend == Legend::automatic) {
      legend = free_corner();
      if (legend == Legend::above) lay_out(true);
    }
    draw_tiles();
    draw_axes();
    const bool in_corner = legend != Legend::above && legend != Legend::none;
    std::vector<Rect> blocked;
    if (in_corner) blocked.push_back(box_in(legend));
    for (const Slope& slope : plot_.slopes) draw_slope(slope);
    for (const Slope& slope : plot_.slopes) label_slope(slope, blocked);
    for (std::size_t i = 0; i < plot_.curves.size(); ++i) draw_curve(i);
    if (legend == Legend::above) draw_rows();
    if (in_corner) draw_box(box_in(legend));
  }

 private:
  static double line_height() { return 1.2 * Pen::line_height(Font::small); }
  static double title_height() { return 1.25 * Pen::line_height(Font::bold); }

  Color color(std::size_t i) const {
    const auto& series = pen_.theme().series;
    return plot_.curves[i].color.value_or(series[i % series.size()]);
  }
  Point place(Point p) const { return {x_(p.x), y_(p.y)}; }

  double entry_width(std::size_t i) const {
    return sample_width + gap + pen_.text_width(plot_.curves[i].label, Font::small);
  }

  // Finds the frame from what stands around it, top to bottom, then left to right.
  void lay_out(bool legend_above) {
    title_ = pen_.wrap(plot_.title, Font::bold, area_.width);
    x_label_ = pen_.wrap(plot_.x.label, Font::small, area_.width);
    y_label_ = pen_.wrap(plot_.y.label, Font::small, area_.width);
    rows_.clear();
    if (legend_above) {
      double x = area_.right() + 1;
      for (const std::size_t i : entries_) {
        if (x + entry_width(i) > area_.right()) {
          rows_.emplace_back();
          x = area_.left;
        }
        rows_.back().push_back(i);
        x += entry_width(i) + 4 * gap;
      }
    }
    const auto count = [](const auto& lines) { return static_cast<double>(lines.size()); };
    const double line = line_height();
    const double above = count(title_) * title_height() + (title_.empty() ? 0 : gap / 2) +
                         (count(rows_) + count(y_label_)) * line + gap;
    const double below = tick_mark + gap + line + count(x_label_) * line;
    frame_.top = area_.top + above;
    frame_.height = std::max(area_.height - above - below, 20.0);
    y_ticks_ = fitting_ticks(pen_, y_range_.low, y_range_.high, plot_.y.log, frame_.height, false);
    double widest = 0;
    for (const Tick& tick : y_ticks_) {
      widest = std::max(widest, pen_.text_width(tick.label, Font::small));
    }
    const double left = widest + tick_mark + gap, right = 16;
    frame_.left = area_.left + left;
    frame_.width = std::max(area_.width - left - right, 20.0);
    x_ticks_ = fitting_ticks(pen_, x_range_.low, x_range_.high, plot_.x.log, frame_.width, true);
    x_ = {x_range_, plot_.x.log, frame_.left, frame_.right()};
    y_ = {y_range_, plot_.y.log, frame_.bottom(), frame_.top};
    occupancy_ = Occupancy(frame_);
    for (const Curve& curve : plot_.curves) {
      for (std::size_t i = 0; i < curve.points.size(); ++i) {
        const Point p = place(curve.points[i]), half{marker_radius, 0};
        if (curve.line && i > 0) occupancy_.add(place(curve.points[i - 1]), p);
        if (curve.markers) occupancy_.add(p - half, p + half);
      }
    }
  }

  void draw_axes() {
    const Theme& colors = pen_.theme();
    const double line = line_height();
    double y = area_.top + title_height() / 2;
    for (const std::string& text : title_) {
      pen_.text({area_.left, y}, text, colors.ink, Font::bold);
      y += title_height();
    }
    y = frame_.top - gap - line * (static_cast<double>(y_label_.size()) - 0.5);
    for (const std::string& text : y_label_) {
      pen_.text({area_.left, y}, text, colors.ink, Font::small);
      y += line;
    }
    y = frame_.bottom() + tick_mark + gap + 1.5 * line;
    for (const std::string& text : x_label_) {
      const double half = pen_.text_width(text, Font::small) / 2;
      pen_.text({std::max(frame_.center().x, area_.left + half), y}, text, colors.ink, Font::small,
                Align::center);
      y += line;
    }
    for (const Tick& tick : x_ticks_) {
      const double x = x_(tick.value), half = pen_.text_width(tick.label, Font::small) / 2;
      const bool major = !tick.label.empty();
      if (major) pen_.line({x, frame_.top}, {x, frame_.bottom()}, colors.grid, 1);
      pen_.line({x, frame_.bottom()}, {x, frame_.bottom() + tick_mark * (major ? 1 : 0.6)},
                colors.muted, 1);
      pen_.text({std::min(x, area_.right() - half), frame_.bottom() + tick_mark + line / 2},
                tick.label, colors.muted, Font::small, Align::center);
    }
    for (const Tick& tick : y_ticks_) {
      const bool major = !tick.label.empty();
      y = y_(tick.value);
      if (major) pen_.line({frame_.left, y}, {frame_.right(), y}, colors.grid, 1);
      pen_.line({frame_.left - tick_mark * (major ? 1 : 0.6), y}, {frame_.left, y}, colors.muted,
                1);
      pen_.text({frame_.left - tick_mark - gap, y}, tick.label, colors.muted, Font::small,
                Align::right);
    }
    pen_.line({frame_.left, frame_.top}, {frame_.left, frame_.bottom()}, colors.muted, 1);
    pen_.line({frame_.left, frame_.bottom()}, {frame_.right(), frame_.bottom()}, colors.muted, 1);
  }

  void draw_tiles() {
    pen_.clip(frame_);
    for (const auto& [low, high, fill] : plot_.tiles) {
      const Point a = place(low), b = place(high);
      fill_box({a.x, b.y, b.x - a.x, a.y - b.y}, fill, transparent);
    }
    pen_.unclip();
  }

  std::size_t marker(std::size_t i) const { return plot_.curves[i].marker.value_or(i); }

  void draw_curve(std::size_t i) {
    const Curve& curve = plot_.curves[i];
    std::vector<Point> points;
    points.reserve(curve.points.size());
    for (const Point& p : curve.points) points.push_back(place(p));
    if (curve.line) {
      pen_.clip(frame_);
      pen_.polyline(points, color(i), curve.thickness, curve.dash);
      pen_.unclip();
    }
    if (!curve.markers) return;
    for (std::size_t k = curve.mark_every / 2; k < points.size(); k += curve.mark_every)
      if (frame_.inset(-0.5).contains(points[k]))
        draw_marker(pen_, points[k], marker(i), curve.marker_size, color(i));
  }

  // The part of a slope line inside the frame; false when there is none.
  bool slope_line(const Slope& slope, Point& a, Point& b) const {
    const auto y = [&](double x) {
      return slope.through.y * std::pow(x / slope.through.x, slope.order);
    };
    a = place({x_range_.low, y(x_range_.low)});
    b = place({x_range_.high, y(x_range_.high)});
    return clip_segment(a, b, frame_);
  }

  void draw_slope(const Slope& slope) {
    Point a, b;
    if (slope_line(slope, a, b)) pen_.line(a, b, pen_.theme().muted, 1, Dash::dashed);
  }

  // On its line or beside it, where it covers least; rather near an end than in the middle.
  void label_slope(const Slope& slope, std::vector<Rect>& blocked) {
    Point a, b;
    if (slope.label.empty() || !slope_line(slope, a, b) || length(b - a) == 0) return;
    const double width = pen_.text_width(slope.label, Font::small) + 4;
    const double height = Pen::line_height(Font::small);
    const Point along = 1 / length(b - a) * (b - a), across{-along.y, along.x};
    const double beside = (std::abs(across.x) * width + std::abs(across.y) * height) / 2 + 1;
    const Rect inner{frame_.left + 2, frame_.top, frame_.width - 2, frame_.height - 2};
    double best = 1000;  // the cost of a place that cannot be read
    Rect chosen;
    for (const int side : {0, -1, 1}) {
      for (int i = 0; i <= 400; ++i) {
        const Rect box = centered(a + i / 400.0 * (b - a) + side * beside * across, width, height);
        double cost = occupancy_.taken(box) + std::min(i, 400 - i) / 400.0 + (side == 0 ? 0 : 0.6);
        for (const Rect& other : blocked) cost += box.inset(-2).overlaps(other) ? 1000 : 0;
        if (cost >= best || !inner.contains(box)) continue;
        best = cost;
        chosen = box;
      }
    }
    if (best == 1000) return;
    fill_box(chosen, pen_.theme().paper, transparent);
    pen_.text(chosen.center(), slope.label, pen_.theme().muted, Font::small, Align::center);
    blocked.push_back(chosen);
  }

  Rect box_in(Legend corner) const {
    double width = 0;
    for (const std::size_t i : entries_) width = std::max(width, entry_width(i));
    width += 4 * gap;
    const double height = line_height() * static_cast<double>(entries_.size()) + 2 * gap;
    const bool left = corner == Legend::top_left || corner == Legend::bottom_left;
    const bool top = corner == Legend::top_left || corner == Legend::top_right;
    const Rect inner = frame_.inset(8);
    return {left ? inner.left : inner.right() - width, top ? inner.top : inner.bottom() - height,
            width, height};
  }

  Legend free_corner() const {
    for (const Legend corner :
         {Legend::top_right, Legend::top_left, Legend::bottom_right, Legend::bottom_left}) {
      const Rect box = box_in(corner);
      if (frame_.contains(box) && occupancy_.taken(box.inset(-4)) == 0) return corner;
    }
    return Legend::above;
  }

  void draw_entry(Point left, std::size_t i) {
    draw_sample(pen_, left, plot_.curves[i], color(i), marker(i));
    pen_.text(left + Point{sample_width + gap, 0}, plot_.curves[i].label, pen_.theme().ink,
              Font::small);
  }

  void fill_box(const Rect& box, Color fill, Color edge) {
    const std::array corners{Point{box.left, box.top}, Point{box.right(), box.top},
                             Point{box.right(), box.bottom()}, Point{box.left, box.bottom()}};
    pen_.polygon(corners, fill, edge, 1);
  }

  void draw_box(const Rect& box) {
    const Theme& colors = pen_.theme();
    fill_box(box, colors.paper.faded(0.88), colors.grid);
    double y = box.top + gap + line_height() / 2;
    for (const std::size_t i : entries_) {
      draw_entry({box.left + 2 * gap, y}, i);
      y += line_height();
    }
  }

  void draw_rows() {
    double y = area_.top + static_cast<double>(title_.size()) * title_height() + line_height() / 2;
    for (const auto& row : rows_) {
      double x = area_.left;
      for (const std::size_t i : row) {
        draw_entry({x, y}, i);
        x += entry_width(i) + 4 * gap;
      }
      y += line_height();
    }
  }

  Pen& pen_;
  Rect area_;
  const Plot& plot_;
  Range x_range_{}, y_range_{};
  std::vector<std::size_t> entries_;  // the curves with an entry in the legend

  std::vector<std::string> title_, x_label_, y_label_;
  std::vector<std::vector<std::size_t>> rows_;  // of the legend above the plot
  Rect frame_;
  std::vector<Tick> x_ticks_, y_ticks_;
  Scale x_{}, y_{};
  Occupancy occupancy_{Rect{}};
};

}  // namespace

void draw_sample(Pen& pen, Point left, const Curve& curve, Color color, std::size_t marker) {
  const Point right = left + Point{sample_width, 0};
  if (curve.line) pen.line(left, right, color, curve.thickness, curve.dash);
  if (curve.markers)
    draw_marker(pen, left + Point{sample_width / 2, 0}, marker, curve.marker_size, color);
}

void draw_plot(Pen& pen, const Rect& area, const Plot& plot) { Plotter(pen, area, plot).draw(); }

}  // namespace draw
