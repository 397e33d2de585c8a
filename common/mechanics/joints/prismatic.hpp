// Prismatic joint: a point of the second thing slides on a rail fixed in the first, without
// turning.
//
// The rail passes through r1 = x1 + A1 u1; n = A1 n_hat is its normal, so dn/dt = w1 S n.
// With r2 = x2 + A2 u2, d = r2 - r1 and w for omega:
//
//   No distance across the rail.     C      = ( n.d , theta2 - theta1 - theta21 )
//   Differentiate.                   Cdot 1 = w1 (S n).d + n.(v2 + w2 S A2 u2 - v1 - w1 S A1 u1)
//   n.(S b) = -(S n).b, so with b = A1 u1 the two terms in w1 join: d + A1 u1 = r2 - x1.
//                                    J row 1 = [ -n^T, (S n).(r2 - x1) | n^T, n.(S A2 u2) ]
//                                    J row 2 = [  0  ,       -1        |  0 ,      1      ]
//   Differentiate Cdot 1 again, v held. n turns in n.d_dot as well as d moves in (S n).d, hence the
//   2; S n turns into S S n = -n; each point accelerates towards its own centre of mass.
//                                    Jdot_v 1 = n.(w1^2 A1 u1 - w2^2 A2 u2)
//                                               + 2 w1 (S n).d_dot - w1^2 n.d
//                                    Jdot_v 2 = 0
#pragma once

#include <array>
#include <cmath>

#include "mechanics/dynamics/things.hpp"

namespace joints {

using dynamics::Body;
using dynamics::S;
using dynamics::Vector2d;
using dynamics::World;

/// Rail through u1 (m) of the first thing, a body or the world, with unit normal n_hat there; point
/// u2 (m) of the second, a body, stays on it, and theta2 - theta1 = theta21 (rad). 2 rows: m, rad.
struct Prismatic {
  static constexpr std::array unit{"m", "rad"};

  Vector2d u1 = Vector2d::Zero();
  Vector2d u2 = Vector2d::Zero();
  Vector2d n_hat = Vector2d::UnitY();
  double theta21 = 0;

  const char* fault() const {
    return std::abs(n_hat.norm() - 1) < 1e-9 ? nullptr : "its normal n_hat must be of length 1";
  }

  // [rows]
  dynamics::Rows<2, Body, Body> rows(const Body& first, const Body& second) const {
    const auto p1 = point(first, u1);
    const auto p2 = point(second, u2);
    const Vector2d n = first.A * n_hat, Sn = S(n);
    const Vector2d d = p2.r - p1.r;
    const Vector2d d_dot = p2.rdot - p1.rdot;
    const double w1 = first.omega;
    dynamics::Rows<2, Body, Body> rows;
    rows.C << n.dot(d), second.theta - first.theta - theta21;
    rows.J1 << -n.transpose(), Sn.dot(p2.r - first.x), 0, 0, -1;
    rows.J2 << n.transpose(), n.dot(p2.J.col(2)), 0, 0, 1;
    rows.Jdot_v << n.dot(p2.Jdot_v - p1.Jdot_v) + 2 * w1 * Sn.dot(d_dot) - w1 * w1 * n.dot(d), 0;
    rows.size << p1.size + p2.size + d.lpNorm<1>() * (1 + std::abs(first.theta)),
        std::abs(first.theta) + std::abs(second.theta) + std::abs(theta21);
    return rows;
  }
  // [rows]

  /// The rail fixed in the world: x1 = 0, A1 = I, w1 = 0, and no columns for the first thing.
  dynamics::Rows<2, World, Body> rows(const World& first, const Body& second) const {
    const auto p1 = point(first, u1);
    const auto p2 = point(second, u2);
    dynamics::Rows<2, World, Body> rows;
    rows.C << n_hat.dot(p2.r - p1.r), second.theta - theta21;
    rows.J2 << n_hat.transpose(), n_hat.dot(p2.J.col(2)), 0, 0, 1;
    rows.Jdot_v << n_hat.dot(p2.Jdot_v), 0;
    rows.size << p1.size + p2.size, std::abs(second.theta) + std::abs(theta21);
    return rows;
  }
};

}  // namespace joints
