#include "exact.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

namespace prismatic {
namespace {

/// The incline: a constant acceleration along the rail, nothing across it, and no turning.
Exact exact_incline(const Scene& scene, double t) {
  const double beta = scene.angle(), a = scene.gravity * std::sin(beta);
  return {a * t * t / 2 * along(beta),
          a * t * along(beta),
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
  using Real = long double;

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
