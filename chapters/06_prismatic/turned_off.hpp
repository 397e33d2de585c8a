#pragma once

#include "mechanics/joints/prismatic.hpp"

namespace prismatic {

/// The rail without 2 ω1 (S n)·ḋ: it answers for its own turning and for the points' circles, but
/// not for the block that moves along it while it turns.
struct WithoutCoriolis : joints::Prismatic {
  using Body = dynamics::Body;

  dynamics::Rows<2, Body, Body> rows(const Body& first, const Body& second) const {
    auto rows = Prismatic::rows(first, second);
    const Eigen::Vector2d d_dot = point(second, u2).rdot - point(first, u1).rdot;
    const Eigen::Vector2d Sn = dynamics::S(first.A * n_hat);
    rows.Jdot_v[0] -= 2 * first.omega * Sn.dot(d_dot);
    return rows;
  }
};

}  // namespace prismatic
