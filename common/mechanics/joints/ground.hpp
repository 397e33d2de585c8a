// Ground: the thing stays where it is put.
//
//   Every coordinate has its value.  C      = (x - cx, y - cy, theta - ctheta)
//   Differentiate.                   Cdot   = (vx, vy, omega)
//   Collect the velocities.          J      = I
//   J is constant.                   Jdot_v = 0
//
// So lambda itself is the reaction. A thing that never moves needs neither coordinates nor rows:
// let its joints take the world in its place.
#pragma once

#include <array>

#include "mechanics/dynamics/things.hpp"

namespace joints {

using dynamics::Vector2d;

/// Holds a body at (c, ctheta), in m and rad: 3 rows; or a particle, which has no angle, at c: 2.
struct Ground {
  static constexpr std::array unit{"m", "m", "rad"};

  Vector2d c = Vector2d::Zero();
  double ctheta = 0;

  // [rows]
  dynamics::Rows<3, dynamics::Body, dynamics::World> rows(const dynamics::Body& body,
                                                          const dynamics::World&) const {
    const double size = body.x.lpNorm<1>() + c.lpNorm<1>();
    return {.C = {body.x.x() - c.x(), body.x.y() - c.y(), body.theta - ctheta},
            .J1 = Eigen::Matrix3d::Identity(),
            .J2 = {},
            .Jdot_v = Eigen::Vector3d::Zero(),
            .size = {size, size, std::abs(body.theta) + std::abs(ctheta)}};
  }
  // [rows]

  dynamics::Rows<2, dynamics::Particle, dynamics::World> rows(const dynamics::Particle& particle,
                                                              const dynamics::World&) const {
    return {.C = particle.x - c,
            .J1 = dynamics::Matrix2d::Identity(),
            .J2 = {},
            .Jdot_v = Vector2d::Zero(),
            .size = Vector2d::Constant(particle.x.lpNorm<1>() + c.lpNorm<1>())};
  }
};

}  // namespace joints
