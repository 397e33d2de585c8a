#include <cmath>
#include <numbers>

#include "catch.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/measure/stability_map.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "mechanics/joints/ground.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"
#include "mechanics/motion/watch.hpp"

namespace {

using integrators::Scheme;
using mechanics::Mechanism;
using mechanics::Method;
using mechanics::Stabilization;
using mechanics::Watch;
using Motion = mechanics::Motion<Mechanism>;
using Eigen::Vector2d;

/// Lengths, masses and times as parts of a metre, a kilogram and a second.
struct Units {
  double L = 1.0, M = 1.0, T = 1.0;
};

/// A uniform rod of 1 m and 1 kg, horizontal, pinned at its left end: chapter 5's pendulum.
Mechanism pendulum(const Method& method, const Units& u = {}) {
  Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  const auto rod = system.add_body("rod", u.M, u.M * u.L * u.L / 12.0, {0.5 * u.L, 0.0});
  system.add("rod_world", joints::Revolute{{-0.5 * u.L, 0.0}, {0.0, 0.0}}, rod, system.world);
  system.set_gravity({0.0, 9.81 * u.L / (u.T * u.T)});
  mechanism.assemble();
  return mechanism;
}

/// A body of 2 kg that a ground joint should hold at the origin; it starts off along x.
Mechanism plate(const Method& method, double offset, double gravity = 9.81) {
  Mechanism mechanism(method);
  const auto body = mechanism.system.add_body("plate", 2.0, 0.0867, {offset, 0.0});
  mechanism.system.add("plate_ground", joints::Ground{}, body);
  mechanism.system.set_gravity({0.0, gravity});
  mechanism.start_as_given();
  return mechanism;
}

/// Runs to the end, looking at each step.
mechanics::Verdict run(Motion& motion, long steps, double h, double* largest = nullptr) {
  Watch watch(motion);
  const auto keep = [&](const mechanics::Measures& now) {
    if (largest != nullptr) *largest = std::max(*largest, now.constraint_error);
  };
  measure::run(motion, {steps, h}, keep, watch);
  return watch.verdict();
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

double opening(const dynamics::System& system, const Eigen::VectorXd& q) {
  dynamics::Evaluation e(system);
  system.evaluate(0.0, q, system.initial_v(), e);
  return e.opening();
}

}  // namespace

TEST_CASE("reach: the largest distance between points, however they lie") {
  for (int k = 0; k < 40; ++k) {
    const double angle = 0.1 * k, c = std::cos(angle), s = std::sin(angle);
    mechanics::Reach reach;
    for (const auto& [x, y] : {std::pair{1.0, 2.0}, {4.0, 2.0}, {1.0, 6.0}, {4.0, 6.0}})
      reach.cover(1e3 + c * x - s * y, s * x + c * y);
    CHECK(reach.size() <= 5.0 * (1.0 + 1e-12));
    CHECK(reach.size() >= 4.975);
  }
  mechanics::Reach discs;
  discs.cover(0.0, 0.0, 1.0);
  discs.cover(3.0, 0.0, 0.5);
  CHECK(discs.size() == Approx(4.5));
  CHECK(discs.largest_radius() == 1.0);
}

TEST_CASE("growth: the largest value, and since when it was above a level") {
  mechanics::Growth growth;
  for (int i = 0; i <= 1000; ++i) growth.take(0.01 * i, 1e-6 * i * i);  // t²/100
  CHECK(growth.most() == Approx(1.0));
  for (const double level : {1e-4, 0.01, 0.5, 0.99})
    CHECK(growth.since(level) == Approx(10.0 * std::sqrt(level)).epsilon(0.12));
}

TEST_CASE("opening: the way that brings a point back, whatever the joint and the body") {
  // A pinned rod pushed off by 0.01 m gapes by that, along it (it moves as a whole) and across it
  // (it moves by a quarter and turns for the rest).
  Mechanism one = pendulum({});
  for (const int axis : {0, 1}) {
    Eigen::VectorXd q = one.initial_position();
    q[axis] += 0.01;
    CHECK(opening(one.system, q) == Approx(0.01).epsilon(1e-12));
  }
  // Between two bodies the gap is shared, whatever their masses.
  for (const double mass : {1e-6, 1.0, 1e6}) {
    dynamics::System system;
    const auto a = system.add_body("a", 1.0, 1.0 / 12.0, {0.5, 0.0});
    const auto b = system.add_body("b", mass, mass / 12.0, {1.5, 0.0});
    system.add("b_a", joints::Revolute{{-0.5, 0.0}, {0.5, 0.0}}, b, a);
    for (const int axis : {3, 4}) {
      Eigen::VectorXd q = system.initial_q();
      q[axis] += 0.02;
      CHECK(opening(system, q) == Approx(0.02).epsilon(1e-12));
    }
  }
  // An angle counts times the radius: of a rod of 1 m, half a metre.
  dynamics::System held;
  held.add("rod_ground", joints::Ground{}, held.add_body("rod", 3.0, 0.25, {0.0, 0.0}));
  CHECK(opening(held, Eigen::Vector3d(0.0, 0.0, 0.1)) == Approx(0.05).epsilon(1e-12));
}

TEST_CASE("a torn pendulum says so, the same in all units, and a right one says nothing") {
  for (const Units& u : {Units{}, Units{1e6, 1e3, 1e2}, Units{1e-6, 1e-9, 1e-3}}) {
    CAPTURE(u.L);
    Motion coarse(pendulum({}, u), {});
    const mechanics::Verdict torn = run(coarse, 10, 0.5 * u.T);
    REQUIRE(torn.faults.size() == 2);
    CHECK(torn.words() == "joints and energy");
    static const std::string in_metres = torn.faults[0].words;
    const auto part = [](const std::string& words) {
      return words.substr(words.find(','), words.find('(') - words.find(','));
    };
    CHECK(part(torn.faults[0].words) == part(in_metres));
    Motion fine(pendulum({}, u), {});
    CHECK(run(fine, 1000, 0.005 * u.T).right());
  }
}

TEST_CASE("a verdict says since when, and by how much") {
  // A pendulum under explicit Euler gains energy from the first step on.
  const Method method{Scheme::explicit_euler, Stabilization::projection};
  Motion motion(pendulum(method), method);
  double since = 0.0, kinetic = 0.0;
  std::vector<std::pair<double, double>> errors;
  Watch watch(motion);
  const double start = motion.measures().balance();
  measure::run(motion, {400, 0.005}, watch, [&](const mechanics::Measures& now) {
    kinetic = std::max(kinetic, now.kinetic);
    errors.emplace_back(motion.time(), std::abs(now.balance() - start));
  });
  for (const auto& [t, error] : errors)
    if (since == 0.0 && error > 0.01 * kinetic) since = t;
  const mechanics::Verdict verdict = watch.verdict();
  REQUIRE(verdict.words() == "energy");
  const std::string text = verdict.text(), mark = "since t = ";
  REQUIRE(holds(text, mark));
  CHECK(std::stod(text.substr(text.find(mark) + mark.size())) == Approx(since).epsilon(0.15));
}

TEST_CASE("an error against the exact answer counts in parts of the scene's size") {
  Motion motion(pendulum({}), {});
  Watch watch(motion);
  measure::run(motion, {200, 0.005}, watch);
  // In a second it swings down, past the vertical: it covers 2 m across and 1 m down.
  const std::vector<measure::Quantity> metres{{"position", "m"}, {"velocity", "m/s"}};
  CHECK(measure::judge(watch, metres, {0.019, 1e6}).right());
  CHECK_FALSE(measure::judge(watch, metres, {0.025, 0.0}).right());
  const std::vector<measure::Quantity> radians{{"angle", "rad"}};  // of a rod of half a metre
  CHECK(measure::judge(watch, radians, {0.039}).right());
  CHECK_FALSE(measure::judge(watch, radians, {0.045}).right());
  const std::vector<measure::Quantity> torques{{"torque", "N·m", [] { return 2.0; }}};
  CHECK(measure::judge(watch, torques, {0.019}).right());
  CHECK(measure::judge(watch, torques, {0.03}).text() ==
        "the torque is off by 0.03 N·m, 1.5 % of its largest");
}

TEST_CASE("at rest rounding is no energy error, an open start is none that is taken away") {
  const Method none{};
  Motion rest(plate(none, 0.0), none);
  CHECK(run(rest, 500, 0.01).right());
  const Method feedback{Scheme::rk4, Stabilization::feedback, 25.0, 10.0};
  const Method soft{Scheme::rk4, Stabilization::feedback, 25.0, 0.0};
  const Method projection{Scheme::rk4, Stabilization::projection};
  for (const Method& method : {none, feedback, soft, projection}) {
    CAPTURE(method.label(), method.kd);
    Motion motion(plate(method, 0.1), method);
    CHECK(run(motion, 500, 0.01).right());
  }
}

TEST_CASE("feedback that theory calls stable runs, however high it swings, what grows is stopped") {
  constexpr double h = 0.01, start = 1e-6;
  for (const Scheme name :
       {Scheme::explicit_euler, Scheme::semi_implicit_euler, Scheme::rk4, Scheme::dop853})
    for (const double damping : {0.01, 0.1, 1.0, 3.0, 10.0}) {
      // ks and kd at which h is the limit: for ks = 1 that is a number.
      const double limit = integrators::largest_stable_step(name, 1.0, 2.0 * damping);
      const auto largest = [&](double part, long steps) {
        const double rate = part * limit / h;
        const Method method{name, Stabilization::feedback, rate * rate, 2.0 * damping * rate};
        Motion motion(plate(method, start), method);
        double most = 0.0;
        run(motion, steps, h, &most);
        return most / start;
      };
      CAPTURE(integrators::info(name).text, damping, limit);
      for (const double part : {0.5, 0.9, 0.95, 0.98, 0.999}) CHECK_NOTHROW(largest(part, 4000));
      for (const double part : {1.05, 1.3, 3.0}) {
        CAPTURE(part);
        const double rate = part * limit / h;
        const Method method{name, Stabilization::feedback, rate * rate, 2.0 * damping * rate};
        Motion motion(plate(method, start), method);
        double most = 0.0;
        const double growth = integrators::amplification(name, h, method.ks, method.kd);
        const long enough = std::lround(20.0 / std::log(growth)) + 100;
        CHECK_THROWS_AS(run(motion, enough, h, &most), mechanics::Diverged);
        CHECK(most < 1e6 * start);
      }
    }
}

TEST_CASE("a swing is as high as the method's own steps make it") {
  // By stepping the test equation from (C, 0), without a matrix.
  for (const Scheme name :
       {Scheme::explicit_euler, Scheme::semi_implicit_euler, Scheme::rk4, Scheme::dop853})
    for (const double damping : {0.1, 1.0, 2.0}) {
      const double h = 0.99 * integrators::largest_stable_step(name, 1.0, 2.0 * damping);
      integrators::Integrator<double> integrator(name, 0.0);
      double C = 1.0, Cdot = 0.0, highest = 0.0;
      for (int i = 0; i < 5000; ++i) {
        integrator.step([&](double, double c, double v, double& a) { a = -c - 2.0 * damping * v; },
                        0.0, C, Cdot, h);
        highest = std::max(highest, std::hypot(C, Cdot));
      }
      CAPTURE(integrators::info(name).text, damping, highest);
      const double swing = integrators::largest_swing(name, h, 1.0, 2.0 * damping);
      CHECK(4.0 * swing > highest);
      CHECK(swing < 20.0 * std::max(1.0, highest));
    }
}
