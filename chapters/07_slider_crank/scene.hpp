#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "mechanics/joints/ground.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"

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
  double simulate_frame =
      0.0;  ///< 1: the frame is a body, held by a ground joint; 0: it is left out

  // No options, but other units change them too.
  double frame_mass = 10.0, frame_inertia = 1.0;   ///< [kg], [kg·m²]
  double wheel_radius = 0.4;                       ///< [m]
  double slider_width = 0.3, slider_height = 0.2;  ///< [m]

  /// A rod shorter than the crank does not let the wheel turn.
  void check() const {
    if (rod < crank)
      throw std::invalid_argument("rod " + mechanics::in_digits(rod, 6) +
                                  ": allowed is the crank, " + mechanics::in_digits(crank, 6) +
                                  " m, or more: a shorter rod does not let the wheel turn");
  }

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

/// Where the coordinates of the bodies stand in q; the frame's only where it is simulated.
struct Bodies {
  dynamics::Handle<dynamics::Body> wheel, rod, slider;
  std::optional<dynamics::Handle<dynamics::Body>> frame;
};

/// The scene as a system: wheel, rod and slider, and the frame where it is simulated.
inline mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method,
                                           Bodies* bodies = nullptr) {
  using Eigen::Vector2d;
  using Eigen::VectorXd;
  scene.check();
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  const double theta = scene.theta0, phi = scene.rod_angle(theta), omega = scene.omega0;
  const Vector2d crank_pin = scene.crank * Vector2d(std::cos(theta), std::sin(theta));
  const Vector2d along(std::cos(phi), std::sin(phi));  // the rod, from crank pin to slider

  // The rates that keep the loop closed: the slider does not move across the rail.
  const Vector2d pin_rate = omega * dynamics::S(crank_pin);
  const double phi_rate =
      scene.rod == scene.crank ? -omega : -pin_rate.y() / (scene.rod * along.x());
  const Vector2d rod_rate = pin_rate + phi_rate * scene.rod / 2 * dynamics::S(along);
  const Vector2d slider_rate = pin_rate + phi_rate * scene.rod * dynamics::S(along);

  // [scene]
  const auto build = [&](auto frame) {
    const auto wheel = system.add_body("wheel", scene.wheel_mass, scene.wheel_inertia(),
                                       Vector2d::Zero(), theta, Vector2d::Zero(), omega);
    const auto rod = system.add_body("rod", scene.rod_mass, scene.rod_inertia(),
                                     crank_pin + scene.rod / 2 * along, phi, rod_rate, phi_rate);
    const auto slider = system.add_body("slider", scene.slider_mass, scene.slider_inertia(),
                                        {scene.slider_x(theta), 0.0}, 0.0, {slider_rate.x(), 0.0});

    const auto wheel_frame = system.add("wheel_frame", joints::Revolute{}, wheel, frame);
    const auto rod_wheel =
        system.add("rod_wheel", joints::Revolute{.u1 = {-scene.rod / 2, 0}, .u2 = {scene.crank, 0}},
                   rod, wheel);
    const auto slider_rod =
        system.add("slider_rod", joints::Revolute{.u2 = {scene.rod / 2, 0}}, slider, rod);
    const auto slider_frame = system.add("slider_frame", joints::Prismatic{}, frame, slider);

    system.set_gravity({0, scene.gravity});
    system.apply(wheel, {0, 0, scene.torque});
    // [scene]
    if constexpr (std::is_same_v<decltype(frame), dynamics::Handle<dynamics::World>>) {
      // What does not move needs no coordinates. Its reaction is what the others leave it to carry:
      // its weight, the wheel's pin at its centre, and the slider's push on the rail at the
      // slider's place.
      mechanism.report_fixed("frame");
      mechanism.report("frame_ground", [=, weight = scene.frame_mass * scene.gravity](
                                           const dynamics::Evaluation& e, const VectorXd& q) {
        const Eigen::Vector3d pin = e.reaction(wheel_frame, wheel);
        const Eigen::Vector3d rail = e.reaction(slider_frame, slider);
        const Vector2d x = q.segment<2>(slider.column);
        return Eigen::Vector3d(pin.x() + rail.x(), pin.y() + rail.y() - weight,
                               rail.z() + x.x() * rail.y() - x.y() * rail.x());
      });
    } else {
      const auto frame_ground = system.add("frame_ground", joints::Ground{}, frame);
      mechanism.report("frame_ground", frame_ground, frame);
    }
    mechanism.report("wheel_frame", wheel_frame, wheel);
    mechanism.report("rod_wheel", rod_wheel, rod);
    mechanism.report("slider_rod", slider_rod, slider);
    mechanism.report("slider_frame", slider_frame, slider);
    mechanism.work = [=, torque = scene.torque](const VectorXd& q) {
      return torque * (q[wheel.column + 2] - theta);
    };
    if (bodies == nullptr) return;
    *bodies = {wheel, rod, slider, {}};
    if constexpr (!std::is_same_v<decltype(frame), dynamics::Handle<dynamics::World>>)
      bodies->frame = frame;
  };

  if (scene.simulate_frame != 0.0)
    build(system.add_body("frame", scene.frame_mass, scene.frame_inertia, Vector2d::Zero()));
  else
    build(dynamics::System::world);
  mechanism.assemble();
  return mechanism;
}

}  // namespace slider_crank
