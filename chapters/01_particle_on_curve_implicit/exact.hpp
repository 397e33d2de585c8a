#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "exact_motion.hpp"
#include "mechanics/motion/motion.hpp"

namespace particle_on_curve {

/// The exact state of the particle and the exact force that holds it.
struct Exact {
  Eigen::Vector2d x, v;              ///< [m], [m/s]
  Eigen::Vector2d constraint_force;  ///< [N]
};

/// At time t [s]. The force comes from Newton's law across the track, not from the chapter's
/// formula: a particle of speed v on a curve of curvature κ is accelerated by v²κ towards the
/// centre of curvature.
inline Exact exact(const parabola::Scene& scene, const parabola::ExactMotion& motion, double t) {
  const auto [q, qdot] = motion.at(t);
  const double p = scene.p;
  const Eigen::Vector2d v(qdot, -q * qdot / p);
  const double length = std::hypot(q, p);
  const Eigen::Vector2d inwards = -Eigen::Vector2d(q, p) / length;
  const double curvature = p * p / (length * length * length);
  const double N = scene.mass * v.squaredNorm() * curvature - scene.applied_force().dot(inwards);
  return {{q, scene.height(q)}, v, N * inwards};
}

/// Distance to the exact state, for position [m], velocity [m/s] and constraint force [N].
inline std::vector<double> errors(const parabola::Scene& scene, const mechanics::Row& row) {
  const Exact truth = exact(scene, parabola::ExactMotion(scene), row.t);
  const Eigen::Vector2d x(row.state[0], row.state[1]), v(row.state[2], row.state[3]);
  const Eigen::Vector2d force(row.reactions[0], row.reactions[1]);
  return {(x - truth.x).norm(), (v - truth.v).norm(), (force - truth.constraint_force).norm()};
}

}  // namespace particle_on_curve
