#pragma once

#include <cmath>
#include <vector>

#include "measure/simulation.hpp"
#include "parabola/exact.hpp"

namespace parametric_lagrangian {

/// Errors of q [m] and q̇ [m/s] against the exact motion, which this chapter's lesson derives from
/// its own energy; see parabola/exact.hpp.
inline std::vector<double> errors(const parabola::Scene& scene, const measure::Row& row) {
  const auto [q, qdot] = parabola::ExactMotion(scene).at(row.t);
  return {std::abs(row.state[0] - q), std::abs(row.state[1] - qdot)};
}

}  // namespace parametric_lagrangian
