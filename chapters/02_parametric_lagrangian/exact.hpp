#pragma once

#include <cmath>
#include <vector>

#include "01_particle_on_curve_implicit/exact_motion.hpp"
#include "mechanics/motion/motion.hpp"

namespace parametric_lagrangian {

/// Errors of q [m] and q̇ [m/s] against the exact motion, which this chapter's lesson derives from
/// its own energy; see exact_motion.hpp.
inline std::vector<double> errors(const parabola::Scene& scene, const mechanics::Row& row) {
  const auto [q, qdot] = parabola::ExactMotion(scene).at(row.t);
  return {std::abs(row.state[0] - q), std::abs(row.state[1] - qdot)};
}

}  // namespace parametric_lagrangian
