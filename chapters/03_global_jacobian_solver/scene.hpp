#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "01_particle_on_curve_implicit/scene.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/on_curve.hpp"
#include "mechanics/motion/mechanism.hpp"

namespace dumbbell {

using Eigen::Vector2d;

/// Two beads on the parabola x² + 2py = 0, joined by a rigid rod without mass, released from rest.
struct Scene {
  double x1 = 20.0, x2 = 60.0;  ///< where the beads start [m]
  double m1 = 1.0, m2 = 2.0;    ///< their masses [kg]
  double gravity = 9.81;        ///< along +y: down [m/s²]
  double p = 50.0;              ///< half the parameter of the curve [m]

  Vector2d on_curve(double x) const { return {x, -x * x / (2.0 * p)}; }
  double rod() const { return (on_curve(x2) - on_curve(x1)).norm(); }  ///< its length [m]

  /// A rod needs a length, and more of it than the rounding of the two places.
  void check() const {
    const double least = 1e-6 * std::max(std::abs(x1), std::abs(x2));
    if (x1 == x2 || std::abs(x2 - x1) < least)
      throw std::invalid_argument(
          "x2 " + mechanics::in_digits(x2, 6) + ": allowed is a place at least " +
          mechanics::in_digits(least, 3) + " m away from x1, " + mechanics::in_digits(x1, 6) +
          "; the rod between the beads needs a length");
  }
};

/// The parts of the scene, to ask the system for their state and forces.
struct Parts {
  dynamics::Handle<dynamics::Particle> bead1, bead2;
  dynamics::JointHandle bead1_curve, bead2_curve, bead1_bead2;
};

/// The scene as a system.
inline mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method,
                                           Parts* parts = nullptr) {
  scene.check();
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;

  // [scene]
  const auto bead1 = system.add_particle("bead1", scene.m1, scene.on_curve(scene.x1));
  const auto bead2 = system.add_particle("bead2", scene.m2, scene.on_curve(scene.x2));

  const joints::OnCurve<joints::Parabola> curve{{scene.p}};
  const auto bead1_curve = system.add("bead1_curve", curve, bead1);
  const auto bead2_curve = system.add("bead2_curve", curve, bead2);
  const auto bead1_bead2 =
      system.add("bead1_bead2", joints::Distance{.length = scene.rod()}, bead1, bead2);

  system.set_gravity({0, scene.gravity});
  // [scene]

  mechanism.report("bead1_curve", bead1_curve, bead1);
  mechanism.report("bead2_curve", bead2_curve, bead2);
  mechanism.report("bead1_bead2", bead1_bead2, bead1);
  mechanism.assemble();
  if (parts != nullptr) *parts = {bead1, bead2, bead1_curve, bead2_curve, bead1_bead2};
  return mechanism;
}

/// Chapter 1's scene, given to the same solver: one bead, one curve.
struct OneBead {
  explicit OneBead(const parabola::Scene& scene, const mechanics::Method& method = {})
      : mechanism(method) {
    dynamics::System& system = mechanism.system;
    // [one_bead]
    bead = system.add_particle("particle", scene.mass, {scene.x0, scene.height(scene.x0)});
    curve = system.add("particle_curve", joints::OnCurve<joints::Parabola>{{scene.p}}, bead);
    system.set_gravity({0, scene.gravity});
    system.apply(bead, {scene.force_x, 0});
    // [one_bead]
    mechanism.assemble();
  }

  /// λ of the curve in a state, and the force [N] that it stands for.
  struct Answer {
    double lambda;
    Vector2d force;
  };
  Answer solve(const Vector2d& x, const Vector2d& v) {
    Eigen::VectorXd a(2);
    mechanism.acceleration(0.0, x, v, a);
    return {mechanism.evaluation().lambda(curve)[0],
            mechanism.evaluation().reaction(curve, bead).head<2>()};
  }

  mechanics::Mechanism mechanism;
  dynamics::Handle<dynamics::Particle> bead;
  dynamics::JointHandle curve;
};

}  // namespace dumbbell
