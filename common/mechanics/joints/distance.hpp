// Distance joint: a massless rod of length l between a point of one thing and a point of the other.
//
//   The points are l apart.          C      = (d.d - l^2) / 2,   d = r2 - r1
//   Differentiate.                   Cdot   = d . d_dot,   d_dot = Jp2 v2 - Jp1 v1
//   Collect the velocities.          J      = [ -d^T Jp1 | d^T Jp2 ]
//   Differentiate again, v held:     Jdot_v = d_dot . d_dot + d . (Jdot_v of r2 - Jdot_v of r1)
//
// Jp = [I, S A u] is the Jacobian of a point: for two particles it is I and J = [ -d^T | d^T ].
#pragma once

#include <array>
#include <cmath>

#include "mechanics/dynamics/things.hpp"

namespace joints {

using dynamics::Vector2d;

/// Keeps point u1 (m) of the first thing at distance `length` (m, positive) from point u2 (m) of
/// the second. 1 row, in m^2: lambda times d is the rod's force on the second thing.
struct Distance {
  static constexpr std::array unit{"m^2"};

  double length;
  Vector2d u1 = Vector2d::Zero();
  Vector2d u2 = Vector2d::Zero();

  const char* fault() const {
    return length > 0 && std::isnormal(length * length)
               ? nullptr
               : "its length must be positive, and its square neither too large nor too small";
  }

  // [rows]
  template <class First, class Second>
  dynamics::Rows<1, First, Second> rows(const First& first, const Second& second) const {
    using Row = Eigen::Vector<double, 1>;
    const auto p1 = point(first, u1);
    const auto p2 = point(second, u2);
    const Vector2d d = p2.r - p1.r;
    const Vector2d d_dot = p2.rdot - p1.rdot;
    return {.C = Row((d.squaredNorm() - length * length) / 2),
            .J1 = -d.transpose() * p1.J,
            .J2 = d.transpose() * p2.J,
            .Jdot_v = Row(d_dot.squaredNorm() + d.dot(p2.Jdot_v - p1.Jdot_v)),
            .size = Row(d.lpNorm<1>() * (p1.size + p2.size) + length * length)};
  }
  // [rows]
};

}  // namespace joints
