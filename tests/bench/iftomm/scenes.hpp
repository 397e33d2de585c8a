// Two problems of the IFToMM benchmark library for multibody dynamics (www.iftomm-multibody.org),
// group A: A01, the simple pendulum, and A02, the mechanism of N four-bar linkages.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"

namespace iftomm {

using Eigen::Vector2d;

/// A01: 1 kg on a massless rod of 1 m, released at rest from the horizontal.
struct Pendulum {
  double mass = 1.0, length = 1.0, gravity = 9.81;  ///< [kg], [m], [m/s²]
};

inline mechanics::Mechanism make_mechanism(const Pendulum& scene,
                                           const mechanics::Method& method = {}) {
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  system.set_gravity({0.0, scene.gravity});
  const auto bob = system.add_particle("bob", scene.mass, {-scene.length, 0.0});
  const auto rod = system.add("bob_world", joints::Distance{scene.length}, bob);
  mechanism.report("bob_world", rod, bob);
  mechanism.assemble();
  return mechanism;
}

/// A02: N + 1 uprights, pinned to the ground 1 m apart, and N tops that join their ends; every link
/// is uniform, 1 m long, 1 kg. The uprights stand, the tops start along +x. Each time the uprights
/// lie along the ground all links are in one line and J loses rank.
struct FourBars {
  int loops = 2;       ///< N
  double speed = 1.0;  ///< of the tops at the start [m/s]
  double gravity = 9.81;

  static constexpr double length = 1.0, mass = 1.0;  ///< of a link [m], [kg]
  static constexpr double inertia = mass * length * length / 12.0;
};

inline mechanics::Mechanism make_mechanism(const FourBars& scene,
                                           const mechanics::Method& method = {}) {
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  system.set_gravity({0.0, scene.gravity});
  constexpr double l = FourBars::length, m = FourBars::mass, I = FourBars::inertia;
  const Vector2d start(-l / 2, 0.0), end(l / 2, 0.0);  // of a link in its own frame
  std::vector<dynamics::Handle<dynamics::Body>> uprights;
  for (int i = 0; i <= scene.loops; ++i) {
    const Vector2d pivot(i * l, 0.0);
    const auto upright =
        system.add_body(fmt::format("upright{}", i), m, I, pivot + Vector2d(0.0, -l / 2),
                        -std::numbers::pi / 2, {scene.speed / 2, 0.0}, scene.speed / l);
    const std::string name = fmt::format("upright{}_ground", i);
    mechanism.report(name, system.add(name, joints::Revolute{start, pivot}, upright, system.world),
                     upright);
    uprights.push_back(upright);
  }
  for (int i = 0; i < scene.loops; ++i) {
    const auto top = system.add_body(fmt::format("top{}", i), m, I, {(i + 0.5) * l, -l}, 0.0,
                                     {scene.speed, 0.0}, 0.0);
    system.add(fmt::format("top{}_left", i), joints::Revolute{start, end}, top,
               uprights[static_cast<std::size_t>(i)]);
    system.add(fmt::format("top{}_right", i), joints::Revolute{end, end}, top,
               uprights[static_cast<std::size_t>(i) + 1]);
  }
  mechanism.assemble();
  return mechanism;
}

}  // namespace iftomm
