#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mechanics/paths/path.hpp"

namespace paths {

/// A path by the length s [m] along it from its beginning: s(q) = ∫ |x′| dq by Gauss and Legendre's
/// rule of eight points, from a table fine enough for rounding, and q(s) by Newton's method.
class ByLength {
 public:
  /// Throws std::invalid_argument where a piece has no length or an end of it no tangent.
  explicit ByLength(Path path) : path_(std::move(path)) {
    std::vector<double> ends = path_.knots;
    ends.insert(ends.begin(), path_.first);
    ends.push_back(path_.last);
    for (std::size_t i = 1; i < ends.size(); ++i) size_ += integral(ends[i - 1], ends[i]);
    if (!std::isfinite(size_)) throw std::invalid_argument("path: its length is not finite");
    known_.push_back({path_.first, 0.0});
    for (std::size_t i = 1; i < ends.size(); ++i) add(ends[i - 1], ends[i]);
    for (const double q : ends)
      for (const bool behind : {false, true}) (void)tangent(q, behind);
    last_ = path_.first;
  }

  const Path& path() const { return path_; }
  double length() const { return known_.back().s; }

  double s(double q) const {
    const double turns = path_.turns(q);
    q -= turns * (path_.last - path_.first);
    const std::size_t i = before(q, &Known::q);
    return turns * length() + known_[i].s + integral(known_[i].q, q);
  }

  /// The q at which the length is s. Beyond an open end as if it went on with the same |x′|.
  double q(double s) const {
    const double turns = path_.closed ? std::floor(s / length()) : 0.0;
    s -= turns * length();
    const std::size_t i = before(s, &Known::s);
    const auto [low, s_low] = known_[i];
    const auto [high, s_high] = known_[i + 1];
    double a = low, b = high, q = std::clamp(last_, a, b);
    if (s < 0.0 || s > s_high)
      q = beyond(s);
    else
      // [invert]
      for (int step = 0; step < 100; ++step) {
        const double excess = s_low + integral(low, q) - s;
        if (std::abs(excess) <= rounding * s) break;
        (excess > 0.0 ? b : a) = q;
        q -= excess / path_(q).d.norm();
        if (!(q > a && q < b)) q = a + (b - a) / 2;
        if (q == a || q == b) break;
      }
    // [invert]
    last_ = q;
    return q + turns * (path_.last - path_.first);
  }

  /// The unit tangent, along growing q, of the way on; behind: of the way there, as at the end of
  /// an open path. Where x′ = 0, as at a cusp, x″ tells. Throws std::invalid_argument where there
  /// is none.
  Vector2d tangent(double q, bool behind = false) const {
    const Place place = behind ? path_.behind(q) : path_(q);
    const double speed = place.d.norm(), usual = size_ / (path_.last - path_.first);
    if (speed > 1e-12 * usual) return place.d / speed;
    if (!(place.dd.norm() > 1e-12 * usual))
      throw std::invalid_argument("path: no tangent at q = " + in_words(q) + ", where x' and x'' " +
                                  "are zero");
    return (behind || (q >= path_.last && !path_.closed) ? -1.0 : 1.0) * place.dd.normalized();
  }

 private:
  struct Known {
    double q, s;
  };
  static constexpr double rounding = 2.0 * std::numeric_limits<double>::epsilon();

  /// ∫ |x′| dq on a piece without knots.
  double integral(double from, double to) const {
    constexpr std::array nodes{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                               0.9602898564975363},
        weights{0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    const double middle = (from + to) / 2, half = (to - from) / 2;
    double sum = 0.0;
    for (std::size_t i = 0; i < 4; ++i)
      sum += weights[i] * (path_.formula(middle - half * nodes[i]).d.norm() +
                           path_.formula(middle + half * nodes[i]).d.norm());
    return half * sum;
  }

  /// Halves what the rule does not yet measure to rounding.
  void add(double from, double to) {
    const double middle = from + (to - from) / 2, whole = integral(from, to);
    const double parts = integral(from, middle) + integral(middle, to);
    constexpr double narrow = 1e-9;
    if (std::abs(parts - whole) > 4.0 * rounding * (known_.back().s + parts) &&
        to - from > narrow * (path_.last - path_.first)) {
      add(from, middle);
      add(middle, to);
    } else if (parts > 0.0) {
      known_.push_back({to, known_.back().s + parts});
    } else {
      throw std::invalid_argument("path: no length between q = " + in_words(from) + " and " +
                                  in_words(to));
    }
  }

  /// The last known place, but for the end, that does not lie behind a value.
  std::size_t before(double value, double Known::*what) const {
    const auto after =
        std::upper_bound(known_.begin() + 1, known_.end() - 1, value,
                         [=](double v, const Known& known) { return v < known.*what; });
    return static_cast<std::size_t>(after - known_.begin()) - 1;
  }

  double beyond(double s) const {
    const double end = s < 0.0 ? path_.first : path_.last, over = s < 0.0 ? s : s - length();
    const double speed = path_.formula(end).d.norm();
    return speed > 1e-12 * size_ / (path_.last - path_.first) ? end + over / speed : end;
  }

  Path path_;
  double size_ = 0.0;         ///< about the length
  std::vector<Known> known_;  ///< in order; between two of them lies no knot
  mutable double last_;       ///< q, as found last
};

}  // namespace paths
