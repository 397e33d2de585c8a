#pragma once

#include <Eigen/Core>

#include "scene.hpp"

namespace ground {

/// e(t) and its rate for e'' + kd e' + ks e = 0 from e(0) = 1, e'(0) = 0. Without gains it stays.
struct Decay {
  double e, rate;
  double ks = 0.0, kd = 0.0;
};

/// Under-, critically and over-damped by the sign of kd²/4 − ks. Written so that nothing cancels
/// close to the critical case, and nothing overflows far into an overdamped one.
Decay decay(double ks, double kd, double t);

/// The exact place of the plate and the exact reaction of the ground (force and moment).
struct Exact {
  Eigen::Vector3d q, v, reaction;
};

/// At t [s], where so much of the offset is left: each coordinate goes back by itself, whatever the
/// load. The reaction is what the motion takes beyond the applied forces, M q̈ − F.
Exact exact(const Scene& scene, const Decay& left, double t);

}  // namespace ground
