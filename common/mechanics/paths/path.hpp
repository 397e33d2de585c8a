#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace paths {

using Eigen::Vector2d;
using Points = std::vector<Vector2d>;

/// Where a path is at q [m], and its first two derivatives by q, x′ and x″.
struct Place {
  Vector2d x, d, dd;
};

/// A path x(q) from q = first to q = last; a value, made by the functions below, which throw
/// std::invalid_argument where their parameters make no path. y points down.
struct Path {
  std::function<Place(double q)> formula;  ///< goes on a little beyond both ends
  double first, last;
  std::vector<double> knots = {};  ///< in between: where a derivative jumps
  bool closed = false;             ///< it ends where it begins, and q counts on

  /// At a knot what begins there.
  Place operator()(double q) const { return formula(q - turns(q) * (last - first)); }
  /// At a knot what ends there.
  Place behind(double q) const { return (*this)(q - rounding * (last - first)); }
  /// How often q has gone around a closed path.
  double turns(double q) const { return closed ? std::floor((q - first) / (last - first)) : 0.0; }
  /// Whether q is a knot, or where a closed path begins again.
  bool is_knot(double q) const {
    const double at = q - turns(q) * (last - first), near = rounding * (last - first);
    const auto knot = std::lower_bound(knots.begin(), knots.end(), at - near);
    return (knot != knots.end() && *knot <= at + near) ||
           (closed && (at <= first + near || at >= last - near));
  }
  static constexpr double rounding = 1e-14;  ///< of the range
};

/// The largest distance [m] of a point from the first.
inline double extent(const Points& points) {
  double most = 0.0;
  for (const Vector2d& point : points) most = std::max(most, (point - points[0]).norm());
  return most;
}

/// Whether two points of a path of this extent are one but for rounding.
inline bool meet(const Vector2d& a, const Vector2d& b, double extent) {
  return (a - b).norm() <= 1e-9 * extent + 1e-15 * a.norm();
}

inline std::string in_words(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.15g", value);
  return text;
}
inline std::string in_words(const Vector2d& x) {
  return std::string("(").append(in_words(x.x())).append(", ").append(in_words(x.y())).append(")");
}

/// For the functions below: so many points, not all one and, where pieces would have no length
/// else, no two in a row.
inline void check(const std::string& name, const Points& points, std::size_t least,
                  std::size_t most = 10000, bool apart = false) {
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("points: " + what);
  };
  if (points.size() < least || points.size() > most)
    refuse("a " + name + " needs " + std::to_string(least) +
           (least == most ? "" : " to " + std::to_string(most)) + ", not " +
           std::to_string(points.size()));
  const double size = extent(points);
  if (!(size > 0.0)) refuse("all of a " + name + " are " + in_words(points[0]));
  for (std::size_t i = 1; apart && i < points.size(); ++i)
    if (meet(points[i - 1], points[i], size))
      refuse("two in a row of a " + name + " are " + in_words(points[i - 1]) + ", " +
             in_words(points[i]) + ", and a piece without length has no tangent");
}

/// From one point to another, q from 0 to 1.
inline Path line(const Vector2d& a, const Vector2d& b) {
  check("line", {a, b}, 2);
  return {[=](double q) { return Place{a + q * (b - a), b - a, Vector2d::Zero()}; }, 0.0, 1.0};
}

// [simple]
/// About the origin, lowest at q = 0; q is the angle.
inline Path circle(double R) {
  const auto formula = [=](double q) {
    const Vector2d x(R * std::sin(q), R * std::cos(q));
    return Place{x, {x.y(), -x.x()}, -x};
  };
  return {.formula = formula, .first = -std::numbers::pi, .last = std::numbers::pi, .closed = true};
}

