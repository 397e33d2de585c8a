// Chapter 4: ground. A plate that starts off its place is brought back by the feedback of its
// ground joint, while a load pulls at its right edge.

#include <cmath>
#include <cstdio>

#include "exact.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/joints/ground.hpp"
#include "study.hpp"

using Eigen::Vector2d, Eigen::Vector3d, Eigen::VectorXd;

int main(int argc, char** argv) {
  if (argc > 1) return ground::study(argc, argv);

  // [loop]
  const double width = 0.6, height = 0.4, mass = 2.0;  // [m], [kg]
  dynamics::System system;
  const auto plate = system.add_body("plate", mass, mass * (width * width + height * height) / 12,
                                     {0.05, -0.03}, 0.2);
  system.add("plate_ground", joints::Ground{}, plate);
  system.set_gravity({0, 9.81});
  system.apply(plate, [=](double t, const dynamics::Body& body) {
    const Vector2d arm = body.A * Vector2d(width / 2, 0), F(0, 5 * std::sin(2 * t));
    return Vector3d(F.x(), F.y(), arm.x() * F.y() - arm.y() * F.x());
  });
  system.set_feedback(25, 10);  // C̈ + 10 Ċ + 25 C = 0

  VectorXd q = system.initial_q(), v = system.initial_v();
  integrators::Rk4<VectorXd> rk4(q);
  dynamics::Evaluation e(system);
  const auto equation = [&](double t, const VectorXd& x, const VectorXd& xdot, VectorXd& a) {
    system.evaluate(t, x, xdot, e);
    a = e.a();
  };
  const double h = 0.01;
  for (int step = 0; step < 100; ++step) rk4.step(equation, step * h, q, v, h);

  const ground::Scene off{.offset_x = 0.05, .offset_y = -0.03, .offset_theta = 0.2};
  const Vector3d exact = ground::exact(off, ground::decay(25, 10, 100 * h), 100 * h).q;
  std::printf("after 1 s the plate is at (%.9f, %.9f) m, turned by %.9f rad\n", q[0], q[1], q[2]);
  std::printf("the exact answer is       (%.9f, %.9f) m,           %.9f rad\n", exact.x(),
              exact.y(), exact.z());
  std::printf("error %.1e\n", (q - exact).norm());
  // [loop]
}
