#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <string>

#include "mechanics/motion/motion.hpp"
#include "scene.hpp"

namespace parabola {

/// A particle held on the curve C(x, y) = x² + 2py = 0 by its constraint force λ∇C.
///
///     C   = x² + 2py                    position: the bead is on the curve
///     Ċ   = ∇C · v,  ∇C = (2x, 2p)      velocity: it moves along the tangent
///     C̈   = ∇C · a + 2 vx²              acceleration; 2 vx² is J̇v
///
/// With a = (F + λ∇C)/m and the demand C̈ = −ks C − kd Ċ, the one unknown is
///
///     λ = −(2m vx² + ∇C·F + m (ks C + kd Ċ)) / |∇C|²
class ImplicitBead {
 public:
  using Vector = Eigen::Vector2d;

  /// ks [1/s²] and kd [1/s] feed the error of the constraint back; zero leaves the feedback out.
  explicit ImplicitBead(const Scene& scene, double ks = 0.0, double kd = 0.0)
      : scene_(scene), F_(scene.applied_force()), ks_(ks), kd_(kd) {}

  double C(const Vector& x) const { return x.x() * x.x() + 2.0 * scene_.p * x.y(); }
  Vector gradient(const Vector& x) const { return {2.0 * x.x(), 2.0 * scene_.p}; }

  // [constraint_force]
  /// The force [N] with which the curve holds the bead against any applied force F [N].
  Vector constraint_force(const Vector& x, const Vector& v, const Vector& F) const {
    const double m = scene_.mass;
    const Vector grad_C = gradient(x);
    double load = grad_C.dot(F);
    if (!scene_.without_velocity_term) load += 2.0 * m * v.x() * v.x();
    if (ks_ != 0.0 || kd_ != 0.0) load += m * (ks_ * C(x) + kd_ * grad_C.dot(v));
    const double lambda = -load / grad_C.squaredNorm();
    return lambda * grad_C;
  }
  // [constraint_force]

  void acceleration(double, const Vector& x, const Vector& v, Vector& a) const {
    a = (F_ + constraint_force(x, v, F_)) / scene_.mass;
  }

  // [projection]
  /// Back onto the curve along ∇C, then the velocity back onto the tangent.
  void project(double, Vector& x, Vector& v) const {
    constexpr double rounding = 2.0 * std::numeric_limits<double>::epsilon();
    for (int i = 0; i < 4; ++i) {
      const double error = C(x);
      if (std::abs(error) <= rounding * x.x() * x.x()) break;
      const Vector grad_C = gradient(x);
      x -= error / grad_C.squaredNorm() * grad_C;
    }
    const Vector grad_C = gradient(x);
    v -= grad_C.dot(v) / grad_C.squaredNorm() * grad_C;
  }
  // [projection]

  Vector initial_position() const { return {scene_.x0, scene_.height(scene_.x0)}; }
  Vector initial_velocity() const { return Vector::Zero(); }

  mechanics::Measures measures(double, const Vector& x, const Vector& v) const {
    return {.energy = scene_.energy(x, v),
            .constraint_error = std::abs(C(x)),
            .velocity_error = std::abs(gradient(x).dot(v)),
            .kinetic = scene_.kinetic(v),
            .opening = std::abs(C(x)) / gradient(x).norm(),
            .load = F_.norm(),
            .drive = scene_.drive()};
  }
  /// The bead and the bottom of its valley.
  void cover(const Vector& x, mechanics::Reach& reach) const {
    reach.cover(0.0, 0.0);
    reach.cover(x.x(), x.y());
  }
  double free_acceleration(double, const Vector&, const Vector&) const {
    return F_.norm() / scene_.mass;
  }
  std::string culprit(double, const Vector& x, const Vector&) const {
    return fmt::format("the curve is off by C = {:.2g} m²", C(x));
  }

  mechanics::Columns columns() const {
    return {{"particle.x", "particle.y", "particle.vx", "particle.vy"},
            {"particle_curve.fx", "particle_curve.fy", "particle_curve.moment"}};
  }

  mechanics::Uses uses() const {
    std::vector<std::string> left_out{"the angle", "all matrices"};
    if (ks_ == 0.0 && kd_ == 0.0) left_out.push_back("feedback");
    return {.things = 1,
            .coordinates = 2,
            .rows = 1,
            .rank = 1,
            .state_bytes = 2 * sizeof(Vector),
            .workspace_bytes = sizeof *this,
            .left_out = left_out};
  }

  void observe(double, const Vector& x, const Vector& v, mechanics::Row& row) const {
    row.state = {x.x(), x.y(), v.x(), v.y()};
    const Vector force = constraint_force(x, v, F_);
    row.reactions = {force.x(), force.y(), 0.0};
  }

 private:
  Scene scene_;
  Vector F_;
  double ks_, kd_;
};

}  // namespace parabola
