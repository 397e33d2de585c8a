#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"
#include "scene.hpp"
#include "turned_off.hpp"

namespace prismatic {

// [spring]
/// Spring and damper along the fixed rail: −k s − c ṡ on the block, where s is its way from (0, 0).
inline void hold(mechanics::Mechanism& mechanism, dynamics::Handle<dynamics::Body> block,
                 const Scene& scene) {
  const Vector2d e = along(scene.angle());
  const double k = scene.stiffness, c = scene.damping;
  const dynamics::ForceLaw<dynamics::Body> law = [=](double, const dynamics::Body& body) {
    const Vector2d F = -(k * e.dot(body.x) + c * e.dot(body.v)) * e;
    return Eigen::Vector3d(F.x(), F.y(), 0.0);
  };
  const dynamics::Potential<dynamics::Body> potential = [=](const dynamics::Body& body) {
    return 0.5 * k * e.dot(body.x) * e.dot(body.x);
  };
  mechanism.system.apply(block, law, potential);
  if (c != 0.0) mechanism.work = mechanics::dissipated;
}
// [spring]

/// The rail is a line of the world, and the world has no coordinates: one body, two rows.
inline mechanics::Mechanism make_incline(const Scene& scene, const mechanics::Method& method = {}) {
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  system.set_gravity({0.0, scene.gravity});
  const Vector2d none(0.0, 0.0), e = along(scene.angle());  // none + 0 e is 0 and not −0
  const auto block = system.add_body("block", scene.mass, scene.inertia(), none + scene.s0 * e,
                                     scene.angle(), none + scene.v0 * e);
  const joints::Prismatic rail{.n_hat = across(scene.angle()), .theta21 = scene.angle()};
  mechanism.report("block_rail", system.add("block_rail", rail, system.world, block), block);
  if (scene.sprung()) hold(mechanism, block, scene);
  mechanism.assemble();
  return mechanism;
}

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

/// std::invalid_argument for what acts along the fixed rail only, on one that spins, and for the
/// reverse.
inline mechanics::Mechanism make_mechanism(const Scene& scene,
                                           const mechanics::Method& method = {}) {
  if (!scene.spins() && scene.without_coriolis)
    throw std::invalid_argument(
        "--without coriolis: allowed only with --spin; on a fixed rail that term is zero");
  if (!scene.spins()) return make_incline(scene, method);
  for (const auto& [option, value] : {std::pair{"stiffness", scene.stiffness},
                                      {"damping", scene.damping},
                                      {"s0", scene.s0},
                                      {"v0", scene.v0}})
    if (value != 0.0)
      throw std::invalid_argument(std::string(option) + " " + mechanics::in_digits(value, 6) +
                                  ": allowed with --spin is only 0, it belongs to the fixed rail");
  return scene.without_coriolis ? make_spin<WithoutCoriolis>(scene, method)
                                : make_spin(scene, method);
}

}  // namespace prismatic
