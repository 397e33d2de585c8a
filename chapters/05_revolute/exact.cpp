#include "exact.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/numeric/odeint.hpp>
#include <cmath>

namespace revolute {

Swing swing(const Scene& scene, double t) {
  using Real = boost::multiprecision::cpp_bin_float_50;
  const Real pi = boost::math::constants::pi<Real>();
  const Real turns = round((Real(scene.angle0) - pi / 2) / (2 * pi));
  const Real phi0 = Real(scene.angle0) - pi / 2 - 2 * pi * turns;
  const Real Omega0 = sqrt(3 * Real(scene.gravity) / (2 * Real(scene.length)));
  const Real k = sin(abs(phi0) / 2);
  const Real period = 4 * boost::math::ellint_1(k);  // of cd, in Ω0 t
  const Real u = fmod(Omega0 * Real(t), period);
  Real cn, dn;
  const Real sn = boost::math::jacobi_elliptic(k, u, &cn, &dn);
  const Real phi = 2 * asin(k * cn / dn), phidot = -2 * k * cos(phi0 / 2) * Omega0 * sn / dn;
  const Real sign = phi0 < 0 ? -1 : 1;
  return {static_cast<double>(sign * phi + pi / 2 + 2 * pi * turns),
          static_cast<double>(sign * phidot)};
}

Exact exact_pendulum(const Scene& scene, double t) {
  const auto [theta, omega] = swing(scene, t);
  const double L = scene.length, m = scene.mass, g = scene.gravity;
  const Vector2d e = direction(theta), across(-e.y(), e.x());
  const double alpha = 1.5 * g / L * std::cos(theta);
  const Vector2d a = L / 2 * (alpha * across - omega * omega * e);  // of the centre of mass
  return {L * e, L * omega * across, m * (a - Vector2d(0.0, g))};
}

ChainReference::Vector ChainReference::acceleration(const State& y) const {
  const int N = scene_.links;
  const Real l = scene_.l(), m = scene_.m(), g = scene_.gravity;
  Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic> M(N, N);
  Vector h(N);
  for (int i = 0; i < N; ++i) {
    h[i] = m * g * l * (N - i - 0.5L) * std::cos(theta(y, i));
    for (int j = 0; j < N; ++j) {
      const Real Mij = m * l * l * (i == j ? N - i - 2.0L / 3.0L : N - std::max(i, j) - 0.5L);
      const Real difference = theta(y, i) - theta(y, j);
      M(i, j) = Mij * std::cos(difference);
      h[i] -= Mij * std::sin(difference) * omega(y, j) * omega(y, j);
    }
  }
  return M.ldlt().solve(h);
}

std::optional<ChainReference::State> ChainReference::at(double t) const {
  const int N = scene_.links;
  State fine(std::size_t(2 * N), 0.0L);
  std::fill_n(fine.begin(), N, Real(scene_.angle0));
  State coarse = fine;
  long evaluations = 100000000L / (40 + N * N * N);
  Real now = 0, span = std::sqrt(Real(scene_.length) / scene_.gravity);
  for (Real end = 0; now < t; now = end, span *= 2) {
    end = std::min(now + span, Real(t));
    if (!integrate(fine, now, end, 1e-16L, evaluations) ||
        !integrate(coarse, now, end, 1e-14L, evaluations))
      return std::nullopt;
    for (int i = 0; i < N; ++i)
      if (!(std::abs(theta(fine, i) - theta(coarse, i)) < 1e-6L)) return std::nullopt;
  }
  return fine;
}

std::optional<Exact> ChainReference::exact(double t) const {
  using Point = Eigen::Vector<Real, 2>;
  const auto reached = at(t);
  if (!reached) return std::nullopt;
  const State& y = *reached;
  const Vector alpha = acceleration(y);
  const Real l = scene_.l(), m = scene_.m();
  Point r = Point::Zero(), v = Point::Zero(), a = Point::Zero(), force = Point::Zero();
  for (int i = 0; i < scene_.links; ++i) {  // from pin to pin
    const Point e(std::cos(theta(y, i)), std::sin(theta(y, i))), across(-e.y(), e.x());
    const Point a_rod = l * (alpha[i] * across - omega(y, i) * omega(y, i) * e);
    force += m * (a + a_rod / 2 - Point(0.0L, Real(scene_.gravity)));
    r += l * e;
    v += l * omega(y, i) * across;
    a += a_rod;
  }
  return Exact{r.cast<double>(), v.cast<double>(), force.cast<double>()};
}

bool ChainReference::integrate(State& y, Real now, Real end, Real tolerance,
                               long& evaluations) const {
  namespace odeint = boost::numeric::odeint;
  const int N = scene_.links;
  const auto rates = [&](const State& state, State& rate, Real) {
    --evaluations;
    const Vector alpha = acceleration(state);
    for (int i = 0; i < N; ++i) {
      rate[std::size_t(i)] = omega(state, i);
      rate[std::size_t(N + i)] = alpha[i];
    }
  };
  auto stepper = odeint::make_controlled<odeint::runge_kutta_fehlberg78<State, Real, State, Real>>(
      tolerance, tolerance);
  for (Real step = (end - now) / 1000; now < end;) {
    step = std::min(step, end - now);
    if (evaluations <= 0 || !(now + step > now)) return false;
    stepper.try_step(rates, y, now, step);
  }
  return true;
}

}  // namespace revolute