/// What a point of a wheel of radius R draws that rolls along the line y = 0, hanging below it,
/// from cusp to cusp: lowest at q = 0; q is the wheel's angle.
inline Path cycloid(double R) {
  const auto formula = [=](double q) {
    const double c = std::cos(q), s = std::sin(q);
    return Place{{R * (q + s), R * (1 + c)}, {R * (1 + c), -R * s}, {-R * s, -R * c}};
  };
  return {formula, -std::numbers::pi, std::numbers::pi};
}
// [simple]

/// r = r0 + (r1 − r0) q at the angle A q [rad], q from 0 to 1.
inline Path spiral(double r0, double r1, double A) {
  const double k = r1 - r0;
  if (k == 0.0 && r0 * A == 0.0)
    throw std::invalid_argument("turns: a spiral of one radius needs that and an angle");
  const auto formula = [=](double q) {
    const double r = r0 + k * q;
    const Vector2d e(std::cos(A * q), std::sin(A * q)), n(-e.y(), e.x());
    return Place{r * e, k * e + r * A * n, 2 * k * A * n - r * A * A * e};
  };
  return {formula, 0.0, 1.0};
}

/// n waves of amplitude a over a width of l, q from 0 to 1.
inline Path sine(double l, double a, double n) {
  const double w = 2 * std::numbers::pi * n;
  const auto formula = [=](double q) {
    const double y = a * std::sin(w * q);
    return Place{{l * q, y}, {l, a * w * std::cos(w * q)}, {0.0, -w * w * y}};
  };
  return {formula, 0.0, 1.0};
}

/// What a body thrown at `launch` [m/s] describes in time; q is the time [s], up to `last`.
inline Path projectile(const Vector2d& launch, double g, double last = 1000.0) {
  if (launch.x() == 0.0 && (launch.y() < 0.0 || (launch.y() == 0.0 && g == 0.0)))
    throw std::invalid_argument(
        "launch: straight up, or at rest without gravity, a projectile "
        "has a place without tangent");
  const Vector2d weight(0.0, g);
  return {[=](double q) {
            return Place{launch * q + weight * (q * q / 2), launch + weight * q, weight};
          },
          0.0, last};
}

/// Bézier curves, q from 0 to 1: from the first point towards the second, to the last.
inline Place bezier(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d,
                    double q) {
  const double p = 1 - q;
  return {p * p * p * a + 3 * p * p * q * b + 3 * p * q * q * c + q * q * q * d,
          3 * (p * p * (b - a) + 2 * p * q * (c - b) + q * q * (d - c)),
          6 * (p * (a - 2 * b + c) + q * (b - 2 * c + d))};
}
inline Path cubic(const Points& p) {
  check("cubic", p, 4, 4);
  return {[=](double q) { return bezier(p[0], p[1], p[2], p[3], q); }, 0.0, 1.0};
}
inline Path quadratic(const Points& p) {
  check("quadratic", p, 3, 3);
  return cubic({p[0], (p[0] + 2 * p[1]) / 3, (2 * p[1] + p[2]) / 3, p[2]});
}

/// Segments in a row, from each point to the next: q is the number of the segment and the part of
/// it that is behind.
template <class Segment>
Path spline(const Points& p, Segment segment) {
  const std::size_t segments = p.size() - 1;
  const auto formula = [=](double q) {
    const double i = std::clamp(std::floor(q), 0.0, static_cast<double>(segments - 1));
    return segment(static_cast<std::size_t>(i), q - i);
  };
  Path path{formula, 0.0, static_cast<double>(segments)};
  path.closed = meet(p.front(), p.back(), extent(p));
  for (std::size_t i = 1; i < segments; ++i) path.knots.push_back(static_cast<double>(i));
  return path;
}

inline Path linear_spline(const Points& p) {
  check("linear_spline", p, 2, 10000, true);
  return spline(p, [=](std::size_t i, double u) {
    return Place{p[i] + u * (p[i + 1] - p[i]), p[i + 1] - p[i], Vector2d::Zero()};
  });
}

