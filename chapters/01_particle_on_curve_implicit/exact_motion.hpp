#pragma once

#include <algorithm>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/math/special_functions/ellint_rd.hpp>
#include <boost/math/special_functions/ellint_rf.hpp>
#include <boost/math/special_functions/ellint_rg.hpp>
#include <cmath>
#include <limits>
#include <numbers>

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

  explicit ExactMotion(const Scene& scene)
      : q0_(scene.x0), p_(scene.p), pull_(Real(scene.force_x) / scene.mass), g_(scene.gravity) {
    if (!oscillates()) return;
    omega_ = std::sqrt(g_ / p_);
    center_ = pull_ / (omega_ * omega_);
    amplitude_ = q0_ - center_;
    const Real m_hat = q0_ * q0_ / (p_ * p_);
    m_ = m_hat / (1 + m_hat);
    m_complement_ = 1 / (1 + m_hat);
    half_period_ = half_period();
  }

  bool oscillates() const { return g_ > 0; }

  /// Time from one turning point back to it [s]; infinite without gravity.
  double period() const {
    return oscillates() ? static_cast<double>(2 * half_period_)
                        : std::numeric_limits<double>::infinity();
  }

  /// The state at t ≥ 0 [s].
  State at(double t) const {
    // Only the first half period is ever inverted: the way back is the way there, run backwards.
    const Real halves = oscillates() ? std::floor(t / half_period_) : 0;
    const Real rest =
        oscillates() ? std::clamp(t - halves * half_period_, Real(0), half_period_) : t;
    const bool back = std::fmod(halves, Real(2)) != 0;
    const Real s = invert(back ? half_period_ - rest : rest);
    const Real qdot = speed(s) / stretch(position(s));
    return {static_cast<double>(position(s)), static_cast<double>(back ? -qdot : qdot)};
  }

 private:
  using Real = long double;
  static constexpr Real pi = std::numbers::pi_v<Real>;

  Real position(Real s) const {
    return oscillates() ? center_ + amplitude_ * std::cos(omega_ * s) : q0_ + pull_ * s * s / 2;
  }
  Real speed(Real s) const {  // dq/ds
    return oscillates() ? -amplitude_ * omega_ * std::sin(omega_ * s) : pull_ * s;
  }
  Real stretch(Real q) const { return std::hypot(Real(1), q / p_); }  // dt/ds

  Real half_period() const {
    if (pull_ != 0) return integrate(0, pi / omega_);
    return std::sqrt(1 + q0_ * q0_ / (p_ * p_)) / omega_ * 2 *
           boost::math::ellint_rg(Real(0), m_complement_, Real(1)) * 2;
  }

  /// t(s) within the first half period.
  Real time(Real s) const {
    if (!oscillates() || pull_ != 0) return integrate(0, s);
    const Real phi = omega_ * s;
    // E(φ|m) for φ ≤ π/2 in Carlson's symmetric forms, all terms positive (DLMF 19.25.10), so that
    // m close to 1 (a start far up the valley) costs no digits.
    const auto E = [&](Real sine, Real cosine) {
      const Real c2 = cosine * cosine, delta2 = c2 + m_complement_ * sine * sine;
      if (sine == 0) return Real(0);
      return m_complement_ * sine * boost::math::ellint_rf(c2, delta2, Real(1)) +
             m_ * m_complement_ * sine * sine * sine / 3 *
                 boost::math::ellint_rd(c2, Real(1), delta2) +
             m_ * sine * std::abs(cosine) / std::sqrt(delta2);
    };
    const Real scale = std::sqrt(1 + q0_ * q0_ / (p_ * p_)) / omega_;
    const Real part = scale * E(std::sin(phi), std::cos(phi));
    return phi <= pi / 2 ? part : half_period_ - part;
  }

  /// ∫ √(1 + q(s)²/p²) ds, cut where q = 0: far up the valley the integrand has a sharp bend there.
  Real integrate(Real from, Real to) const {
    Real cut = to;
    if (oscillates()) {
      const Real cosine = amplitude_ != 0 ? -center_ / amplitude_ : 2;
      if (std::abs(cosine) < 1) cut = std::clamp(std::acos(cosine) / omega_, from, to);
    } else if (pull_ != 0 && q0_ / pull_ < 0) {
      cut = std::clamp(std::sqrt(-2 * q0_ / pull_), from, to);
    }
    // Its nodes crowd towards both ends of (−1, 1), and so around the bend.
    static boost::math::quadrature::tanh_sinh<Real> rule;
    const auto piece = [this](Real a, Real b) {
      const Real middle = (a + b) / 2, half = (b - a) / 2;
      const auto dt_dx = [=, this](Real x) { return half * stretch(position(middle + half * x)); };
      return a < b ? rule.integrate(dt_dx, Real(1e-17)) : Real(0);
    };
    return piece(from, cut) + piece(cut, to);
  }

  /// The s in the first half period at which t(s) = t. Newton's steps are kept inside a bracket.
  Real invert(Real t) const {
    Real low = 0, high = oscillates() ? pi / omega_ : t;  // dt/ds ≥ 1, so s ≤ t
    Real s = oscillates() ? high * (t / half_period_) : high / 2;
    for (int i = 0; i < 200; ++i) {
      const Real excess = time(s) - t;
      (excess > 0 ? high : low) = s;
      Real next = s - excess / stretch(position(s));
      if (!(next >= low && next <= high)) next = low + (high - low) / 2;
      if (std::abs(next - s) <= 4 * std::numeric_limits<Real>::epsilon() * high) return next;
      s = next;
    }
    return s;
  }

  Real q0_, p_, pull_, g_;
  Real omega_ = 0, center_ = 0, amplitude_ = 0, m_ = 0, m_complement_ = 1, half_period_ = 0;
};

}  // namespace parabola
