#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "app/options.hpp"
#include "catch.hpp"
#include "instruments/files/files.hpp"
#include "instruments/measure/clock.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/measure/report.hpp"
#include "instruments/measure/run_options.hpp"

namespace {

/// q̈ = −q from q = 1: q(t) = cos t.
struct Oscillator {
  using Vector = double;
  double blow_up_after = 1e300;
  void acceleration(double t, double q, double, double& a) const {
    a = t > blow_up_after ? std::nan("") : -q;
  }
  double initial_position() const { return 1.0; }
  double initial_velocity() const { return 0.0; }
  mechanics::Measures measures(double, double q, double v) const {
    return {.energy = 0.5 * (q * q + v * v),
            .constraint_error = 0.0,
            .velocity_error = 0.0,
            .kinetic = 0.5 * v * v,
            .drive = std::abs(q)};
  }
  std::string culprit(double, double, double) const { return "the oscillator"; }
  void cover(double q, mechanics::Reach& reach) const { reach.cover(q, 0.0); }
  double free_acceleration(double, double, double) const { return 1.0; }
  mechanics::Columns columns() const { return {{"q", "v"}, {}}; }
  mechanics::Uses uses() const {
    return {.things = 1,
            .coordinates = 1,
            .rows = 0,
            .rank = 0,
            .state_bytes = 2 * sizeof(double),
            .workspace_bytes = 0,
            .left_out = {}};
  }
  void observe(double, double q, double v, mechanics::Row& row) const { row.state = {q, v}; }
};

measure::Ladder ladder() {
  return {.methods = {{integrators::Scheme::explicit_euler}, {integrators::Scheme::rk4}},
          .duration = 3.0,
          .coarsest = 0.1,
          .rungs = 9};
}

const measure::Errors errors = [](const mechanics::Row& row) {
  return std::vector<double>{std::abs(row.state[0] - std::cos(row.t))};
};

measure::Report report(const Oscillator& oscillator) {
  const auto start = [&](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<Oscillator>>(oscillator, method);
  };
  return {"Oscillator",
          3.0,
          "m",
          {{"q", "m"}},
          measure::machine(),
          measure::climb(ladder(), start, errors, [](double, const std::string&) {})};
}

}  // namespace

TEST_CASE("a motion keeps time without gathering rounding") {
  mechanics::Motion<Oscillator> motion(Oscillator{}, {});
  motion.advance(1000000, 1e-3);
  CHECK(motion.time() == 1000.0);
  CHECK(motion.evaluations() == 4000000);
  motion.restart();
  CHECK(motion.time() == 0.0);
  CHECK(motion.evaluations() == 0);
}

TEST_CASE("a ladder has the promised rungs, evaluations and orders") {
  const measure::Report result = report({});
  CHECK(measure::methods(result) == std::vector<std::string>{"explicit_euler", "rk4"});
  CHECK(result.rungs.size() >= 16);
  const measure::Rung* coarse = nullptr;
  for (const measure::Rung& rung : result.rungs) {
    CHECK(static_cast<double>(rung.steps) * rung.step == Approx(3.0));
    CHECK(rung.evaluations == rung.steps * (rung.method == "rk4" ? 4 : 1));
    CHECK(rung.seconds > 0.0);
    if (coarse != nullptr && coarse->method == rung.method && rung.errors[0] > 1e-12 &&
        rung.step < 0.02)
      CHECK(measure::observed_order(*coarse, rung) == Approx(rung.order).margin(0.15));
    coarse = &rung;
  }
}

TEST_CASE("a ladder of tolerances divides each by ten and tells the mean of its steps") {
  const auto rungs = measure::climb(
      {.methods = {{.integrator = integrators::Scheme::dop853, .tolerance = 1e-2}},
       .duration = 3.0,
       .coarsest = 0.1},
      [&](const mechanics::Method& method) {
        return std::make_unique<mechanics::Motion<Oscillator>>(Oscillator{}, method);
      },
      errors, [](double, const std::string&) {});
  REQUIRE(rungs.size() == 12);
  for (std::size_t i = 0; i < rungs.size(); ++i) {
    CHECK(rungs[i].tolerance == Approx(std::pow(10.0, -2.0 - static_cast<double>(i))));
    CHECK(rungs[i].method == "dop853 adaptive");
    CHECK(rungs[i].step * static_cast<double>(rungs[i].steps) == Approx(3.0));
    CHECK(rungs[i].evaluations >= 12 * rungs[i].steps);
    CHECK(rungs[i].errors[0] < 10 * rungs[i].tolerance + 1e-15);
  }
  CHECK(rungs.back().steps > rungs.front().steps);
}

TEST_CASE("a method that cannot take its step ends the run with the time and the reason") {
  mechanics::Motion<Oscillator> motion(
      Oscillator{.blow_up_after = 1.5},
      {.integrator = integrators::Scheme::dop853, .tolerance = 1e-6});
  CHECK_THROWS_WITH(motion.advance(1, 3.0),
                    ContainsSubstring("at t = 1.") && ContainsSubstring("no step is short enough"));
  CHECK(std::isfinite(motion.q()));
}

