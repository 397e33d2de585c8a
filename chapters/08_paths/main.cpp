// Chapter 8: a bead on any wire. Chapter 2's equation of motion knew its parabola; this one asks
// the wire for x(q) and its first two derivatives, and so the wire is one line.

#include <cstdio>

#include "exact.hpp"
#include "mechanics/paths/path.hpp"
#include "study.hpp"

// [loop]
constexpr double g = 9.81, R = 1.0;          // [m/s²], [m]
const paths::Path wire = paths::cycloid(R);  // or any other

/// q̈ by Newton's law along x′, to which the force of the wire is perpendicular; the mass cancels.
double qddot(double q, double qdot) {
  const auto [x, d, dd] = wire(q);  // x, x′, x″
  return (d.y() * g - d.dot(dd) * qdot * qdot) / d.squaredNorm();
}

int main(int argc, char** argv) {
  if (argc > 1) return any_wire::study(argc, argv);

  const double h = 0.002;
  double q = 3.0, v = 0.0;
  for (int step = 0; step < 2500; ++step) {  // by the classical Runge–Kutta method
    const double a1 = qddot(q, v);
    const double v2 = v + h / 2 * a1, a2 = qddot(q + h / 2 * v, v2);
    const double v3 = v + h / 2 * a2, a3 = qddot(q + h / 2 * v2, v3);
    const double v4 = v + h * a3, a4 = qddot(q + h * v3, v4);
    q += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }

  const double exact = any_wire::on_cycloid(R, g, {3.0, 0.0}, 2500 * h)->q;
  std::printf("after 5 s q = %.12f\n", q);
  std::printf("exactly   q = %.12f\n", exact);
  std::printf("error %.1e\n", q - exact);
}
// [loop]
