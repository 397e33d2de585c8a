#pragma once

#include <Eigen/Core>

#include "scene.hpp"

namespace prismatic {

/// The exact state of the block and the exact reaction of the rail on it.
struct Exact {
  Vector2d x, v;        ///< centre [m], [m/s]
  double theta, omega;  ///< [rad], [rad/s]
  Vector2d force;       ///< [N]
  double moment;        ///< about the centre of mass [N·m]
};

/// At time t [s]: of the fixed rail in closed form, under-, critically or over-damped, to rounding
/// of the start's size; of the spinning rail by a quadrature. Of what make_mechanism refuses it is
/// not the answer.
Exact exact(const Scene& scene, double t);

}  // namespace prismatic
