#pragma once

#include <Eigen/Core>

#include "scene.hpp"

namespace parabola {

/// The exact motion of the bead, to rounding, at any time.
///
/// Energy is conserved: with V = m g q²/2p − Fx q,
///
///     ½ m q̇² (1 + q²/p²) = V(q0) − V(q).
///
/// Let s be a time of its own that runs by dt = √(1 + q²/p²) ds. Then ½ m (dq/ds)² = V(q0) − V(q):
/// in s the bead moves as an oscillator does on a flat track,
///
///     q(s) = c + (q0 − c) cos ωs,   ω² = g/p,   c = Fx p / (m g),
///
/// or, without gravity, q(s) = q0 + Fx s²/2m. What is left is t(s) = ∫ √(1 + q(s)²/p²) ds, a
/// quadrature, which is inverted by Newton's method. Without a horizontal force it is an elliptic
/// integral of the second kind, ωt = √(1 + m̂) E(φ | m), with φ = ωs, m̂ = q0²/p², m = m̂/(1 + m̂).
///
/// All of it in long double, so that the rounding of t itself is what limits q.
class ExactMotion {
 public:
  struct State {
    double q;     ///< x coordinate [m]
    double qdot;  ///< [m/s]
  };

  explicit ExactMotion(const Scene& scene);

  bool oscillates() const { return g_ > 0; }

  /// Time from one turning point back to it [s]; infinite without gravity.
  double period() const;

  /// The state at t ≥ 0 [s].
  State at(double t) const;

 private:
  using Real = long double;

  Real position(Real s) const;
  Real speed(Real s) const;    // dq/ds
  Real stretch(Real q) const;  // dt/ds

  Real half_period() const;

  /// t(s) within the first half period.
  Real time(Real s) const;

  /// ∫ √(1 + q(s)²/p²) ds, cut where q = 0: far up the valley the integrand has a sharp bend there.
  Real integrate(Real from, Real to) const;

  /// The s in the first half period at which t(s) = t. Newton's steps are kept inside a bracket.
  Real invert(Real t) const;

  Real q0_, p_, pull_, g_;
  Real omega_ = 0, center_ = 0, amplitude_ = 0, m_ = 0, m_complement_ = 1, half_period_ = 0;
};

}  // namespace parabola

namespace particle_on_curve {

/// The exact state of the particle and the exact force that holds it.
struct Exact {
  Eigen::Vector2d x, v;              ///< [m], [m/s]
  Eigen::Vector2d constraint_force;  ///< [N]
};

/// At time t [s]. The force comes from Newton's law across the track, not from the chapter's
/// formula: a particle of speed v on a curve of curvature κ is accelerated by v²κ towards the
/// centre of curvature.
Exact exact(const parabola::Scene& scene, const parabola::ExactMotion& motion, double t);

}  // namespace particle_on_curve
