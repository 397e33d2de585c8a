#include <algorithm>
#include <cmath>
#include <map>

#include "catch.hpp"
#include "engine.hpp"
#include "report.hpp"

using namespace peers;

namespace {

/// Where an engine is at the end of a run.
State end(const Model& model, const Engine& engine, const std::string& setting, double rung) {
  const auto found =
      std::find_if(engine.settings.begin(), engine.settings.end(),
                   [&](const Setting& s) { return s.name == setting && !s.is_default; });
  REQUIRE(found != engine.settings.end());
  const auto run = found->start(model, rung);
  run->run(60.0);
  return run->state();
}

/// A setting that converges, and how far; one digit and more above what was measured.
struct Expected {
  std::string setting;
  double rung, error;  ///< [rad], slider-crank
};

const std::map<std::string, Expected> expected{
    {ours, {"rk4", 1e-3, 1e-8}},
    {dense_form, {"rk4", 1e-3, 1e-8}},
    {"Box2D", {"8/3 iterations", 1.0 / 15360, 2e-2}},
    {"Chipmunk", {"10 iterations, error bias 0", 1.0 / 3840, 1e-2}},
    {"MuJoCo", {"Euler, Newton, solref 2 steps", 1.0 / 3840, 1e-3}},
    {"Simbody", {"RungeKuttaMerson", 1e-8, 1e-5}},
    {"SUNDIALS IDA",
     {"algebraic variables not tested, their atol 1000 times the others'", 1e-6, 1e-3}},
};

}  // namespace

TEST_CASE("every engine that was found comes close to the exact angle of the wheel") {
  const Model model = peers::slider_crank();
  for (const Engine& engine : engines()) {
    const Expected& e = expected.at(engine.name);
    const State state = end(model, engine, e.setting, e.rung);
    INFO(engine.name << ", " << e.setting << ", error " << error(model, state).value());
    CHECK(error(model, state).value() < e.error);
    CHECK(joint_gap(model, state) < 1e-3);
  }
}

TEST_CASE("a lucky crossing of zero counts for nobody") {
  const auto row = [](double step, double seconds, double error) {
    return Row{.engine = "E",
               .version = "",
               .setting = "S",
               .is_default = false,
               .parts = 3,
               .rung = Rung::step,
               .value = step,
               .steps = 1,
               .seconds = seconds,
               .error = error};
  };
  const std::vector<Row> rows{row(4, 1, 1e-2), row(2, 2, 1e-9), row(1, 4, 1e-4), row(0.5, 8, 1e-6)};
  CHECK(lasting_error(rows, rows[1]) == 1e-4);
  CHECK(cheapest(rows, "E", 1e-2) == &rows[0]);
  CHECK(cheapest(rows, "E", 1e-4) == &rows[1]);
  CHECK(cheapest(rows, "E", 1e-6) == &rows[3]);
  CHECK(cheapest(rows, "E", 1e-8) == nullptr);
}

TEST_CASE("every engine holds the masses and inertias of the scene") {
  for (const Model& model : {peers::slider_crank(), chain(3)})
    for (const Engine& engine : engines()) {
      INFO(engine.name);
      const auto masses =
          engine.settings.front().start(model, engine.settings.front().first)->masses();
      REQUIRE(masses.size() == model.parts.size());
      for (std::size_t i = 0; i < masses.size(); ++i) {
        CHECK(masses[i].first == Approx(model.parts[i].mass).epsilon(1e-6));
        CHECK(masses[i].second == Approx(model.parts[i].inertia).epsilon(1e-6));
      }
    }
}

TEST_CASE("every engine starts as the scene does") {
  for (Model model : {peers::slider_crank(), chain(3)}) {
    for (const Engine& engine : engines()) {
      INFO(engine.name);
      const State state =
          engine.settings.front().start(model, engine.settings.front().first)->state();
      REQUIRE(state.size() == model.parts.size());
      CHECK(joint_gap(model, state) < 1e-6);
      CHECK(kinetic_energy(model, state) < 1e-12);
      for (std::size_t i = 0; i < state.size(); ++i) {
        CHECK((state[i].x - model.parts[i].x).norm() < 1e-6);
        CHECK(std::abs(state[i].theta - model.parts[i].theta) < 1e-6);
      }
    }
  }
}
