#pragma once

#include "implicit_bead.hpp"

namespace particle_on_curve {

/// The bead without J̇v: its constraint force is computed as if it stood still, so the curve gives
/// way to it in every bend. C̈ = 2 vx² is left over.
class WithoutJdotV : public parabola::ImplicitBead {
 public:
  explicit WithoutJdotV(const parabola::Scene& scene) : ImplicitBead(scene), scene_(scene) {}

  // [without]
  void acceleration(double, const Vector& x, const Vector&, Vector& a) const {
    const Vector F = scene_.applied_force();
    a = (F + constraint_force(x, Vector::Zero(), F)) / scene_.mass;
  }
  // [without]

 private:
  parabola::Scene scene_;
};

}  // namespace particle_on_curve
