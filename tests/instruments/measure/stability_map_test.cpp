// What notices a run that diverges, and what judges the cases.

#include <cmath>
#include <memory>
#include <numbers>
#include <stdexcept>

#include "catch.hpp"
#include "instruments/measure/cases.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"
#include "mechanics/motion/watch.hpp"

namespace {

using integrators::Scheme;
using mechanics::Mechanism;
using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<Mechanism>;

/// A uniform rod of 1 m and 1 kg, pinned at its start; level and at rest, in free fall without pin.
Mechanism rod(const Method& method, bool pinned = true) {
  Mechanism mechanism(method);
  mechanism.system.set_gravity({0.0, 9.81});
  const auto body = mechanism.system.add_body("rod", 1.0, 1.0 / 12.0, {0.5, 0.0});
  if (pinned)
    mechanism.system.add("rod_world", joints::Revolute{{-0.5, 0.0}, {0.0, 0.0}}, body,
                         dynamics::System::world);
  mechanism.assemble();
  return mechanism;
}

std::string message(Motion& motion, long steps, double h) {
  try {
    measure::run_and_watch(motion, steps, h);
  } catch (const mechanics::Diverged& diverged) {
    return diverged.what();
  }
  return "";
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("drive and kinetic energy: a free fall gains just what the bound allows") {
  // √(2T) = √m g t and √(FᵀWF) = √m g: the bound of Watch is met with equality.
  Motion fall(rod({}, false), {});
  fall.advance(100, 0.01);
  const mechanics::Measures now = fall.measures();
  CHECK(std::sqrt(2.0 * now.kinetic) == Approx(9.81).epsilon(1e-12));
  CHECK(now.drive == Approx(9.81).epsilon(1e-15));
  // Under a pin the kinetic energy stays below it.
  Motion swing(rod({}), {});
  for (int i = 0; i < 500; ++i) {
    swing.advance(1, 0.002);
    const mechanics::Measures at = swing.measures();
    REQUIRE(std::sqrt(2.0 * at.kinetic) < 9.81 * swing.time());
  }
}

TEST_CASE("distance to the constraints: what the least push in the mass metric has to cover") {
  // Off along the rod by δ, the rod moves as a whole: √m δ. Off across it the pin's end turns as
  // well: of a push at the end of a uniform rod a quarter counts as mass, √(m/4) δ.
  Mechanism mechanism = rod({});
  Eigen::VectorXd q = mechanism.initial_position();
  q[0] += 0.01;
  CHECK(mechanism.distance(0.0, q) == Approx(0.01).epsilon(1e-12));
  q[0] -= 0.01;
  q[1] += 0.01;
  CHECK(mechanism.distance(0.0, q) == Approx(0.005).epsilon(1e-12));
}

TEST_CASE("a run that diverges is noticed: when, where, by which measure") {
  const Method wild{Scheme::rk4, Stabilization::feedback, 9e6, 6e3};  // h√ks = 3
  Motion motion(rod(wild), wild);
  std::string text = message(motion, 2000, 1e-3);
  INFO(text);
  CHECK(holds(text, "at t = "));
  CHECK(holds(text, "kinetic energy"));
  CHECK(holds(text, "most of it in rod"));
  CHECK(holds(text, "rod_world row"));
  // At once: within a few steps of twice what a fall has, ½ m (g t)².
  const double fall = 0.5 * std::pow(9.81 * motion.time(), 2);
  CHECK(motion.measures().kinetic > 2.0 * fall);
  CHECK(motion.measures().kinetic < 200.0 * fall);
  CHECK(motion.row().measures.finite());

  // From an open start it is the error itself that is watched, long before a fall is as fast.
  motion.restart();
  motion.nudge(1e-8);
  text = message(motion, 2000, 1e-3);
  INFO(text);
  CHECK(holds(text, "the constraint error"));
  CHECK(motion.measures().constraint_error < 1e6 * 1e-8);

  const Method tame{Scheme::rk4, Stabilization::feedback, 6.25e6, 5e3};  // h√ks = 2.5
  Motion stable(rod(tame), tame);
  stable.nudge(1e-6);
  CHECK(message(stable, 2000, 1e-3).empty());
}

TEST_CASE("feedback from a wrong start may move as fast as it must") {
  // An undamped spring of √ks = 1000 1/s pulls the rod back over 0.3 m: 300 m/s and no divergence.
  const Method pull{Scheme::rk4, Stabilization::feedback, 1e6, 0.0};
  Motion motion(rod(pull), pull);
  motion.nudge(0.3);
  CHECK(message(motion, 200, 1e-4).empty());
  CHECK(motion.measures().kinetic > 1.0);
}

namespace {

/// q̈ = −k(t) q, a spring that becomes ever stiffer from t = 5 s on.
struct Stiffening : Mechanism {
  using Mechanism::Mechanism;
  double rate = 0.0;  // of ln k [1/s]
  void acceleration(double t, const Vector& q, const Vector&, Vector& a) {
    a = -std::exp(std::clamp(rate * (t - 5.0), 0.0, 500.0)) * q;
  }
};

}  // namespace

TEST_CASE("a tolerance whose steps collapse ends the run, one that takes many evenly does not") {
  const Method method{Scheme::dop853, Stabilization::none, 0.0, 0.0, 1e-6};
  const auto run = [&](double rate) -> std::string {
    Mechanism free = rod({}, false);
    Stiffening model{method};
    model.system = std::move(free.system);
    model.start_as_given();
    model.rate = rate;
    mechanics::Motion<Stiffening> motion(std::move(model), method);
    try {
      motion.advance(10, 1.0);
    } catch (const mechanics::Diverged& diverged) {
      CHECK(diverged.trouble == mechanics::Trouble::tolerance);
      return diverged.what();
    }
    return "";
  };
  const std::string collapsed = run(2000.0);
  INFO(collapsed);
  CHECK(holds(collapsed, "the tolerance takes more than 1e+08 steps"));
  CHECK(run(3.0).empty());
}

TEST_CASE("a case is as expected only when its outcome is the one written beside it") {
  const auto ends = [](measure::Expected expected, std::function<double()> run) {
    return measure::judge({"", "", std::move(expected), std::move(run)}).as_expected;
  };
  const auto gives = [](double figure) { return [=] { return figure; }; };
  const auto refuses = [](const char* text) {
    return [=]() -> double { throw std::runtime_error(text); };
  };
  CHECK(ends(measure::accurate(1e-6), gives(1e-7)));
  CHECK_FALSE(ends(measure::accurate(1e-6), gives(1e-5)));
  CHECK_FALSE(ends(measure::accurate(1e-6), gives(std::nan(""))));
  CHECK_FALSE(ends(measure::accurate(1e-6), refuses("no")));
  CHECK(ends(measure::degraded(1e-6, 1e-3), gives(1e-4)));
  CHECK_FALSE(ends(measure::degraded(1e-6, 1e-3), gives(1e-8)));  // better is another outcome
  CHECK_FALSE(ends(measure::degraded(1e-6, 1e-3), gives(1.0)));
  CHECK(ends(measure::refused("too short"), refuses("the rod is too short")));
  CHECK_FALSE(ends(measure::refused("too short"), refuses("something else")));
  CHECK_FALSE(ends(measure::refused("too short"), gives(0.0)));
}

TEST_CASE("a map counts what differs from theory") {
  // Ten cells of 0.2 across 0 ... 2. Theory: stable up to x = 1.05, which crosses the sixth column.
  // "Measured": stable left of x = 0.5, so the columns at 0.5, 0.7 and 0.9 differ.
  const measure::Plan plan{Scheme::rk4,
                           "x",
                           "y",
                           2.0,
                           1.0,
                           [](double x, double) { return x < 0.5; },
                           [](double x, double) { return x <= 1.05 ? 0.9 : 1.1; }};
  const measure::Map map = measure::measure_map(plan, 10);
  CHECK(map.compared() == 90);
  CHECK(map.agreeing() == 60);
}

TEST_CASE("the limit of feedback that is measured on a joint is that of theory") {
  const measure::Start start = [](const Method& method) {
    return std::make_unique<Motion>(rod(method), method);
  };
  // Closed forms at critical damping: explicit Euler 2, semi-implicit Euler 2√2 − 2.
  const measure::FeedbackTrial trial{.step = 1e-6, .nudge = 1e-6, .steps = 8000};
  CHECK(measure::measured_limit(Scheme::explicit_euler, start, trial) == Approx(2.0).epsilon(5e-3));
  CHECK(measure::measured_limit(Scheme::semi_implicit_euler, start, trial) ==
        Approx(2.0 * std::numbers::sqrt2 - 2.0).epsilon(5e-3));
  CHECK(measure::theoretical_limit(Scheme::rk4) == Approx(2.7853).epsilon(1e-4));
}

TEST_CASE("the exponent of a long run") {
  measure::LongCurve curve;
  for (int k = 1; k <= 40; ++k) {
    const double t = std::pow(10.0, 0.1 * k);
    curve.looks.push_back({t, 1e-9 * t * t});
  }
  CHECK(curve.exponent() == Approx(2.0).epsilon(1e-9));
  CHECK_FALSE(curve.bounded());
  for (auto& look : curve.looks) look.energy_error = 1e-3;
  CHECK(curve.bounded());
  for (auto& look : curve.looks) look.energy_error = 1.0;  // all of it is gone
  CHECK_FALSE(curve.bounded());
}
