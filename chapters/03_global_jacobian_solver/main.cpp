// Chapter 3: one solver for any set of constraints. Two beads on the parabola of chapter 1, joined
// by a rigid rod: three constraints that push against each other.

#include <cstdio>

#include "exact.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/on_curve.hpp"
#include "study.hpp"

using Eigen::Vector2d, Eigen::VectorXd;

int main(int argc, char** argv) {
  if (argc > 1) return dumbbell::study(argc, argv);

  // [loop]
  const double p = 50.0;  // [m]
  const Vector2d x1(20.0, -20.0 * 20.0 / (2 * p)), x2(60.0, -60.0 * 60.0 / (2 * p));
  dynamics::System system;
  const auto bead1 = system.add_particle("bead1", 1.0, x1);
  const auto bead2 = system.add_particle("bead2", 2.0, x2);
  system.add("bead1_curve", joints::OnCurve<joints::Parabola>{{p}}, bead1);
  system.add("bead2_curve", joints::OnCurve<joints::Parabola>{{p}}, bead2);
  system.add("bead1_bead2", joints::Distance{.length = (x2 - x1).norm()}, bead1, bead2);
  system.set_gravity({0, 9.81});

  VectorXd q = system.initial_q(), v = system.initial_v();
  integrators::Rk4<VectorXd> rk4(q);
  dynamics::Evaluation e(system);
  const auto equation = [&](double t, const VectorXd& x, const VectorXd& xdot, VectorXd& a) {
    system.evaluate(t, x, xdot, e);
    a = e.a();
  };
  const double h = 0.01;
  for (int step = 0; step < 2000; ++step) {
    rk4.step(equation, step * h, q, v, h);
    system.project((step + 1) * h, q, v, e);
  }
  system.evaluate(2000 * h, q, v, e);

  const dumbbell::Exact exact = dumbbell::ExactMotion({}).at(2000 * h);
  std::printf("after 20 s bead1 is at (%.9f, %.9f) m\n", q[0], q[1]);
  std::printf("the exact answer is    (%.9f, %.9f) m\n", exact.x1.x(), exact.x1.y());
  std::printf("error %.1e m, largest |C| %.1e m²\n", (q.head<2>() - exact.x1).norm(),
              e.constraint_error());
  // [loop]
}
