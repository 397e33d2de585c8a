#pragma once

#include <algorithm>
#include <cmath>

namespace draw {

/// A point of the page (in points, origin top left, y down) or of the world (in metres, y down).
struct Point {
  double x = 0, y = 0;
};

inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
inline Point operator*(double s, Point p) { return {s * p.x, s * p.y}; }
inline double length(Point p) { return std::hypot(p.x, p.y); }
inline bool finite(Point p) { return std::isfinite(p.x) && std::isfinite(p.y); }

/// A rectangle of the page, in points.
struct Rect {
  double left = 0, top = 0, width = 0, height = 0;

  double right() const { return left + width; }
  double bottom() const { return top + height; }
  Point center() const { return {left + width / 2, top + height / 2}; }
  /// Smaller by `margin` on every side; larger when it is negative.
  Rect inset(double margin) const {
    return {left + margin, top + margin, width - 2 * margin, height - 2 * margin};
  }
  bool contains(Point p) const {
    return p.x >= left && p.x <= right() && p.y >= top && p.y <= bottom();
  }
  bool contains(const Rect& r) const {
    return r.left >= left && r.right() <= right() && r.top >= top && r.bottom() <= bottom();
  }
  bool overlaps(const Rect& r) const {
    return r.left < right() && r.right() > left && r.top < bottom() && r.bottom() > top;
  }
};

inline Rect centered(Point center, double width, double height) {
  return {center.x - width / 2, center.y - height / 2, width, height};
}

/// Cuts the segment a–b down to its part inside `r`; false when there is none.
inline bool clip_segment(Point& a, Point& b, const Rect& r) {
  if (!finite(a) || !finite(b) || !finite(b - a)) return false;
  // Keeps what has sign * u <= sign * limit. Counted from the inner end, which is precise however
  // far away the outer one is.
  const auto cut = [&](double Point::*u, double Point::*v, double sign, double limit) {
    const bool a_out = sign * (a.*u - limit) > 0, b_out = sign * (b.*u - limit) > 0;
    if (a_out && b_out) return false;
    if (a_out == b_out) return true;
    Point& out = a_out ? a : b;
    const Point& in = a_out ? b : a;
    out.*v = in.*v + (limit - in.*u) / (out.*u - in.*u) * (out.*v - in.*v);
    out.*u = limit;
    return true;
  };
  return cut(&Point::x, &Point::y, -1, r.left) && cut(&Point::x, &Point::y, 1, r.right()) &&
         cut(&Point::y, &Point::x, -1, r.top) && cut(&Point::y, &Point::x, 1, r.bottom());
}

}  // namespace draw
