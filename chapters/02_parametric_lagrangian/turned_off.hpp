#pragma once

#include "parametric_bead.hpp"

namespace parametric_lagrangian {

/// The particle without the term −q q̇²: as if the inertia m(1 + q²/p²) of its coordinate did not
/// change on the way. It cannot leave the curve, but it is not driven by Lagrange's equation
/// either.
class WithoutVelocityTerm : public ParametricBead {
 public:
  using ParametricBead::ParametricBead;

  // [without]
  void acceleration(double t, double q, double, double& qddot) const {
    ParametricBead::acceleration(t, q, 0.0, qddot);
  }
  // [without]
};

}  // namespace parametric_lagrangian
