#pragma once

#include "01_particle_on_curve_implicit/scene.hpp"
#include "mechanics/joints/on_curve.hpp"
#include "mechanics/motion/mechanism.hpp"
#include "scene.hpp"

namespace dumbbell {

/// The parts of the scene, to ask the system for their state and forces.
struct Parts {
  dynamics::Handle<dynamics::Particle> bead1, bead2;
  dynamics::JointHandle bead1_curve, bead2_curve, bead1_bead2;
};

/// The scene as a system. std::invalid_argument where the rod would have no length.
mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method,
                                    Parts* parts = nullptr);

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
