#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "mechanics/joints/ground.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"

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

/// The scene as a system. The start is taken as given, off its place or not.
inline mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method) {
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  // [scene]
  const auto plate = system.add_body("plate", scene.mass, scene.inertia(),
                                     {scene.offset_x, scene.offset_y}, scene.offset_theta);
  const auto plate_ground = system.add("plate_ground", joints::Ground{}, plate);

  system.set_gravity({0, scene.gravity});
  system.apply(plate, [scene](double t, const dynamics::Body& body) {
    const Eigen::Vector2d arm = body.A * Eigen::Vector2d(scene.width / 2, 0),
                          F(0, scene.load_at(t));
    return Eigen::Vector3d(F.x(), F.y(), arm.x() * F.y() - arm.y() * F.x());
  });
  // [scene]
  mechanism.report("plate_ground", plate_ground, plate);
  mechanism.start_as_given();
  return mechanism;
}

/// A rod that swings from the edge of the plate, and the same rod from a point of the world: what
/// the ground costs when it is simulated. The plate is at rest at the origin in both.
inline mechanics::Mechanism make_pendulum(bool simulate_ground) {
  const Scene scene;
  mechanics::Mechanism mechanism({});
  dynamics::System& system = mechanism.system;
  // [left_out]
  const Eigen::Vector2d edge(scene.width / 2, 0), end(-0.5, 0);
  const auto hang = [&](auto base) {
    const auto rod = system.add_body("rod", 1.0, 1.0 / 12.0, edge - end);
    system.add("rod_base", joints::Revolute{.u1 = end, .u2 = edge}, rod, base);
  };
  if (simulate_ground) {
    const auto plate = system.add_body("plate", scene.mass, scene.inertia(), {0, 0});
    system.add("plate_ground", joints::Ground{}, plate);
    hang(plate);
  } else {
    hang(dynamics::System::world);
  }
  // [left_out]
  system.set_gravity({0, scene.gravity});
  mechanism.assemble();
  return mechanism;
}

}  // namespace ground