/// x grows as on a line, y as half a cosine.
inline Path cosine_spline(const Points& p) {
  check("cosine_spline", p, 2, 10000, true);
  return spline(p, [=](std::size_t i, double u) {
    constexpr double pi = std::numbers::pi;
    const Vector2d way = p[i + 1] - p[i];
    const double c = std::cos(pi * u), rise = way.y() / 2;
    return Place{p[i] + Vector2d(u * way.x(), rise * (1 - c)),
                 {way.x(), rise * pi * std::sin(pi * u)},
                 {0.0, rise * pi * pi * c}};
  });
}

/// Through all points, at each with its own x′.
inline Path hermite_spline(const Points& p, const Points& tangents) {
  check("hermite_spline", p, 2);
  if (tangents.size() != p.size())
    throw std::invalid_argument("tangents: a hermite_spline needs one at each point, " +
                                std::to_string(p.size()) + ", not " +
                                std::to_string(tangents.size()));
  return spline(p, [=](std::size_t i, double u) {
    return bezier(p[i], p[i] + tangents[i] / 3, p[i + 1] - tangents[i + 1] / 3, p[i + 1], u);
  });
}

/// At each point as steep as from the point before to the one after; the ends stand in for what
/// lies beyond them.
inline Path catmull_rom(const Points& p) {
  check("catmull_rom", p, 2, 10000, true);
  Points tangents;
  for (std::size_t i = 0; i < p.size(); ++i)
    tangents.push_back((p[std::min(i + 1, p.size() - 1)] - p[i == 0 ? 0 : i - 1]) / 2);
  return hermite_spline(p, tangents);
}

/// A part of a sequence, and the q of the sequence at which it begins.
struct Piece {
  double cue;
  Path path;
};

/// Paths one after the other, q from 0 to 1 over all; a piece may be a sequence itself.
inline Path sequence(const std::vector<Piece>& pieces) {
  if (pieces.empty()) throw std::invalid_argument("sequence: it has no piece");
  std::vector<double> cues;
  for (const Piece& piece : pieces) cues.push_back(piece.cue);
  cues.push_back(1.0);
  for (std::size_t i = 0; i < pieces.size(); ++i)
    if (cues[0] != 0.0 || !(cues[i + 1] - cues[i] >= 1e-6))
      throw std::invalid_argument("sequence: cues begin with 0, grow by 1e-6 and stay below 1");
  const auto parts = std::make_shared<const std::vector<Piece>>(pieces);
  const auto scale = [=](std::size_t i) {
    return ((*parts)[i].path.last - (*parts)[i].path.first) / (cues[i + 1] - cues[i]);
  };
  const auto formula = [=](double q) {
    const auto next = std::upper_bound(cues.begin() + 1, cues.end() - 1, q);
    const auto i = static_cast<std::size_t>(next - cues.begin()) - 1;
    const Path& path = (*parts)[i].path;
    const double k = scale(i);
    // The end of a whole is the end of its last piece, to the last digit.
    const Place place = path.formula(q == cues[i + 1] ? path.last : path.first + k * (q - cues[i]));
    return Place{place.x, k * place.d, k * k * place.dd};
  };
  Path whole{formula, 0.0, 1.0};
  Points places;  // some, for their extent
  for (int k = 0; k <= 64; ++k) places.push_back(formula(k / 64.0).x);
  const double size = extent(places);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Path& path = pieces[i].path;
    if (i > 0) {
      const Vector2d end = pieces[i - 1].path.formula(pieces[i - 1].path.last).x,
                     begin = path.formula(path.first).x;
      if (!meet(end, begin, size))
        throw std::invalid_argument("sequence: pieces " + std::to_string(i) + " and " +
                                    std::to_string(i + 1) + " do not meet: " + in_words(end) +
                                    ", " + in_words(begin));
      whole.knots.push_back(cues[i]);
    }
    for (const double knot : path.knots)
      whole.knots.push_back(cues[i] + (knot - path.first) / scale(i));
  }
  whole.closed = meet(whole.formula(0.0).x, whole.formula(1.0).x, size);
  return whole;
}

}  // namespace paths
