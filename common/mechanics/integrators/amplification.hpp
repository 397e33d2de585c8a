#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>

#include "mechanics/integrators/integrator.hpp"

namespace integrators {

/// The factor by which one step of length h [s] multiplies the worst solution of the test equation
///
///     C̈ + kd Ċ + ks C = 0        (ks [1/s²], kd [1/s])
///
/// which every constraint error obeys under feedback. Above 1 the error grows from step to step.
/// One step is linear in (C, Ċ): its 2×2 matrix is found by stepping the two unit states, and the
/// factor is the larger modulus of its eigenvalues (the spectral radius).
// [amplification]
inline std::array<double, 4> step_matrix(Scheme scheme, double h, double ks, double kd) {
  Integrator<double> integrator(scheme, 0.0);
  const auto test_equation = [&](double, double C, double Cdot, double& Cddot) {
    Cddot = -ks * C - kd * Cdot;
  };
  double a11 = 1.0, a21 = 0.0, a12 = 0.0, a22 = 1.0;
  integrator.step(test_equation, 0.0, a11, a21, h);
  integrator.step(test_equation, 0.0, a12, a22, h);
  return {a11, a12, a21, a22};
}

inline double amplification(Scheme scheme, double h, double ks, double kd) {
  const auto [a11, a12, a21, a22] = step_matrix(scheme, h, ks, kd);
  const double half_trace = 0.5 * (a11 + a22);
  const std::complex<double> root =
      std::sqrt(std::complex<double>(half_trace * half_trace - (a11 * a22 - a12 * a21)));
  return std::max(std::abs(half_trace + root), std::abs(half_trace - root));
}
// [amplification]

/// How many times higher an error may swing than it started before it decays: the largest |A^n| of
/// that step's matrix A, in (√ks C, Ċ), over all n; infinite where the step is not stable. Close to
/// the limit it is large though every eigenvalue is below 1. Powers of two come within a factor
/// √2 of the largest.
inline double largest_swing(Scheme scheme, double h, double ks, double kd) {
  if (amplification(scheme, h, ks, kd) > 1.0 + 1e-12)
    return std::numeric_limits<double>::infinity();
  const double rate = ks > 0.0 ? std::sqrt(ks) : 1.0;
  std::array<double, 4> A = step_matrix(scheme, h, ks, kd);  // by rows
  A[1] *= rate, A[2] /= rate;
  double largest = 1.0;
  for (int i = 0; i < 64; ++i) {
    const auto [a, b, c, d] = A;
    largest = std::max(largest, std::sqrt(a * a + b * b + c * c + d * d));
    A = {a * a + b * c, a * b + b * d, c * a + d * c, c * b + d * d};
  }
  return largest;
}

/// The largest step h [s] at which feedback with these gains does not grow, found by bisection.
inline double largest_stable_step(Scheme scheme, double ks, double kd) {
  const double rate = std::max(std::sqrt(ks), kd);
  double stable = 0.0, unstable = 16.0 / rate;  // beyond every method's limit
  for (int i = 0; i < 60; ++i) {
    const double h = 0.5 * (stable + unstable);
    (amplification(scheme, h, ks, kd) <= 1.0 + 1e-12 ? stable : unstable) = h;
  }
  return stable;
}

}  // namespace integrators
