#include "exact.hpp"

#include <algorithm>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/math/special_functions/ellint_rd.hpp>
#include <boost/math/special_functions/ellint_rf.hpp>
#include <boost/math/special_functions/ellint_rg.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace parabola {
namespace {

constexpr long double pi = std::numbers::pi_v<long double>;

}  // namespace

ExactMotion::ExactMotion(const Scene& scene)
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

double ExactMotion::period() const {
  return oscillates() ? static_cast<double>(2 * half_period_)
                      : std::numeric_limits<double>::infinity();
}

ExactMotion::State ExactMotion::at(double t) const {
  // Only the first half period is ever inverted: the way back is the way there, run backwards.
  const Real halves = oscillates() ? std::floor(t / half_period_) : 0;
  const Real rest = oscillates() ? std::clamp(t - halves * half_period_, Real(0), half_period_) : t;
  const bool back = std::fmod(halves, Real(2)) != 0;
  const Real s = invert(back ? half_period_ - rest : rest);
  const Real qdot = speed(s) / stretch(position(s));
  return {static_cast<double>(position(s)), static_cast<double>(back ? -qdot : qdot)};
}

ExactMotion::Real ExactMotion::position(Real s) const {
  return oscillates() ? center_ + amplitude_ * std::cos(omega_ * s) : q0_ + pull_ * s * s / 2;
}

ExactMotion::Real ExactMotion::speed(Real s) const {
  return oscillates() ? -amplitude_ * omega_ * std::sin(omega_ * s) : pull_ * s;
}

ExactMotion::Real ExactMotion::half_period() const {
  if (pull_ != 0) return integrate(0, pi / omega_);
  return std::sqrt(1 + q0_ * q0_ / (p_ * p_)) / omega_ * 2 *
         boost::math::ellint_rg(Real(0), m_complement_, Real(1)) * 2;
}

ExactMotion::Real ExactMotion::time(Real s) const {
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

ExactMotion::Real ExactMotion::integrate(Real from, Real to) const {
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

ExactMotion::Real ExactMotion::invert(Real t) const {
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

ExactMotion::Real ExactMotion::stretch(Real q) const { return std::hypot(Real(1), q / p_); }

}  // namespace parabola

namespace particle_on_curve {

Exact exact(const parabola::Scene& scene, const parabola::ExactMotion& motion, double t) {
  const auto [q, qdot] = motion.at(t);
  const double p = scene.p;
  const Eigen::Vector2d v(qdot, -q * qdot / p);
  const double length = std::hypot(q, p);
  const Eigen::Vector2d inwards = -Eigen::Vector2d(q, p) / length;
  const double curvature = p * p / (length * length * length);
  const double N = scene.mass * v.squaredNorm() * curvature - scene.applied_force().dot(inwards);
  return {{q, scene.height(q)}, v, N * inwards};
}

}  // namespace particle_on_curve
