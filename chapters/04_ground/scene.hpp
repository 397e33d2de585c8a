#pragma once

#include <Eigen/Core>
#include <cmath>

namespace ground {

/// A plate held at the origin by a ground joint, under its weight and a load F(t) = (0, load sin
/// 2t) at the midpoint of its right edge. It may start off its place, to watch the error feedback
/// bring it back.
struct Scene {
  double load = 5.0;                                          ///< [N]
  double offset_x = 0.0, offset_y = 0.0, offset_theta = 0.0;  ///< at the start [m, m, rad]

  // No options, but other units change them too.
  double width = 0.6, height = 0.4, mass = 2.0, gravity = 9.81;  ///< SI
  double load_rate = 2.0;                                        ///< [rad/s]

  double inertia() const { return mass * (width * width + height * height) / 12.0; }  ///< [kg·m²]
  Eigen::Vector3d offset() const { return {offset_x, offset_y, offset_theta}; }
  double load_at(double t) const { return load * std::sin(load_rate * t); }

  /// Weight and load with the plate turned by theta: force [N] and moment [N·m] about its centre.
  Eigen::Vector3d applied(double t, double theta) const {
    return {0.0, mass * gravity + load_at(t), 0.5 * width * std::cos(theta) * load_at(t)};
  }
};

}  // namespace ground
