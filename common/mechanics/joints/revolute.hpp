// Revolute joint: a point of one thing stays on a point of the other; both stay free to turn.
//
//   The two points coincide.         C      = r1 - r2 = x1 + A1 u1 - x2 - A2 u2
//   Differentiate: dA/dt = w S A.    Cdot   = v1 + w1 S A1 u1 - v2 - w2 S A2 u2
//   Collect the velocities.          J      = [ I, S A1 u1 | -I, -S A2 u2 ]
//   Differentiate again, v held:     Jdot_v = -w1^2 A1 u1 + w2^2 A2 u2
//   since S S = -I: each point accelerates towards its own centre of mass.    (w is omega)
#pragma once

#include <array>

#include "mechanics/dynamics/things.hpp"

namespace joints {

using dynamics::Vector2d;

/// Holds point u1 (m) of the first thing on point u2 (m) of the second, each given in its own
/// thing's frame. 2 rows, in m.
struct Revolute {
  static constexpr std::array unit{"m", "m"};

  Vector2d u1 = Vector2d::Zero();
  Vector2d u2 = Vector2d::Zero();

  // [rows]
  template <class First, class Second>
  dynamics::Rows<2, First, Second> rows(const First& first, const Second& second) const {
    const auto p1 = point(first, u1);
    const auto p2 = point(second, u2);
    return {.C = p1.r - p2.r,
            .J1 = p1.J,
            .J2 = -p2.J,
            .Jdot_v = p1.Jdot_v - p2.Jdot_v,
            .size = Vector2d::Constant(p1.size + p2.size)};
  }
  // [rows]
};

}  // namespace joints
