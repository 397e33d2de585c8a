// Chapter 7: the slider-crank. A wheel turns in the world, a rod joins its crank pin to a slider on
// a rail, and a torque drives the wheel.

#include <cmath>
#include <cstdio>
#include <numbers>

#include "exact.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "study.hpp"

using Eigen::Vector2d, Eigen::VectorXd;

int main(int argc, char** argv) {
  if (argc > 1) return slider_crank::study(argc, argv);

  // [loop]
  const double R = 0.3, L = 1.0;  // crank and rod [m]
  const double theta = std::numbers::pi / 4, phi = -std::asin(R * std::sin(theta) / L);
  const Vector2d pin = R * Vector2d(std::cos(theta), std::sin(theta));
  const Vector2d rod_half = L / 2 * Vector2d(std::cos(phi), std::sin(phi));

  dynamics::System system;
  const auto world = dynamics::System::world;
  const auto wheel = system.add_body("wheel", 2.0, 0.16, {0, 0}, theta);
  const auto rod = system.add_body("rod", 1.0, L * L / 12, pin + rod_half, phi);
  const auto slider = system.add_body("slider", 1.5, 0.01625, pin + 2 * rod_half);
  system.add("wheel_frame", joints::Revolute{}, wheel, world);
  system.add("rod_wheel", joints::Revolute{.u1 = {-L / 2, 0}, .u2 = {R, 0}}, rod, wheel);
  system.add("slider_rod", joints::Revolute{.u2 = {L / 2, 0}}, slider, rod);
  system.add("slider_frame", joints::Prismatic{}, world, slider);
  system.set_gravity({0, 9.81});
  system.apply(wheel, {0, 0, 2.0});

  VectorXd q = system.initial_q(), v = system.initial_v();
  integrators::Rk4<VectorXd> rk4(q);
  dynamics::Evaluation e(system);
  const auto equation = [&](double t, const VectorXd& x, const VectorXd& xdot, VectorXd& a) {
    system.evaluate(t, x, xdot, e);
    a = e.a();
  };
  const double h = 0.001;
  for (int step = 0; step < 2000; ++step) {
    rk4.step(equation, step * h, q, v, h);
    system.project((step + 1) * h, q, v, e);
  }
  system.evaluate(2000 * h, q, v, e);

  const double angle = q[wheel.column + 2];
  const auto exact = static_cast<double>(slider_crank::Exact({}).at(2.0)->theta);
  std::printf("after 2 s the wheel stands at %.12f rad\n", angle);
  std::printf("the exact answer is           %.12f rad\n", exact);
  std::printf("error %.1e rad, largest |C| %.1e\n", angle - exact, e.constraint_error());
  // [loop]
}
