// [joint]
#pragma once

#include <array>

#include "mechanics/dynamics/things.hpp"

namespace joints {

using dynamics::S;
using dynamics::Vector2d;

/// Pin in a slot: point u2 [m] of the second body stays on a line fixed in the first, through u1
/// [m] with unit normal n_hat. 1 row, in m.
struct Slot {
  static constexpr std::array unit{"m"};

  Vector2d u1 = Vector2d::Zero();
  Vector2d u2 = Vector2d::Zero();
  Vector2d n_hat = Vector2d::UnitY();

  dynamics::Rows<1, dynamics::Body, dynamics::Body> rows(const dynamics::Body& first,
                                                         const dynamics::Body& second) const {
    using Row = Eigen::Vector<double, 1>;
    const auto p1 = point(first, u1), p2 = point(second, u2);
    const Vector2d n = first.A * n_hat, Sn = S(n);
    const Vector2d d = p2.r - p1.r, d_dot = p2.rdot - p1.rdot;
    const double w1 = first.omega;
    dynamics::Rows<1, dynamics::Body, dynamics::Body> rows;
    rows.C = Row(n.dot(d));
    rows.J1 << -n.transpose(), Sn.dot(p2.r - first.x);
    rows.J2 << n.transpose(), n.dot(p2.J.col(2));
    rows.Jdot_v = Row(n.dot(p2.Jdot_v - p1.Jdot_v) + 2 * w1 * Sn.dot(d_dot) - w1 * w1 * n.dot(d));
    rows.size = Row(p1.size + p2.size);
    return rows;
  }
};
// [joint]

}  // namespace joints