TEST_CASE("a run that diverges says when and which coordinate") {
  mechanics::Motion<Oscillator> motion(Oscillator{.blow_up_after = 1.5}, {});
  CHECK_THROWS_WITH(motion.advance(30, 0.1),
                    ContainsSubstring("at t = 1.") && ContainsSubstring("v is no longer finite"));
}

TEST_CASE("a failed run is a row that says why") {
  const measure::Report result = report({.blow_up_after = 1.5});
  REQUIRE(!result.rungs.empty());
  for (const measure::Rung& rung : result.rungs) {
    CHECK(rung.errors.empty());
    CHECK(rung.failure.find("finite") != std::string::npos);
  }
  CHECK(measure::table(result).find("failed") != std::string::npos);
  CHECK(measure::csv(result).find("nan") == std::string::npos);
}

TEST_CASE("a report survives its own file") {
  const auto folder =
      std::filesystem::temp_directory_path() / ("report_test_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  measure::Report before = report({});
  before.remark = "why";
  files::write_file(folder / "r.csv", measure::csv(before));
  const measure::Report after = measure::read_csv(folder / "r.csv");
  CHECK(measure::csv(after) == measure::csv(before));
  CHECK(after.remark == "why");
  CHECK(measure::table(after).size() > 100);
  std::ofstream(folder / "broken.csv") << "method,order\nrk4,four\n";
  CHECK_THROWS_WITH(measure::read_csv(folder / "broken.csv"), ContainsSubstring("does not fit"));
  CHECK_THROWS(measure::read_csv(folder / "missing.csv"));
  std::filesystem::remove_all(folder);
}

TEST_CASE("time to reach is where the runs come below the level to stay") {
  measure::Report result{"t", 1.0, "m", {{"q", "m"}}, {}, {}};
  const auto add = [&](double seconds, const std::vector<double>& error) {
    result.rungs.push_back(
        {"rk4", 4, 0.0, 0.1, 10, 40, seconds, error, 0.0, 0.0, error.empty() ? "failed" : ""});
  };
  add(0.1, {});
  add(1.0, {1e-2});
  add(2.0, {1e-4});
  add(3.0, {1e-5});
  CHECK(measure::time_to_reach(result, "rk4", 1e-3) == Approx(std::sqrt(2.0)));
  CHECK(measure::time_to_reach(result, "rk4", 1e-2) == 1.0);
  CHECK(std::isinf(measure::time_to_reach(result, "rk4", 1e-9)));
  add(3.5, {});
  CHECK(measure::time_to_reach(result, "rk4", 1e-3) == Approx(std::sqrt(2.0)));
  add(4.0, {5e-4});  // below 1e-3, but no longer below 1e-4
  CHECK(measure::time_to_reach(result, "rk4", 1e-3) == Approx(std::sqrt(2.0)));
  CHECK(std::isinf(measure::time_to_reach(result, "rk4", 1e-4)));
}

TEST_CASE("a file appears whole or not at all") {
  const auto folder =
      std::filesystem::temp_directory_path() / ("files_test_" + std::to_string(getpid()));
  files::make_folder(folder / "a" / "b");
  CHECK(std::filesystem::is_empty(folder / "a" / "b"));
  {
    files::NewFile file(folder / "dropped");
    file.write("half");
  }
  CHECK(!std::filesystem::exists(folder / "dropped"));
  files::write_file(folder / "kept", "whole");
  CHECK(std::filesystem::file_size(folder / "kept") == 5);
  CHECK_THROWS_WITH(files::write_file(folder / "missing" / "file", "x"),
                    ContainsSubstring("No such file"));
  CHECK_THROWS_WITH(files::make_folder(folder / "kept" / "sub"), ContainsSubstring("cannot make"));
  CHECK_THROWS_WITH(files::write_file(folder / "a", "x"), ContainsSubstring("not a file"));
  std::filesystem::remove(folder / "kept");
  CHECK(std::distance(std::filesystem::directory_iterator(folder), {}) == 1);
  std::filesystem::remove_all(folder);
}

TEST_CASE("numbers on the command line are read whole and in their range") {
  using app::number;
  CHECK(number("--a", "1e3", app::any) == 1000.0);
  CHECK(number("--a", "-0.5", app::any) == -0.5);
  CHECK(number("--a", "+2", app::any) == 2.0);
  for (const char* bad :
       {"", "x", "1x", "nan", "inf", "-inf", "1e400", "1e-400x", "0x10", "1,5", " 1"}) {
    INFO(bad);
    CHECK_THROWS_AS(number("--a", bad, app::any), app::UsageError);
  }
  CHECK_THROWS_WITH(number("--mass", "-1", app::positive),
                    ContainsSubstring("--mass -1") && ContainsSubstring("allowed"));
}

TEST_CASE("the last step is shorter where the duration is no whole number of steps") {
  measure::RunOptions run{.duration = 1.0, .step = 0.3};
  CHECK(run.whole_steps() == 3);
  CHECK(run.remainder() == Approx(0.1));
  run.step = 0.1;
  CHECK(run.whole_steps() == 10);
  CHECK(run.remainder() == 0.0);
  run.step = 2.0;
  CHECK(run.whole_steps() == 0);
  CHECK(run.remainder() == 1.0);
}

TEST_CASE("the clock counts work, not waiting") {
  const double before = measure::cpu_seconds();
  usleep(50000);
  CHECK(measure::cpu_seconds() - before < 0.02);
}
