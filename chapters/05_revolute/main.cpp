// Chapter 5: the revolute joint, which pins a point of one body to a point of another. One rod
// pinned to the world is the compound pendulum.

#include <cstdio>

#include "exact.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/joints/revolute.hpp"
#include "study.hpp"

using Eigen::VectorXd;

int main(int argc, char** argv) {
  if (argc > 1) return revolute::study(argc, argv);

  // [loop]
  const double L = 1.0, m = 1.0;  // [m], [kg]
  dynamics::System system;
  const auto rod = system.add_body("rod", m, m * L * L / 12, {L / 2, 0});
  system.add("rod_world", joints::Revolute{.u1 = {-L / 2, 0}}, rod, dynamics::System::world);
  system.set_gravity({0, 9.81});

  VectorXd q = system.initial_q(), v = system.initial_v();
  integrators::Rk4<VectorXd> rk4(q);
  dynamics::Evaluation e(system);
  const auto equation = [&](double t, const VectorXd& x, const VectorXd& xdot, VectorXd& a) {
    system.evaluate(t, x, xdot, e);
    a = e.a();
  };
  const double h = 0.005;
  for (int step = 0; step < 1000; ++step) {
    rk4.step(equation, step * h, q, v, h);
    system.project((step + 1) * h, q, v, e);
  }
  system.evaluate(1000 * h, q, v, e);

  const double angle = q[rod.column + 2], exact = revolute::swing({}, 1000 * h).theta;
  std::printf("after 5 s the rod stands at %.12f rad\n", angle);
  std::printf("the exact answer is         %.12f rad\n", exact);
  std::printf("error %.1e rad, largest |C| %.1e m\n", angle - exact, e.constraint_error());
  // [loop]
}
