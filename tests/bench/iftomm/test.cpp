#include "catch.hpp"
#include "exact.hpp"
#include "orders.hpp"

using iftomm::End;
using iftomm::FourBars;
using iftomm::Pendulum;
using iftomm::Vector2d;
using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<mechanics::Mechanism>;

TEST_CASE("the exact motions fulfil their equations of motion and keep their energy") {
  const auto check = [](const auto& at, double w_squared) {
    const End start = at(0.0);
    for (const double t : {0.1, 0.7, 1.9, 5.3, 10.0, 333.3}) {
      INFO("t = " << t);
      const End now = at(t);
      CHECK(now.x.norm() == Approx(1.0).epsilon(1e-14));
      CHECK(now.v.squaredNorm() / 2 - w_squared * now.x.y() ==
            Approx(start.v.squaredNorm() / 2 - w_squared * start.x.y()).margin(1e-12));
      const double h = 1e-4;
      const End before = at(t - h), after = at(t + h);
      CHECK((after.x - before.x - 2 * h * now.v).norm() < 1e-9 * 2 * h * 1e3);
      // across the rod only gravity accelerates: ψ̈ = −w² sin ψ
      const Vector2d across(now.x.y(), -now.x.x());
      const double psiddot = (after.v - before.v).dot(across) / (2 * h);
      CHECK(psiddot == Approx(-w_squared * now.x.x()).margin(1e-4));
    }
  };
  check([](double t) { return iftomm::swing_from_horizontal(9.81, t); }, 9.81);
  check([](double t) { return iftomm::turn_from_upright(11.4, 1.0, t); }, 11.4);
  const End released = iftomm::exact(Pendulum{}, 0.0), upright = iftomm::exact(FourBars{}, 0.0);
  CHECK((released.x - Eigen::Vector2d(-1, 0)).norm() < 1e-15);
  CHECK(released.v.norm() < 1e-15);
  CHECK((upright.x - Eigen::Vector2d(0, -1)).norm() < 1e-15);
  CHECK((upright.v - Eigen::Vector2d(1, 0)).norm() < 1e-14);
}

TEST_CASE("A02: the first top after 10 s is where an independent computation puts it") {
  const End end = iftomm::exact(FourBars{}, 10.0);
  CHECK(end.x.x() == Approx(0.3284581115408154).epsilon(1e-13));
  CHECK(-end.x.y() == Approx(0.944518538178601).epsilon(1e-13));
}

TEST_CASE("A01: the pendulum converges with the order of the integrator") {
  using enum integrators::Scheme;
  const Pendulum scene;
  const measure::Start start = [&](const Method& method) {
    return std::make_unique<Motion>(iftomm::make_mechanism(scene, method), method);
  };
  const measure::Errors errors = [&](const mechanics::Row& row) {
    return iftomm::errors(scene, row);
  };
  CHECK(check_orders({.methods = {{explicit_euler},
                                  {semi_implicit_euler},
                                  {implicit_midpoint},
                                  {rk4},
                                  {rk4, Stabilization::projection}},
                      .duration = 0.5,
                      .coarsest = 1.0 / 128,
                      .rungs = 8},
                     start, errors, [](const measure::Rung& rung, std::size_t) {
                       return rung.errors[0] > 1e-11 && rung.step < 1.0 / 1000;
                     }) > 20);
}

TEST_CASE("A02, N = 2: 1e-8 m after 10 s, through every pose where J loses rank") {
  const FourBars scene;
  const Method adaptive{integrators::Scheme::dop853, Stabilization::projection, 0, 0, 1e-9};
  Motion motion(iftomm::make_mechanism(scene, adaptive), adaptive);
  motion.advance(10, 1.0);
  CHECK(iftomm::errors(scene, motion.row())[0] < 1e-8);
  const Method fixed{integrators::Scheme::rk4, Stabilization::projection};
  Motion rk4(iftomm::make_mechanism(scene, fixed), fixed);
  rk4.advance(5000, 2e-3);
  CHECK(iftomm::errors(scene, rk4.row())[0] < 1e-8);
}

TEST_CASE("A02, N = 40: 20 s with the energy kept to 1e-8") {
  const FourBars scene{.loops = 40};
  const Method method{integrators::Scheme::dop853, Stabilization::projection};
  Motion motion(iftomm::make_mechanism(scene, method), method);
  const double start = motion.measures().energy;
  for (int i = 0; i < 400; ++i) {
    motion.advance(1, 0.05);
    REQUIRE(std::abs(motion.measures().energy - start) < 1e-8 * start);
    REQUIRE(motion.measures().constraint_error < 1e-12);
  }
  CHECK(iftomm::errors(scene, motion.row())[0] < 1e-6);
}

TEST_CASE("A02, N = 40: shorter steps, which come closer to the poses, are better steps") {
  const FourBars scene{.loops = 40};
  const auto error = [&](const Method& method, double step) {
    Motion motion(iftomm::make_mechanism(scene, method), method);
    const double start = motion.measures().energy, kinetic = motion.measures().kinetic;
    double largest = 0.0;
    for (int i = 0; i < 14; ++i) {
      motion.advance(std::lround(0.1 / step), step);
      largest = std::max(largest, std::abs(motion.measures().energy - start));
    }
    return std::pair(largest / kinetic, iftomm::errors(scene, motion.row())[0]);
  };
  const Stabilization projection = Stabilization::projection;
  CHECK(error({integrators::Scheme::dop853, projection}, 1e-3).first < 1e-10);
  CHECK(error({integrators::Scheme::rk4, projection}, 4e-3).first >
        12.0 * error({integrators::Scheme::rk4, projection}, 2e-3).first);
  for (const double tolerance : {1e-6, 1e-8, 1e-10})
    CHECK(error({integrators::Scheme::dop853, projection, 0, 0, tolerance}, 0.1).second <
          100.0 * tolerance);
}

TEST_CASE(
    "A02: J loses rank where all links lie in one line, and the motion is that of one angle") {
  const FourBars scene;
  mechanics::Mechanism mechanism = iftomm::make_mechanism(scene);
  Eigen::VectorXd q = mechanism.initial_position(), v = mechanism.initial_velocity(), a(15);
  mechanism.acceleration(0, q, v, a);
  const auto counts = mechanism.evaluation().counts();
  CHECK(counts.coordinates == 15);
  CHECK(counts.rows == 14);
  CHECK(counts.degrees_of_freedom == 1);
  CHECK(counts.rank == 14);
  // Laid down to the right: uprights at θ = 0, their ends and the tops on y = 0.
  v.setZero();
  for (int i = 0; i < 3; ++i) q.segment<3>(3 * i) << i + 0.5, 0, 0;
  for (int i = 0; i < 2; ++i) q.segment<3>(9 + 3 * i) << i + 1.5, 0, 0;
  mechanism.acceleration(0, q, v, a);
  CHECK(mechanism.evaluation().counts().rank < 14);
  CHECK(!mechanism.evaluation().dependent_rows().empty());
}
