// Chapter 2: the same particle, described by the one coordinate that it really has. With q the way
// along x the curve is built in: no constraint, no constraint force, no drift off the curve.

#include <cstdio>

#include "01_particle_on_curve_implicit/exact.hpp"
#include "study.hpp"

// [loop]
constexpr double g = 9.81, p = 50.0;  // [m/s²], [m]

/// q̈ by Lagrange's equation; the mass cancels.
double acceleration(double q, double qdot) {
  return (-q * qdot * qdot - p * g * q) / (p * p + q * q);
}

int main(int argc, char** argv) {
  if (argc > 1) return parametric_lagrangian::study(argc, argv);

  const double h = 0.01;
  double q = 100.0, v = 0.0;
  for (int step = 0; step < 2000; ++step) {  // by the classical Runge–Kutta method
    const double a1 = acceleration(q, v);
    const double v2 = v + h / 2 * a1, a2 = acceleration(q + h / 2 * v, v2);
    const double v3 = v + h / 2 * a2, a3 = acceleration(q + h / 2 * v2, v3);
    const double v4 = v + h * a3, a4 = acceleration(q + h * v3, v4);
    q += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }

  const double exact = parabola::ExactMotion({}).at(2000 * h).q;
  std::printf("after 20 s q = %.12f m\n", q);
  std::printf("exactly    q = %.12f m\n", exact);
  std::printf("error %.1e m\n", q - exact);
}
// [loop]
