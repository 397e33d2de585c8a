// Chapter 1: a particle on a curve, held there by the force of its constraint.

#include <cmath>
#include <cstdio>
#include <valarray>

#include "exact.hpp"
#include "study.hpp"

// [loop]
using State = std::valarray<double>;           // x, y [m], vx, vy [m/s]
constexpr double m = 1.0, g = 9.81, p = 50.0;  // [kg], [m/s²], [m]

/// How the bead moves on C = x² + 2py = 0: its velocity, and the acceleration by its weight and by
/// the force λ∇C of the wire, ∇C = (2x, 2p).
State rate(const State& now) {
  const double x = now[0], vx = now[2], vy = now[3];
  const double lambda = -(2 * m * vx * vx + 2 * p * m * g) / (4 * x * x + 4 * p * p);
  return {vx, vy, lambda * 2 * x / m, g + lambda * 2 * p / m};
}

int main(int argc, char** argv) {
  if (argc > 1) return particle_on_curve::study(argc, argv);

  const double h = 0.01;
  State bead{100.0, -100.0, 0.0, 0.0};
  for (int step = 0; step < 2000; ++step) {  // by the classical Runge–Kutta method
    const State k1 = rate(bead), k2 = rate(bead + h / 2 * k1), k3 = rate(bead + h / 2 * k2),
                k4 = rate(bead + h * k3);
    bead += h / 6 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }

  const auto [x, v, force] = particle_on_curve::exact({}, parabola::ExactMotion({}), 2000 * h);
  std::printf("after 20 s the bead is at (%.9f, %.9f) m\n", bead[0], bead[1]);
  std::printf("the exact answer is       (%.9f, %.9f) m\n", x.x(), x.y());
  std::printf("error %.1e m, off the curve by C = %.1e m²\n",
              std::hypot(bead[0] - x.x(), bead[1] - x.y()), bead[0] * bead[0] + 2 * p * bead[1]);
}
// [loop]
