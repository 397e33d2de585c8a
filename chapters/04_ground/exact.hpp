#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "mechanics/motion/method.hpp"
#include "mechanics/motion/motion.hpp"
#include "scene.hpp"

namespace ground {

/// e(t) and its rate for e'' + kd e' + ks e = 0 from e(0) = 1, e'(0) = 0.
struct Decay {
  double e, rate;
};

/// Under-, critically and over-damped by the sign of kd²/4 − ks. Written so that nothing cancels
/// close to the critical case, and nothing overflows far into an overdamped one.
inline Decay decay(double ks, double kd, double t) {
  const double gamma = 0.5 * kd, d = gamma * gamma - ks;
  if (d <= 0.0) {
    const double Omega = std::sqrt(-d);
    const double s = Omega * t < 1e-8 ? t : std::sin(Omega * t) / Omega, c = std::cos(Omega * t);
    const double f = std::exp(-gamma * t);
    return {f * (c + gamma * s), -f * ks * s};
  }
  const double w = std::sqrt(d), rho1 = ks / (gamma + w);  // the slow rate; the fast one is γ + w
  const double f = std::exp(-rho1 * t), s = -std::expm1(-2.0 * w * t) / (2.0 * w);
  return {f * (1.0 + rho1 * s), -ks * f * s};
}

/// The exact place of the plate and the exact reaction of the ground (force and moment).
struct Exact {
  Eigen::Vector3d q, v, reaction;
};

/// At t [s] under a method: without stabilization the plate stays where it was put; feedback moves
/// it back by the closed form, each coordinate by itself, whatever the load; projection puts it in
/// its place at once. The reaction is what the motion takes beyond the applied forces, M q̈ − F.
inline Exact exact(const Scene& scene, const mechanics::Method& method, double t) {
  Exact truth;
  Eigen::Vector3d a = Eigen::Vector3d::Zero();
  switch (method.stabilization) {
    case mechanics::Stabilization::none:
      truth.q = scene.offset();
      truth.v.setZero();
      break;
    case mechanics::Stabilization::feedback: {
      const Decay now = decay(method.ks, method.kd, t);
      truth.q = now.e * scene.offset();
      truth.v = now.rate * scene.offset();
      a = -method.kd * truth.v - method.ks * truth.q;
      break;
    }
    case mechanics::Stabilization::projection:
      truth.q = t == 0.0 ? scene.offset() : Eigen::Vector3d::Zero();
      truth.v.setZero();
      break;
  }
  const Eigen::Vector3d M(scene.mass, scene.mass, scene.inertia());
  truth.reaction = M.cwiseProduct(a) - scene.applied(t, truth.q.z());
  return truth;
}

/// Errors of a row: place of the centre [m], angle [rad], reaction force [N], reaction moment
/// [N·m].
inline std::vector<double> errors(const Scene& scene, const mechanics::Method& method,
                                  const mechanics::Row& row) {
  const Exact truth = exact(scene, method, row.t);
  const Eigen::Vector3d q(row.state[0], row.state[1], row.state[2]);
  const Eigen::Vector3d reaction(row.reactions[0], row.reactions[1], row.reactions[2]);
  return {(q - truth.q).head<2>().norm(), std::abs(q.z() - truth.q.z()),
          (reaction - truth.reaction).head<2>().norm(),
          std::abs(reaction.z() - truth.reaction.z())};
}

}  // namespace ground
