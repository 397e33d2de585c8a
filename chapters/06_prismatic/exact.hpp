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

/// At time t [s]: of the incline in closed form, of the spinning rail by a quadrature.
Exact exact(const Scene& scene, double t);

}  // namespace prismatic
