// Chapter 9: a driver. The machine of chapter 7, whose wheel is told how to turn; what the motor
// needs for it is the unknown.

#include <cmath>
#include <cstdio>
#include <numbers>

#include "exact.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/joints/driver.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "study.hpp"

using Eigen::Vector2d, Eigen::VectorXd;

int main(int argc, char** argv) {
  if (argc > 1) return drivers::study(argc, argv);

  // [loop]
  const double R = 0.3, L = 1.0;  // crank and rod [m]
  const double theta = std::numbers::pi / 4, phi = -std::asin(R * std::sin(theta) / L);
  const Vector2d pin = R * Vector2d(std::cos(theta), std::sin(theta));
  const Vector2d rod_half = L / 2 * Vector2d(std::cos(phi), std::sin(phi));
  // 4 rad in 2 s: the angle, its rate and its acceleration.
  const auto f = [=](double t) {
    const double s = t / 2;
    return joints::Given{theta + 4 * s * s * s * (10 - 15 * s + 6 * s * s),
                         60 * s * s * (1 - s) * (1 - s), 60 * s * (1 - s) * (1 - 2 * s)};
  };

  dynamics::System system;
  const auto world = dynamics::System::world;
  const auto wheel = system.add_body("wheel", 2.0, 0.16, {0, 0}, theta);
  const auto rod = system.add_body("rod", 1.0, L * L / 12, pin + rod_half, phi);
  const auto slider = system.add_body("slider", 1.5, 0.01625, pin + 2 * rod_half);
  system.add("wheel_frame", joints::Revolute{}, wheel, world);
  system.add("rod_wheel", joints::Revolute{.u1 = {-L / 2, 0}, .u2 = {R, 0}}, rod, wheel);
  system.add("slider_rod", joints::Revolute{.u2 = {L / 2, 0}}, slider, rod);
  system.add("slider_frame", joints::Prismatic{}, world, slider);
  const auto motor = system.add("wheel_driver", joints::Driver{f}, wheel, world);
  system.set_gravity({0, 9.81});

  VectorXd q = system.initial_q(), v = system.initial_v();
  integrators::Rk4<VectorXd> rk4(q);
  dynamics::Evaluation e(system);
  const auto equation = [&](double t, const VectorXd& x, const VectorXd& xdot, VectorXd& a) {
    system.evaluate(t, x, xdot, e);
    a = e.a();
  };
  const double h = 0.001;
  for (int step = 0; step < 500; ++step) rk4.step(equation, step * h, q, v, h);
  system.evaluate(500 * h, q, v, e);

  const joints::Given told = f(500 * h);
  const double lambda = e.lambda(motor)[0],
               exact = static_cast<double>(drivers::torque({}, {told.f, told.f_dot, told.f_ddot}));
  std::printf("after 0.5 s the motor turns the wheel with %.12f N m\n", lambda);
  std::printf("the exact answer is                        %.12f N m\n", exact);
  std::printf("error %.1e N m, of the angle %.1e rad\n", lambda - exact,
              q[wheel.column + 2] - told.f);
  // [loop]
}
