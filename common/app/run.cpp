#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "app/advice.hpp"
#include "app/commands.hpp"
#include "instruments/files/files.hpp"
#include "instruments/files/progress.hpp"
#include "instruments/files/table.hpp"
#include "instruments/measure/clock.hpp"
#include "instruments/measure/run.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "mechanics/motion/watch.hpp"

namespace app {
namespace {

/// The trajectory as comma-separated values, to a file or to standard output.
class Trajectory {
 public:
  Trajectory(const std::string& name, const mechanics::Columns& columns) {
    if (name != "-") file_.emplace(name);
    files::Table::Row header{"t"};
    header.insert(header.end(), columns.state.begin(), columns.state.end());
    header.insert(header.end(), {"energy", "constraint_error", "velocity_error"});
    header.insert(header.end(), columns.reactions.begin(), columns.reactions.end());
    put(files::csv_line(header));
  }

  void add(const mechanics::Row& row) {
    cells_.clear();
    const auto value = [this](double number) { cells_.push_back(files::digits(number, 17)); };
    value(row.t);
    for (const double number : row.state) value(number);
    value(row.measures.energy);
    value(row.measures.constraint_error);
    value(row.measures.velocity_error);
    for (const double number : row.reactions) value(number);
    put(files::csv_line(cells_));
  }

  void finish() {
    if (file_)
      file_->commit();
    else if (std::fflush(stdout) != 0)
      throw std::runtime_error("cannot write standard output");
  }

 private:
  void put(const std::string& text) {
    if (file_)
      file_->write(text);
    else if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size())
      throw std::runtime_error("cannot write standard output");
  }

  std::optional<files::NewFile> file_;
  files::Table::Row cells_;
};

/// A reaction may be no number, where it is not determined.
bool is_finite(const mechanics::Row& row) {
  return std::all_of(row.state.begin(), row.state.end(),
                     [](double value) { return std::isfinite(value); }) &&
         std::none_of(row.reactions.begin(), row.reactions.end(),
                      [](double value) { return std::isinf(value); });
}

bool is_determined(const mechanics::Row& row) {
  return std::none_of(row.reactions.begin(), row.reactions.end(),
                      [](double value) { return std::isnan(value); });
}

/// Processor time of a step [s]: the first of them once more, without anything between, since a
/// clock takes longer than a step. Not a number where there is no whole step.
double seconds_per_step(const Chapter& chapter, const measure::RunOptions& run) {
  const long some = std::min(run.whole_steps(), run.method.tolerance > 0.0 ? 1L : 16L);
  const auto simulation = chapter.start(run.method);
  const double seconds = measure::seconds_of(
      [&] {
        simulation->restart();
        simulation->advance(some, run.step);
      },
      {.samples = 4, .most = 2e-3});
  return seconds / static_cast<double>(simulation->steps());
}

/// What the scene holds, what a step of it costs, and what was left out.
void print_uses(const mechanics::Uses& uses, double step) {
  const auto some = [](int count, const char* of_one, const char* of_more) {
    return fmt::format("{} {}", count, count == 1 ? of_one : of_more);
  };
  fmt::print("uses: {}, {}, {} of rank {}, {}", some(uses.things, "thing", "things"),
             some(uses.coordinates, "coordinate", "coordinates"), some(uses.rows, "row", "rows"),
             uses.rank, some(uses.degrees_of_freedom(), "degree of freedom", "degrees of freedom"));
  if (uses.blocks_of_J > 0)
    fmt::print(", {} of J, {} of the factor of J W Jᵀ", some(uses.blocks_of_J, "block", "blocks"),
               uses.blocks_of_factor);
  fmt::print(", {} bytes of state, {} of workspace", uses.state_bytes, uses.workspace_bytes);
  if (std::isfinite(step)) fmt::print(", {:.0f} ns a step", 1e9 * step);
  fmt::print("\nleft out: {}\n", fmt::join(uses.left_out, ", "));
}

/// What is known of a run at its end; the errors of the constraints are the largest over it.
struct Finished {
  mechanics::Row last;
  std::vector<double> errors;
  measure::Largest largest;
  mechanics::Verdict verdict;
};

/// With --strict, a run that is far from right.
struct FarFromRight : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void print_summary(const Chapter& chapter, const measure::RunOptions& run,
                   mechanics::Simulation& simulation, const Finished& finished) {
  const auto& [last, errors, largest, verdict] = finished;
  const auto line = [](const std::string& name, double value, const std::string& unit) {
    if (std::isnan(value))
      fmt::print("  {:<28}not determined: rows depend on others here\n", name);
    else
      fmt::print("  {:<28}{:>12.3g} {}\n", name, value, unit);
  };
  fmt::print("{}: {}\n", chapter.title, run.method.label());
  const std::string steps = run.method.tolerance > 0.0
                                ? fmt::format("in {} steps of its own choice, tolerance {:g}",
                                              simulation.steps(), run.method.tolerance)
                                : fmt::format("with a step of {:g} s", run.step);
  fmt::print("{:g} s simulated {}: {} evaluations of the acceleration\n", last.t, steps,
             simulation.evaluations());
  if (run.method.stabilization == mechanics::Stabilization::feedback) {
    const auto& [integrator, stabilization, ks, kd, tolerance] = run.method;
    fmt::print("feedback: ks = {:g} 1/s², kd = {:g} 1/s, h√ks = {:.3g}\n", ks, kd,
               run.step * std::sqrt(ks));
    const double swing = integrators::largest_swing(integrator, run.step, ks, kd);
    if (tolerance == 0.0 && swing > 4.0 && std::isfinite(swing))
      fmt::print("feedback: close to its limit, an error may swing to {:.2g} times its start\n",
                 swing);
  }
  for (const std::string& note : simulation.notes()) fmt::print("{}\n", note);
  print_uses(simulation.uses(), seconds_per_step(chapter, run));
  if (!measure::optimised)
    fmt::print("built without optimisation or with assertions: a release build takes less time\n");
  fmt::print("\nstate at the end\n");
  const mechanics::Columns columns = simulation.columns();
  for (std::size_t i = 0; i < columns.state.size(); ++i)
    fmt::print("  {:<28}{:>20.12g}\n", columns.state[i], last.state[i]);
  fmt::print("\nerror against the exact answer, at the end\n");
  if (errors.empty()) fmt::print("  none: no exact answer is computed for this scene\n");
  for (std::size_t k = 0; k < errors.size(); ++k)
    line(chapter.quantities[k].name, errors[k], chapter.quantities[k].unit);
  fmt::print("\nlargest over the run\n");
  line("constraint error |C|", largest.constraint_error, chapter.constraint_unit);
  line("velocity error |J v|", largest.velocity_error, chapter.constraint_unit + "/s");
  if (std::isnan(largest.energy_error))
    fmt::print("  {:<28}not compared: a load takes energy that the state does not tell\n",
               "energy error");
  else
    line("energy error", largest.energy_error, "J");
  if (!verdict.right()) fmt::print("\nfar from right: {}\n", verdict.text());
}

/// The loop of `run`, and of `snapshot` ahead of its pictures. Hands on the rows that --every
/// wants, and tells a run that is far from right: by a warning, or with --strict by an exception.
template <class TakeRow>
Finished run_to_the_end(const Chapter& chapter, const Request& request,
                        mechanics::Simulation& simulation, TakeRow&& take_row) {
  const measure::RunOptions& run = request.run;
  const long steps = run.whole_steps();
  Finished finished{simulation.row(), {}, measure::Largest(simulation.measures()), {}};
  mechanics::Row& last = finished.last;
  mechanics::Watch watch(simulation);
  {
    files::Progress progress;
    double next_row = 0.0;
    long done = 0;
    const auto look = [&](const mechanics::Row& now) {
      last = now;
      watch.look(now.measures);
      finished.largest.look(now.measures);
      if (!is_finite(now))
        throw mechanics::Diverged(mechanics::at(now.t) + "a force is no longer finite");
      const bool end = done == steps + (run.remainder() > 0.0 ? 1 : 0);
      if (end || now.t >= next_row - 1e-9 * run.step) {
        take_row(now);
        if (run.every > 0.0) next_row = (std::floor(now.t / run.every + 1e-9) + 1.0) * run.every;
      }
      if (done % 64 == 0 && !end)
        progress.show(static_cast<double>(done) / static_cast<double>(steps), "simulated");
      ++done;
    };
    look(last);
    measure::run(simulation, {steps, run.step, 1, run.remainder()}, look);
    progress.show(1.0, "exact answer");
    finished.errors = chapter.errors(last);
  }
  for (const double error : finished.errors)
    if (std::isinf(error) || (std::isnan(error) && is_determined(last)))
      throw mechanics::Diverged(mechanics::at(last.t) + "the error is no longer finite");
  finished.largest.energy_error = watch.largest_energy_error();  // counts from a closed start
  finished.verdict = measure::judge(watch, chapter.quantities, finished.errors);
  if (!finished.verdict.right()) {
    // Past a pose without full rank a drift decides, and with shorter steps another one.
    const bool drift_decided =
        simulation.lost_rank() &&
        run.method.stabilization != mechanics::Stabilization::projection &&
        (run.method.tolerance > 0.0 || finished.verdict.trouble() == mechanics::Trouble::late);
    const auto trouble = drift_decided ? mechanics::Trouble::singular : finished.verdict.trouble();
    const std::string text =
        fmt::format("{}; {}", finished.verdict.text(), advice(chapter, run, trouble));
    if (request.strict) throw FarFromRight(text);
    say(fmt::format("warning: {}\n", text));
  }
  return finished;
}

}  // namespace

