#include "mechanism.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mechanics/joints/distance.hpp"

namespace dumbbell {
namespace {

/// A rod needs a length, and more of it than the rounding of the two places.
void check(const Scene& scene) {
  const double x1 = scene.x1, x2 = scene.x2;
  const double least = 1e-6 * std::max(std::abs(x1), std::abs(x2));
  if (x1 == x2 || std::abs(x2 - x1) < least)
    throw std::invalid_argument("x2 " + mechanics::in_digits(x2, 6) +
                                ": allowed is a place at least " + mechanics::in_digits(least, 3) +
                                " m away from x1, " + mechanics::in_digits(x1, 6) +
                                "; the rod between the beads needs a length");
}

}  // namespace

mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method,
                                    Parts* parts) {
  check(scene);
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;

  const auto bead1 = system.add_particle("bead1", scene.m1, scene.on_curve(scene.x1));
  const auto bead2 = system.add_particle("bead2", scene.m2, scene.on_curve(scene.x2));

  const joints::OnCurve<joints::Parabola> curve{{scene.p}};
  const auto bead1_curve = system.add("bead1_curve", curve, bead1);
  const auto bead2_curve = system.add("bead2_curve", curve, bead2);
  const auto bead1_bead2 =
      system.add("bead1_bead2", joints::Distance{.length = scene.rod()}, bead1, bead2);

  system.set_gravity({0, scene.gravity});

  mechanism.report("bead1_curve", bead1_curve, bead1);
  mechanism.report("bead2_curve", bead2_curve, bead2);
  mechanism.report("bead1_bead2", bead1_bead2, bead1);
  mechanism.assemble();
  if (parts != nullptr) *parts = {bead1, bead2, bead1_curve, bead2_curve, bead1_bead2};
  return mechanism;
}

}  // namespace dumbbell
