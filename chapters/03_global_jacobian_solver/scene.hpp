#pragma once

#include <Eigen/Core>

namespace dumbbell {

using Eigen::Vector2d;

/// Two beads on the parabola x² + 2py = 0, joined by a rigid rod without mass, released from rest.
struct Scene {
  double x1 = 20.0, x2 = 60.0;    ///< where the beads start [m]
  double m1 = 1.0, m2 = 2.0;      ///< their masses [kg]
  double gravity = 9.81;          ///< along +y: down [m/s²]
  double p = 50.0;                ///< half the parameter of the curve [m]
  bool without_coupling = false;  ///< each constraint is solved as if the others did not push

  Vector2d on_curve(double x) const { return {x, -x * x / (2.0 * p)}; }
  double rod() const { return (on_curve(x2) - on_curve(x1)).norm(); }  ///< its length [m]
};

}  // namespace dumbbell
