// The exact motion of both scenes: each is a pendulum, by Jacobi's elliptic functions.
#pragma once

#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include "mechanics/motion/motion.hpp"
#include "scenes.hpp"

namespace iftomm {

/// Where the end of a pendulum of length 1 m is, y downwards, and how fast [m], [m/s].
struct End {
  Vector2d x, v;
};

/// ψ̈ = −w² sin ψ, ψ from hanging straight down, released at rest from ψ = −π/2 (the left): then
/// sin(ψ/2) = −k cd(w t, k), k = sin(π/4). In 50 digits, so that t may be long.
inline End swing_from_horizontal(double w_squared, double t) {
  using Real = boost::multiprecision::cpp_bin_float_50;
  const Real w = sqrt(Real(w_squared)), k = sqrt(Real(0.5));
  Real cn, dn;
  const Real u = fmod(w * Real(t), 4 * boost::math::ellint_1(k));
  const Real sn = boost::math::jacobi_elliptic(k, u, &cn, &dn);
  const Real s = -k * cn / dn, c = sqrt(1 - s * s);                // sin and cos of ψ/2
  const Real rate = 2 * k * (1 - k * k) * w * sn / (dn * dn) / c;  // of ψ; d cd/du = −(1−k²) sn/dn²
  const Real sine = 2 * s * c, cosine = c * c - s * s;
  return {{static_cast<double>(sine), static_cast<double>(cosine)},
          {static_cast<double>(cosine * rate), static_cast<double>(-sine * rate)}};
}

/// ψ̈ = −w² sin ψ from ψ = π, upright, with ψ̇ = −rate [rad/s]: over the top again and again. At the
/// bottom the rate is Ω, Ω² = rate² + 4w², and ψ = 2π − 2 am(K + Ω t/2, k), k = 2w/Ω.
inline End turn_from_upright(double w_squared, double rate, double t) {
  using Real = boost::multiprecision::cpp_bin_float_50;
  const Real Omega = sqrt(Real(rate) * rate + 4 * Real(w_squared));
  const Real k = 2 * sqrt(Real(w_squared)) / Omega, K = boost::math::ellint_1(k);
  Real cn, unused;  // Boost's dn loses all digits at K
  const Real u = fmod(K + Omega * Real(t) / 2, 4 * K);
  const Real sn = boost::math::jacobi_elliptic(k, u, &cn, &unused);
  const Real dn = sqrt(Real(rate) * rate / (Omega * Omega) + k * k * cn * cn);
  const Real sine = -2 * sn * cn, cosine = cn * cn - sn * sn;  // of ψ
  const Real psidot = -Omega * dn;
  return {{static_cast<double>(sine), static_cast<double>(cosine)},
          {static_cast<double>(cosine * psidot), static_cast<double>(-sine * psidot)}};
}

inline End exact(const Pendulum& scene, double t) {
  const End end = swing_from_horizontal(scene.gravity / scene.length, t);
  return {scene.length * end.x, scene.length * end.v};
}

/// All uprights share one angle φ, so that N + 1 links of moment of inertia 1/3 kg·m² about their
/// pivots and N tops of 1 kg at their ends move as one: c φ̈ = −d g cos φ.
inline End exact(const FourBars& scene, double t) {
  const double N = scene.loops, c = (N + 1) / 3 + N, d = (N + 1) / 2 + N;
  return turn_from_upright(d * scene.gravity / c, scene.speed / FourBars::length, t);
}

/// Distances of the pendulum's mass, or of the first upright's end, from the exact one [m], [m/s].
inline std::vector<double> errors(const Pendulum& scene, const mechanics::Row& row) {
  const End truth = exact(scene, row.t);
  return {(Vector2d(row.state[0], row.state[1]) - truth.x).norm(),
          (Vector2d(row.state[2], row.state[3]) - truth.v).norm()};
}
inline std::vector<double> errors(const FourBars& scene, const mechanics::Row& row) {
  const End truth = exact(scene, row.t);
  const Vector2d half =
      FourBars::length / 2 * Vector2d(std::cos(row.state[2]), std::sin(row.state[2]));
  const Vector2d end = Vector2d(row.state[0], row.state[1]) + half;
  const Vector2d rate =
      Vector2d(row.state[3], row.state[4]) + row.state[5] * Vector2d(-half.y(), half.x());
  return {(end - truth.x).norm(), (rate - truth.v).norm()};
}

}  // namespace iftomm
