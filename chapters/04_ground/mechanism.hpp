#pragma once

#include "mechanics/motion/mechanism.hpp"
#include "scene.hpp"

namespace ground {

/// The scene as a system. The start is taken as given, off its place or not.
mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method);

/// A rod that swings from the edge of the plate, and the same rod from a point of the world: what
/// the ground costs when it is simulated. The plate is at rest at the origin in both.
mechanics::Mechanism make_pendulum(bool simulate_ground);

}  // namespace ground
