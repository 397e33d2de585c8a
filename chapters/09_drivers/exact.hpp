#pragma once

#include "07_slider_crank/exact.hpp"

namespace drivers {

using slider_crank::Real;

/// The crank as it is told to move: angle [rad], rate [rad/s], acceleration [rad/s²]. With that the
/// motion is known, and what is asked for are forces.
struct Crank {
  Real theta, omega, alpha;
};

/// The torque [N·m] that the motor needs, by Lagrange's equation of chapter 7 read the other way:
///
///     λ = μ(θ) α + ½ μ'(θ) ω² − m_r g y_r'(θ)
///
/// The machine's own torque does not count.
Real torque(const slider_crank::Scene& machine, const Crank& crank);

/// The forces of the joints: those of chapter 7 under this torque.
slider_crank::Reactions reactions(const slider_crank::Scene& machine, const Crank& crank);

/// Kinetic and potential energy [J]; what it gains is the work of the motor.
Real energy(const slider_crank::Scene& machine, const Crank& crank);

}  // namespace drivers
