#include "exact.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

namespace prismatic {
namespace {

using Real = long double;

/// (1 − e^−x)/x.
Real fading(Real x) { return x == 0 ? 1 : -std::expm1(-x) / x; }

/// What an oscillator makes of a push, from rest at its place: u after one that gives it a unit of
/// velocity, p after a steady one that gives it a unit of acceleration,
///
///     ü + 2γ u̇ + κ u = 0,  u(0) = 0,  u̇(0) = 1,      p = ∫ u dt,
///
/// written so that nothing cancels in any regime, and nothing overflows.
struct Push {
  Real u, p;
};

Push push(Real kappa, Real gamma, Real t) {
  const Real d = gamma * gamma - kappa, w = std::sqrt(std::abs(d));
  const Real fast = d > 0 ? gamma + w : std::sqrt(kappa);  // the larger root's size
  if (fast * t < 1) {  // hardly begun: term by term, uₙ = u⁽ⁿ⁾(0) tⁿ/n!
    Push sum{0, 0};
    Real u_n = 0, next = t;
    for (int n = 0; n < 24; ++n) {
      sum.u += u_n;
      sum.p += u_n * t / Real(n + 1);
      const Real after = -(2 * gamma * next + kappa * t * u_n / Real(n + 1)) * t / Real(n + 2);
      u_n = next;
      next = after;
    }
    return sum;
  }
  if (d <= 0) {  // it swings, or, with w = 0, is damped critically
    const Real f = std::exp(-gamma * t), s = w > 0 ? std::sin(w * t) / w : t;
    return {f * s, (1 - f * (std::cos(w * t) + gamma * s)) / kappa};
  }
  const Real slow = kappa / fast, f = std::exp(-slow * t), s = t * fading(2 * w * t);
  return {f * s, (t * fading(slow * t) - f * s) / fast};
}

/// The fixed rail: nothing across it and no turning; along it s̈ + 2γ ṡ + κ s = a, of which the
/// motion is made of the start and pushes. u̇ is the equation of u, integrated once.
Exact exact_incline(const Scene& scene, double t) {
  const double beta = scene.angle();
  const Real m = scene.mass, kappa = scene.stiffness / m, gamma = scene.damping / (2 * m);
  const Real s0 = scene.s0, v0 = scene.v0, a = scene.gravity * std::sin(beta);
  const auto [u, p] = push(kappa, gamma, t);
  const Real s = s0 * (1 - kappa * p) + v0 * u + a * p;
  const Real v = v0 * (1 - 2 * gamma * u - kappa * p) + (a - kappa * s0) * u;
  return {static_cast<double>(s) * along(beta),
          static_cast<double>(v) * along(beta),
          beta,
          0.0,
          -scene.mass * scene.gravity * std::cos(beta) * across(beta),
          0.0};
}

/// The spinning rail, by what it conserves. About the pin the inertia is I(r) = Is + m r², with Is
/// of rail and block about their own centres. Angular momentum gives ω = ω0 I(r0)/I(r), energy then
/// ṙ² = ω0² (r² − r0²) I(r0)/I(r). At the start ṙ = 0, and dt = dr/ṙ is infinite; r = r0 cosh η
/// takes that away:
///
///   dt = √(I(r)/I(r0)) dη / ω0,    dθ = ω dt = √(I(r0)/I(r)) dη.
class SpinMotion {
 public:
  explicit SpinMotion(const Scene& scene)
      : scene_(scene), Is_(Real(scene.rail_inertia) + scene.inertia()) {}

  Exact at(double t) const {
    const Real omega0 = std::abs(scene_.spin), m = scene_.mass, eta = eta_at(omega0 * t);
    const Real r = scene_.r0 * std::cosh(eta), rate = omega0 / root(eta);
    const Real omega = rate / root(eta);
    const Real rdot = scene_.r0 * std::sinh(eta) * rate;
    const Real force = 2 * m * rdot * omega * Is_ / I(r);  // m (r ω̇ + 2 ṙ ω)
    const Real moment = -scene_.inertia() * 2 * m * r * rdot * omega / I(r);  // of ω̇
    const double sign = scene_.spin < 0 ? -1.0 : 1.0;
    const auto number = [](Real value) { return static_cast<double>(value); };
    const double theta = sign * number(integral([this](Real s) { return 1 / root(s); }, eta));
    return {number(r) * along(theta),
            number(rdot) * along(theta) + sign * number(r * omega) * across(theta),
            theta,
            sign * number(omega),
            sign * number(force) * across(theta),
            sign * number(moment)};
  }

 private:
  Real I(Real r) const { return Is_ + Real(scene_.mass) * r * r; }
  /// √(I(r)/I(r0)) at r = r0 cosh η.
  Real root(Real eta) const { return std::sqrt(I(scene_.r0 * std::cosh(eta)) / I(scene_.r0)); }

  template <class Function>
  static Real integral(const Function& f, Real eta) {
    using Quadrature = boost::math::quadrature::gauss_kronrod<Real, 61>;
    return eta > 0 ? Quadrature::integrate(f, Real(0), eta, 10, Real(1e-16L)) : Real(0);
  }

  /// The η that is reached when ω0 t = T, by Newton's method from above: η ≤ T since root ≥ 1, and
  /// κ sinh η ≤ T since root ≥ κ cosh η.
  Real eta_at(Real T) const {
    const Real kappa = std::sqrt(Real(scene_.mass) / I(scene_.r0)) * scene_.r0;
    Real eta = std::min(T, std::asinh(T / kappa));
    for (int i = 0; i < 60; ++i) {
      const Real change = (integral([this](Real s) { return root(s); }, eta) - T) / root(eta);
      eta -= change;
      if (std::abs(change) <= 1e-18L * eta) break;
    }
    return eta;
  }

  Scene scene_;
  Real Is_;
};

}  // namespace

Exact exact(const Scene& scene, double t) {
  return scene.spins() ? SpinMotion(scene).at(t) : exact_incline(scene, t);
}

}  // namespace prismatic
