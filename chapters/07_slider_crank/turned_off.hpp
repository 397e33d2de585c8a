#pragma once

#include "mechanism.hpp"

namespace slider_crank {

/// The mechanism without J̇v: its joints are solved as if everything stood still, so they give way
/// where bodies turn. Gravity and torque act as before, since neither depends on the velocities.
class WithoutJdotV : public mechanics::Mechanism {
 public:
  explicit WithoutJdotV(mechanics::Mechanism mechanism) : Mechanism(std::move(mechanism)) {
    at_rest_ = Vector::Zero(initial_velocity().size());
  }

  // [without]
  void acceleration(double t, const Vector& q, const Vector&, Vector& a) {
    Mechanism::acceleration(t, q, at_rest_, a);
  }
  // [without]

 private:
  Vector at_rest_;
};

}  // namespace slider_crank
