#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <string>

#include "01_particle_on_curve_implicit/scene.hpp"
#include "mechanics/motion/motion.hpp"

namespace parametric_lagrangian {

/// The particle by its one degree of freedom: x(q) = (q, −q²/2p). It cannot leave the curve.
///
///     T = ½ m q̇² (1 + q²/p²)            kinetic energy, from ẋ = (1, −q/p) q̇
///     V = m g q²/2p − Fx q              potential energy of weight and horizontal force
///     d/dt ∂L/∂q̇ = ∂L/∂q,  L = T − V    Lagrange's equation; it gives
///
///     q̈ = (−q q̇² − p g q + p² Fx/m) / (p² + q²)
class ParametricBead {
 public:
  using Vector = double;  // one coordinate is the whole state

  explicit ParametricBead(const parabola::Scene& scene) : scene_(scene) {}

  void acceleration(double, double q, double qdot, double& qddot) const {
    const auto& [x0, m, g, p, Fx, without_velocity_term] = scene_;
    const double velocity_term = without_velocity_term ? 0.0 : -q * qdot * qdot;
    qddot = (velocity_term - p * g * q + p * p * Fx / m) / (p * p + q * q);
  }

  Eigen::Vector2d x(double q) const { return {q, scene_.height(q)}; }
  Eigen::Vector2d v(double q, double qdot) const { return {qdot, -q / scene_.p * qdot}; }

  /// The force of the curve [N]: what the motion takes beyond the applied force, m ẍ − F.
  Eigen::Vector2d constraint_force(double q, double qdot) const {
    double qddot = 0.0;
    acceleration(0.0, q, qdot, qddot);
    const Eigen::Vector2d xddot(qddot, -(qdot * qdot + q * qddot) / scene_.p);
    return scene_.mass * xddot - scene_.applied_force();
  }

  double initial_position() const { return scene_.x0; }
  double initial_velocity() const { return 0.0; }

  /// The constraint of chapter 1 and its rate, asked of this particle: nothing but rounding.
  mechanics::Measures measures(double, double q, double qdot) const {
    const Eigen::Vector2d x = this->x(q), v = this->v(q, qdot);
    const double p = scene_.p;
    return {.energy = scene_.energy(x, v),
            .constraint_error = std::abs(x.x() * x.x() + 2.0 * p * x.y()),
            .velocity_error = std::abs(2.0 * x.x() * v.x() + 2.0 * p * v.y()),
            .kinetic = scene_.kinetic(v),
            .load = scene_.applied_force().norm(),
            .drive = scene_.drive()};
  }
  /// The bead and the bottom of its valley.
  void cover(double q, mechanics::Reach& reach) const {
    reach.cover(0.0, 0.0);
    reach.cover(x(q).x(), x(q).y());
  }
  double free_acceleration(double, double, double) const {
    return scene_.applied_force().norm() / scene_.mass;
  }
  std::string culprit(double, double q, double qdot) const {
    return fmt::format("q = {:.2g} m, q̇ = {:.2g} m/s", q, qdot);
  }

  mechanics::Columns columns() const {
    return {{"q", "qdot", "particle.x", "particle.y", "particle.vx", "particle.vy"},
            {"particle_curve.fx", "particle_curve.fy", "particle_curve.moment"}};
  }

  mechanics::Uses uses() const {
    return {.things = 1,
            .coordinates = 1,
            .rows = 0,
            .rank = 0,
            .state_bytes = 2 * sizeof(Vector),
            .workspace_bytes = sizeof *this,
            .left_out = {"the constraint and its force", "all matrices"}};
  }

  void observe(double, double q, double qdot, mechanics::Row& row) const {
    const Eigen::Vector2d x = this->x(q), v = this->v(q, qdot);
    row.state = {q, qdot, x.x(), x.y(), v.x(), v.y()};
    const Eigen::Vector2d force = constraint_force(q, qdot);
    row.reactions = {force.x(), force.y(), 0.0};
  }

 private:
  parabola::Scene scene_;
};

}  // namespace parametric_lagrangian
