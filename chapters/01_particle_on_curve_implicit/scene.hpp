#pragma once

#include <Eigen/Core>
#include <cmath>

namespace parabola {

/// A bead on the parabola x² + 2py = 0, released from rest. With y down this is a valley.
struct Scene {
  double x0 = 100.0;      ///< start [m]
  double mass = 1.0;      ///< m [kg]
  double gravity = 9.81;  ///< g [m/s²], along +y: down
  double p = 50.0;  ///< half the parameter of the curve [m]; its radius of curvature at the bottom
  double force_x = 0.0;                ///< constant horizontal force [N]
  bool without_velocity_term = false;  ///< what the bend asks of a moving bead is left out

  /// The same scene in units L, T and m times smaller.
  Scene scaled(double L, double T, double m) const {
    return {x0 * L, mass * m, gravity * L / (T * T), p * L, force_x * m * L / (T * T)};
  }

  /// A bound of how fast the tangent at the bead turns [rad/s]: its speed from x0 down to the
  /// bottom, over the radius there; at rest, a swing about the bottom.
  double fastest() const {
    return std::sqrt(applied_force().norm() / (mass * p)) * std::hypot(1.0, x0 / p);
  }

  double height(double x) const { return -x * x / (2.0 * p); }

  /// The applied force: weight and horizontal force [N].
  Eigen::Vector2d applied_force() const { return {force_x, mass * gravity}; }

  /// Kinetic and potential energy [J]; zero at rest at the origin.
  double energy(const Eigen::Vector2d& x, const Eigen::Vector2d& v) const {
    return kinetic(v) - applied_force().dot(x);
  }
  double kinetic(const Eigen::Vector2d& v) const { return 0.5 * mass * v.squaredNorm(); }
  /// How fast √(2·kinetic) grows at most [N/√kg].
  double drive() const { return applied_force().norm() / std::sqrt(mass); }
};

}  // namespace parabola
