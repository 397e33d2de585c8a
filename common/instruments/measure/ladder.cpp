#include "instruments/measure/ladder.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "instruments/measure/clock.hpp"
#include "instruments/measure/run.hpp"

namespace measure {
namespace {

/// The samples of a run are taken in passes over the whole ladder, since a machine may be slow for
/// seconds on end; long runs are timed in the first alone.
constexpr int samples = 2, passes = 4;
constexpr double long_run_seconds = 0.1;

/// The largest errors over a run are looked up at no more than this many evenly spaced times, so
/// that looking costs less than running; the last state is always among them.
constexpr long most_looks = 2000;

/// A method that chooses its own steps is stopped at so many evenly spaced times.
constexpr long intervals_of_tolerance = 4;

void run_for_errors(mechanics::Simulation& simulation, const Errors& errors, const Steps& intervals,
                    const std::vector<Quantity>& quantities, Rung& rung) {
  mechanics::Watch watch(simulation);
  Largest largest(simulation.measures());
  run(simulation, intervals, watch, largest);
  rung.constraint_error = largest.constraint_error;
  rung.energy_error = watch.largest_energy_error();
  rung.evaluations = simulation.evaluations();
  rung.steps = simulation.steps();
  if (rung.tolerance > 0.0) rung.step = simulation.time() / static_cast<double>(rung.steps);
  rung.errors = errors(simulation.row());
  for (const double error : rung.errors)
    if (!std::isfinite(error))
      throw mechanics::Diverged(mechanics::at(simulation.time()) + "the error is no longer finite");
  rung.far_off = judge(watch, quantities, rung.errors).words();
}

double run_for_time(mechanics::Simulation& simulation, const Steps& intervals) {
  return seconds_of(
      [&] {
        simulation.restart();
        simulation.advance(intervals.number, intervals.length);
      },
      {.samples = samples, .most = std::numeric_limits<double>::infinity()});
}

}  // namespace

mechanics::Verdict judge(const mechanics::Watch& watch, const std::vector<Quantity>& quantities,
                         const std::vector<double>& errors) {
  double position = 0.0, angle = 0.0, velocity = 0.0;
  for (std::size_t k = 0; k < errors.size() && k < quantities.size(); ++k) {
    if (quantities[k].unit == "m") position = std::max(position, errors[k]);
    if (quantities[k].unit == "rad") angle = std::max(angle, errors[k]);
    if (quantities[k].unit == "m/s") velocity = std::max(velocity, errors[k]);
  }
  mechanics::Verdict verdict = watch.verdict(position, angle, velocity);
  for (std::size_t k = 0; k < errors.size() && k < quantities.size(); ++k) {
    const auto& [name, unit, largest] = quantities[k];
    const double most = largest ? largest() : 0.0, part = errors[k] / most;
    if (errors[k] > mechanics::Watch::far * most && most > 0.0)
      verdict.faults.push_back({name,
                                "the " + name + " is off by " + mechanics::in_digits(errors[k]) +
                                    " " + unit + ", " + mechanics::in_digits(100.0 * part) +
                                    " % of its largest",
                                mechanics::Trouble::late});
  }
  return verdict;
}

std::vector<Rung> climb(const Ladder& ladder, const Start& start, const Errors& errors,
                        const Progress& progress) {
  struct Task {
    mechanics::Method method;
    Steps intervals;
  };
  std::vector<Task> tasks;  // of each rung
  std::vector<Rung> rungs;
  double done = 0.0;
  const double all = static_cast<double>(ladder.methods.size()) * ladder.rungs * passes;
  for (mechanics::Method method : ladder.methods) {
    const auto& integrator = integrators::info(method.integrator);
    const double reach = std::max(1.0, integrator.evaluations / 4.0);
    const long first = std::max(1L, std::lround(ladder.duration / (ladder.coarsest * reach)));
    double least_error = std::numeric_limits<double>::infinity();
    int since_least = 0;
    for (int i = 0; i < ladder.rungs; ++i) {
      const long number = method.tolerance > 0.0 ? intervals_of_tolerance : first << i;
      if (number > ladder.most_steps) break;
      const Steps intervals{number, ladder.duration / static_cast<double>(number),
                            std::max(1L, number / most_looks)};
      if (i > 0 && method.tolerance > 0.0) method.tolerance /= 10.0;
      if (method.tolerance > 0.0 && method.tolerance < 0.5 * mechanics::finest_tolerance) break;
      Rung rung{.method = method.label(), .order = integrator.order, .tolerance = method.tolerance};
      if (method.tolerance == 0.0) rung.step = intervals.length, rung.steps = intervals.number;
      progress(done++ / all, rung.method);
      const auto simulation = start(method);
      try {
        run_for_errors(*simulation, errors, intervals, ladder.quantities, rung);
        rung.seconds = run_for_time(*simulation, intervals);
      } catch (const mechanics::Diverged& diverged) {
        rung.errors.clear();
        rung.constraint_error = rung.energy_error = 0.0;
        rung.failure = diverged.what();
      }
      rungs.push_back(rung);
      tasks.push_back({method, intervals});
      if (rung.errors.empty()) continue;
      since_least = rung.errors[0] < 0.7 * least_error ? 0 : since_least + 1;
      least_error = std::min(least_error, rung.errors[0]);
      if (i >= 7 && since_least >= 1 && method.tolerance == 0.0) break;
    }
  }
  for (int pass = 1; pass < passes; ++pass)
    for (std::size_t i = 0; i < rungs.size(); ++i) {
      progress((pass + static_cast<double>(i) / static_cast<double>(rungs.size())) / passes,
               "timed again");
      if (rungs[i].errors.empty() || rungs[i].seconds > long_run_seconds) continue;
      const auto simulation = start(tasks[i].method);
      rungs[i].seconds = std::min(rungs[i].seconds, run_for_time(*simulation, tasks[i].intervals));
    }
  progress(1.0, "");
  return rungs;
}

double observed_order(const Rung& coarse, const Rung& fine, std::size_t k) {
  if (coarse.errors.empty() || fine.errors.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::log2(coarse.errors[k] / fine.errors[k]) / std::log2(coarse.step / fine.step);
}

std::vector<std::string> machine() {
  std::string processor = "unknown";
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.starts_with("model name")) {
      processor = line.substr(line.find(':') + 2);
      break;
    }
  return {"processor: " + processor, "compiler: " TUTORIAL_COMPILER, "flags: " TUTORIAL_FLAGS,
          "build type: " TUTORIAL_BUILD_TYPE};
}

}  // namespace measure
