#pragma once

#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"
#include "scene.hpp"

namespace prismatic {

// [incline]
/// The rail is a line of the world, and the world has no coordinates: one body, two rows.
inline mechanics::Mechanism make_incline(const Scene& scene, const mechanics::Method& method = {}) {
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  system.set_gravity({0.0, scene.gravity});
  const auto block =
      system.add_body("block", scene.mass, scene.inertia(), {0.0, 0.0}, scene.angle());
  const joints::Prismatic rail{.n_hat = across(scene.angle()), .theta21 = scene.angle()};
  mechanism.report("block_rail", system.add("block_rail", rail, system.world, block), block);
  mechanism.assemble();
  return mechanism;
}
// [incline]

// [spin]
/// The rail is a body: two bodies, a pin and a rail, four rows. Rail and block turn together.
template <class Joint = joints::Prismatic>
mechanics::Mechanism make_spin(const Scene& scene, const mechanics::Method& method = {}) {
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  const double r0 = scene.r0, spin = scene.spin;
  const auto rail = system.add_body("rail", scene.rail_mass, scene.rail_inertia, {0.0, 0.0}, 0.0,
                                    {0.0, 0.0}, spin);
  const auto block =
      system.add_body("block", scene.mass, scene.inertia(), {r0, 0.0}, 0.0, {0.0, spin * r0}, spin);
  const auto pin = system.add("rail_world", joints::Revolute{}, rail, system.world);
  const auto slide = system.add("block_rail", Joint{}, rail, block);
  mechanism.report("block_rail", slide, block);
  mechanism.report("rail_world", pin, rail);
  mechanism.assemble();
  return mechanism;
}
// [spin]

inline mechanics::Mechanism make_mechanism(const Scene& scene,
                                           const mechanics::Method& method = {}) {
  return scene.spins() ? make_spin(scene, method) : make_incline(scene, method);
}

}  // namespace prismatic
