#pragma once

#include <string>

#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"
#include "scene.hpp"
#include "turned_off.hpp"

namespace revolute {

template <class Joint>
mechanics::Mechanism make_chain(const Scene& scene, const mechanics::Method& method) {
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  system.set_gravity({0.0, scene.gravity});

  const int N = scene.links;
  const Vector2d start(-scene.l() / 2, 0.0), end(scene.l() / 2, 0.0);  // in a rod's own frame
  dynamics::Handle<dynamics::Body> before;
  std::string name_before = "world";
  for (int i = 0; i < N; ++i) {
    const std::string name = N == 1 ? "rod" : "rod" + std::to_string(i + 1);
    const Vector2d x = (i + 0.5) * scene.l() * direction(scene.angle0);
    const auto rod = system.add_body(name, scene.m(), scene.I(), x, scene.angle0);
    const std::string joint = name + "_" + name_before;
    const auto pin = i == 0 ? system.add(joint, Joint({start, {0.0, 0.0}}), rod, system.world)
                            : system.add(joint, Joint({start, end}), rod, before);
    mechanism.report(joint, pin, rod);
    before = rod;
    name_before = name;
  }
  mechanism.assemble();
  return mechanism;
}

inline mechanics::Mechanism make_mechanism(const Scene& scene,
                                           const mechanics::Method& method = {}) {
  return scene.without_jdotv ? make_chain<WithoutJdotV<joints::Revolute>>(scene, method)
                             : make_chain<joints::Revolute>(scene, method);
}

}  // namespace revolute
