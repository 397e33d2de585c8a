#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "exact.hpp"
#include "mechanics/motion/motion.hpp"
#include "scene.hpp"

namespace slider_crank {

/// The machine without constraints, stepped in its one degree of freedom, as the exact answer
/// derives it:
///
///     μ θ̈ + ½ μ' θ̇² = τ + mr g y'.
///
/// Its joints cannot open; their forces follow from the motion by Newton's and Euler's laws.
class OneCoordinate {
 public:
  using Vector = double;  // θ

  explicit OneCoordinate(const Scene& scene) : scene_(scene) {}

  void acceleration(double, double theta, double omega, double& a) const {
    const Terms at(scene_, theta);
    a = (scene_.torque + scene_.rod_mass * scene_.gravity * at.y_1 - at.half_mu_1 * omega * omega) /
        at.mu;
  }

  double initial_position() const { return scene_.theta0; }
  double initial_velocity() const { return scene_.omega0; }

  mechanics::Measures measures(double, double theta, double omega) const {
    const double kinetic = 0.5 * Terms(scene_, theta).mu * omega * omega, g = scene_.gravity;
    return {.energy = kinetic - scene_.rod_mass * g * 0.5 * scene_.crank * std::sin(theta),
            .constraint_error = 0.0,
            .velocity_error = 0.0,
            .work = scene_.torque * (theta - scene_.theta0),
            .kinetic = kinetic,
            .speed = scene_.crank * std::abs(omega),
            .load = (scene_.wheel_mass + scene_.rod_mass + scene_.slider_mass) * g,
            .drive = std::sqrt((scene_.wheel_mass + scene_.rod_mass + scene_.slider_mass) * g * g +
                               scene_.torque * scene_.torque / scene_.wheel_inertia())};
  }
  void cover(double theta, mechanics::Reach& reach) const {
    reach.cover(scene_.crank * std::cos(theta), scene_.crank * std::sin(theta));
    reach.cover(scene_.slider_x(theta), 0.0);
  }
  double free_acceleration(double t, double theta, double omega) const {
    double a = 0.0;
    acceleration(t, theta, omega, a);
    return std::abs(a);
  }
  std::string culprit(double, double theta, double omega) const {
    return fmt::format("θ = {:.2g} rad, θ̇ = {:.2g} rad/s", theta, omega);
  }

  mechanics::Columns columns() const {
    mechanics::Columns columns{{"wheel.theta", "wheel.omega"}, {}};
    for (const char* joint : {"wheel_frame", "rod_wheel", "slider_rod", "slider_frame"})
      for (const char* part : {".fx", ".fy"})
        columns.reactions.push_back(joint + std::string(part));
    return columns;
  }
  mechanics::Uses uses() const {
    return {.things = 3,
            .coordinates = 1,
            .rows = 0,
            .rank = 0,
            .state_bytes = 2 * sizeof(Vector),
            .workspace_bytes = sizeof *this,
            .left_out = {"the constraints and their forces", "all matrices"}};
  }
  void observe(double, double theta, double omega, mechanics::Row& row) const {
    row.state = {theta, omega};
    const Reactions now = reactions(scene_, {theta, omega});
    row.reactions.clear();
    for (const Eigen::Vector2d& force :
         {now.wheel_frame, now.rod_wheel, now.slider_rod, now.slider_frame})
      row.reactions.insert(row.reactions.end(), {force.x(), force.y()});
  }

 private:
  /// What the equation takes from the pose, each a derivative by θ where it says _1 or _2.
  struct Terms {
    Terms(const Scene& scene, double theta) {
      const double R = scene.crank, L = scene.rod;
      const double s = std::sin(theta), c = std::cos(theta);
      const double w = std::sqrt(L * L - R * R * s * s), w_1 = -R * R * s * c / w;  // w: L cos φ
      const double w_2 = -(R * R * (c * c - s * s) + w_1 * w_1) / w;
      const double slider_1 = -R * s + w_1, slider_2 = -R * c + w_2;
      const double x_1 = -R * s + w_1 / 2, x_2 = -R * c + w_2 / 2;
      const double y_2 = -R * s / 2;
      const double phi_1 = -R * c / w, phi_2 = (R * s - phi_1 * w_1) / w;
      const double m = scene.rod_mass, I = scene.rod_inertia(), slider = scene.slider_mass;
      y_1 = R * c / 2;
      mu = scene.wheel_inertia() + m * (x_1 * x_1 + y_1 * y_1) + I * phi_1 * phi_1 +
           slider * slider_1 * slider_1;
      half_mu_1 = m * (x_1 * x_2 + y_1 * y_2) + I * phi_1 * phi_2 + slider * slider_1 * slider_2;
    }
    double mu, half_mu_1, y_1;
  };

  Scene scene_;
};

}  // namespace slider_crank
