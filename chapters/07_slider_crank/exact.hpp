#pragma once

#include <Eigen/Core>
#include <optional>

#include "scene.hpp"

namespace slider_crank {

using Real = long double;

/// The mechanism by its one degree of freedom, the wheel's angle θ: places of its bodies, their
/// first and second derivatives with respect to θ, and what follows from them.
///
///     crank pin  P = R (cos θ, sin θ)
///     slider     xs = R cos θ + c,  c = √(L² − R² sin²θ)         on the rail y = 0
///     rod        centre (R cos θ + c/2, R sin θ/2), angle φ with sin φ = −R sin θ/L, cos φ = c/L
///
///     μ(θ) = Iw + mr (x'² + y'²) + Ir φ'² + ms xs'²              T = ½ μ θ̇²
///     μ θ̈ + ½ μ' θ̇² = τ + mr g y'                                 Lagrange's equation
class Reduced {
 public:
  struct Derivatives {
    Real value, first, second;
  };

  explicit Reduced(const Scene& scene);

  struct Pose {
    Derivatives xs, x, y, phi;
  };

  Pose pose(Real theta) const;
  Real mu(const Pose& at) const;
  Real angular_acceleration(const Pose& at, Real omega) const;

  /// An angle from which energy is counted, and the moment τ − V' there.
  struct Mark {
    Real theta, sine, cosine, moment;
  };
  Mark mark(Real theta) const;
  /// The mark δ further on, to the digits of δ: the moment may all but vanish.
  Mark moved(const Mark& from, Real delta) const;
  /// τ δ − (V(θ + δ) − V(θ)) = τ δ + ½ mr g R (sin(θ + δ) − sin θ). Where δ is small, moment times
  /// δ comes first and what bends the curve after it, so that no digits are lost close to a
  /// balance.
  Real work(const Mark& from, Real delta) const;

  Real R, L, torque, g, wheel_mass, rod_mass, slider_mass, wheel_inertia, rod_inertia;
  Real pull;  ///< moment of the weight where the crank is level
};

/// The exact motion, in long double. Energy gives the speed at every angle,
///
///     ½ μ(θ) θ̇² = ½ μ(θ0) ω0² + work(θ),
///
/// and with it every place where the crank turns back. Between two of them it swings for ever; from
/// a single one, which lies ahead or behind, it runs away; and where there is none and no torque
/// either, all revolutions take the same time.
class Exact {
 public:
  struct State {
    Real theta, omega;
  };

  explicit Exact(const Scene& scene);

  /// The state at t ≥ 0 [s]. Nothing where it would take more than about a second to compute: close
  /// to a motion that takes for ever to reach the top, or after ten thousands of revolutions under
  /// a torque; and nothing where the rounding of t alone is felt, after 10¹⁰ rad.
  std::optional<State> at(double t) const;

 private:
  /// How far it is in a direction (±1) to the first place where the crank comes to rest.
  std::optional<Real> turn(Real way) const;

  std::optional<State> swinging(Real t) const;
  std::optional<State> turning_back(Real t) const;
  std::optional<State> running_away(Real t) const;

  /// Past a single place of rest, before which (or after which) it is at θ0.
  std::optional<State> from_rest(const Reduced::Mark& place, Real way_out, Real distance, Real t,
                                 bool before) const;

  std::optional<State> revolving(Real t) const;

  Reduced reduced_;
  Reduced::Mark mark_;
  Real omega0_, start_;  // ½ μ ω² at the start
  Real way_ = 1;
  std::optional<Real> ahead_, behind_;  // distances to where the crank is at rest
  bool at_rest_for_ever_ = false;
};

/// What holds the mechanism together: force [N] and moment [N·m] on the body each joint's name
/// starts with.
struct Reactions {
  Eigen::Vector2d wheel_frame, rod_wheel, slider_rod, slider_frame, frame_ground;
  double frame_ground_moment;
};

/// From Newton's and Euler's laws, body by body, with the accelerations that θ, θ̇ and θ̈ give.
Reactions reactions(const Scene& scene, const Exact::State& state);

}  // namespace slider_crank