void say(const std::string& text) { std::fputs(text.c_str(), stderr); }

void warn_of_gains(const measure::RunOptions& run) {
  if (const auto fault = fault_of_gains(run)) say(fmt::format("warning: {}\n", *fault));
}

void run_command(const Chapter& chapter, const Request& request) {
  const measure::RunOptions& run = request.run;
  const auto simulation = chapter.start(run.method);
  std::optional<Trajectory> trajectory;
  if (!run.csv.empty()) {
    try {
      trajectory.emplace(run.csv, simulation->columns());
    } catch (const std::runtime_error& error) {
      throw UsageError(
          fmt::format("--csv {}: {}; allowed is a file name in a folder that can be written, or -",
                      run.csv, error.what()));
    }
  }
  warn_of_gains(run);

  const Finished finished = run_to_the_end(chapter, request, *simulation, [&](const auto& row) {
    if (trajectory) trajectory->add(row);
  });
  if (trajectory) trajectory->finish();
  if (run.csv != "-") print_summary(chapter, run, *simulation, finished);
}

void snapshot_command(const Chapter& chapter, const Request& request) {
  request.snapshot.check(request.run, mechanics::most_steps);
  prepare_folder(request.out);
  warn_of_gains(request.run);
  Request ahead = request;
  ahead.run.duration = request.snapshot.end(request.run);
  mechanics::Verdict verdict;
  if (ahead.run.duration > 0.0)
    verdict = run_to_the_end(chapter, ahead, *chapter.start(ahead.run.method), [](const auto&) {
              }).verdict;
  take(request.snapshot, chapter, request.run, verdict, request.out);
}

}  // namespace app
