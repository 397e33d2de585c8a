#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace mechanics {

/// How far a scene reaches: the largest distance [m] between points that its things have covered.
/// It keeps the width of the scene in sixteen directions, of which the largest is at most half a
/// percent short of that distance.
class Reach {
 public:
  /// A disc about (x, y) [m]: a particle has no radius.
  void cover(double x, double y, double radius = 0.0) {
    for (std::size_t i = 0; i < directions; ++i) {
      const double along = x * cosines[i] + y * sines[i];
      low_[i] = std::min(low_[i], along - radius);
      high_[i] = std::max(high_[i], along + radius);
    }
    largest_radius_ = std::max(largest_radius_, radius);
  }

  double size() const {
    double size = 0.0;
    for (std::size_t i = 0; i < directions; ++i) size = std::max(size, high_[i] - low_[i]);
    return size;
  }
  /// Of a thing: the lever by which an angle moves a point.
  double largest_radius() const { return largest_radius_; }
  /// How far from the origin the scene came, which is what coordinates are rounded by.
  double furthest() const {
    double furthest = 0.0;
    for (std::size_t i = 0; i < directions; ++i)
      furthest = std::max({furthest, -low_[i], high_[i]});
    return furthest;
  }

 private:
  static constexpr std::size_t directions = 16;
  static std::array<double, directions> table(double (*f)(double)) {
    std::array<double, directions> values{};
    for (std::size_t i = 0; i < directions; ++i)
      values[i] = f(std::numbers::pi * static_cast<double>(i) / directions);
    return values;
  }
  static std::array<double, directions> all(double value) {
    std::array<double, directions> values{};
    values.fill(value);
    return values;
  }
  static inline const std::array<double, directions> cosines = table(std::cos),
                                                     sines = table(std::sin);

  std::array<double, directions> low_ = all(std::numeric_limits<double>::infinity());
  std::array<double, directions> high_ = all(-std::numeric_limits<double>::infinity());
  double largest_radius_ = 0.0;
};

}  // namespace mechanics
