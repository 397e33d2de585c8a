#pragma once

#include <cmath>
#include <numbers>

namespace slider_crank {

/// A wheel turns in a frame; a rod joins its crank pin to a slider on a rail through the wheel's
/// centre.
struct Scene {
  double crank = 0.3;                    ///< from the wheel's centre to the crank pin [m]
  double rod = 1.0;                      ///< length of the rod [m]
  double torque = 2.0;                   ///< on the wheel, from outside [N·m]
  double theta0 = std::numbers::pi / 4;  ///< of the wheel at the start [rad]
  double omega0 = 0.0;                   ///< of the wheel at the start [rad/s]
  double gravity = 9.81;                 ///< along +y [m/s²]
  double wheel_mass = 2.0, rod_mass = 1.0, slider_mass = 1.5;  ///< [kg]
  bool without_jdotv = false;   ///< the joints give way to bodies that turn
  bool simulate_frame = false;  ///< the frame is a body, held by a ground joint; else left out

  // No options, but other units change them too.
  double frame_mass = 10.0, frame_inertia = 1.0;   ///< [kg], [kg·m²]
  double wheel_radius = 0.4;                       ///< [m]
  double slider_width = 0.3, slider_height = 0.2;  ///< [m]

  double wheel_inertia() const { return 0.5 * wheel_mass * wheel_radius * wheel_radius; }
  double rod_inertia() const { return rod_mass * rod * rod / 12.0; }
  /// A bound of the wheel's rate [rad/s] after a time t [s]: where it starts, what the torque adds
  /// while the wheel gives way most easily (the slider at its dead centre, the rod turning about
  /// it), and a fall of the crank.
  double fastest(double t) const {
    const double inertia = wheel_inertia() + rod_mass * crank * crank / 3.0;
    return std::abs(omega0) + std::abs(torque) * t / inertia + std::sqrt(gravity / crank);
  }
  double slider_inertia() const {
    return slider_mass * (slider_width * slider_width + slider_height * slider_height) / 12.0;
  }

  /// The angle of the rod and the place of the slider that close the loop at a wheel angle. A rod
  /// as long as the crank swings through the wheel's centre: there the branch is the one that
  /// momentum keeps.
  double rod_angle(double theta) const {
    return rod == crank ? -theta : -std::asin(crank * std::sin(theta) / rod);
  }
  double slider_x(double theta) const {
    return crank * std::cos(theta) + rod * std::cos(rod_angle(theta));
  }
};

}  // namespace slider_crank
