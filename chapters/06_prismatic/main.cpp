// Chapter 6: the prismatic joint, which lets a body slide along a rail without turning on it. Here
// the rail is a body of its own that turns about a pin, and the block slides outwards on it.

#include <cstdio>

#include "exact.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "study.hpp"

using Eigen::VectorXd;

int main(int argc, char** argv) {
  if (argc > 1) return prismatic::study(argc, argv);

  // [loop]
  const double r0 = 0.3, spin = 5.0;                          // [m], [rad/s]
  const double inertia = 1.0 * (0.2 * 0.2 + 0.1 * 0.1) / 12;  // of the block [kg·m²]
  dynamics::System system;
  const auto rail = system.add_body("rail", 1.0, 1.0, {0, 0}, 0, {0, 0}, spin);
  const auto block = system.add_body("block", 1.0, inertia, {r0, 0}, 0, {0, spin * r0}, spin);
  system.add("rail_world", joints::Revolute{}, rail, dynamics::System::world);
  system.add("block_rail", joints::Prismatic{}, rail, block);

  VectorXd q = system.initial_q(), v = system.initial_v();
  integrators::Rk4<VectorXd> rk4(q);
  dynamics::Evaluation e(system);
  const auto equation = [&](double t, const VectorXd& x, const VectorXd& xdot, VectorXd& a) {
    system.evaluate(t, x, xdot, e);
    a = e.a();
  };
  const double h = 0.001;
  for (int step = 0; step < 1000; ++step) {
    rk4.step(equation, step * h, q, v, h);
    system.project((step + 1) * h, q, v, e);
  }
  system.evaluate(1000 * h, q, v, e);

  const double way = q.segment<2>(block.column).norm();
  const double exact = prismatic::exact({.spin = spin, .r0 = r0}, 1000 * h).x.norm();
  std::printf("after 1 s the block is at %.12f m on the rail\n", way);
  std::printf("the exact answer is       %.12f m\n", exact);
  std::printf("error %.1e m, largest |C| %.1e\n", way - exact, e.constraint_error());
  // [loop]
}
