#include "measure.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>

#include "instruments/measure/clock.hpp"

namespace peers {
namespace {

/// The smallest of several runs is the one that was disturbed least.
constexpr int most_repeats = 15;
constexpr double repeat_seconds = 0.1;

constexpr int most_failures = 3;  ///< in a row, of an engine that chooses its own steps
constexpr int least_rungs = 6;    ///< climbed before a ladder may end for want of progress

/// Of all threads of this process.
double process_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bool finite(const State& state) {
  return std::all_of(state.begin(), state.end(), [](const dynamics::Body& body) {
    return body.x.allFinite() && body.v.allFinite() && std::isfinite(body.theta) &&
           std::isfinite(body.omega);
  });
}

void look(const Model& model, const State& state, Row& row) {
  if (!finite(state)) throw std::runtime_error("the state is no longer finite");
  row.joint_gap = joint_gap(model, state);
  row.error = error(model, state);
  row.energy_error = std::abs(energy_balance(model, state) - energy_balance(model, start(model))) /
                     kinetic_energy(model, state);
  if (!std::isfinite(row.joint_gap) || !std::isfinite(row.energy_error) ||
      !std::isfinite(row.error.value_or(0)))
    throw std::runtime_error("the error is no longer finite");
}

/// What engines print by themselves goes nowhere while this lives: a debug build's greeting, or a
/// warning at every step that a row sums up in its own words.
class Silence {
 public:
  Silence() {
    std::fflush(nullptr);
    const int nowhere = open("/dev/null", O_WRONLY);
    for (int stream : {STDOUT_FILENO, STDERR_FILENO}) {
      kept_[stream] = dup(stream);
      if (nowhere >= 0 && kept_[stream] >= 0) dup2(nowhere, stream);
    }
    if (nowhere >= 0) close(nowhere);
  }
  ~Silence() {
    std::fflush(nullptr);
    for (const auto& [stream, kept] : kept_) {
      if (kept < 0) continue;
      dup2(kept, stream);
      close(kept);
    }
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  std::map<int, int> kept_;
};

/// As one line that fits between quotes.
std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  for (char& c : text) {
    if (c == '\n') c = ' ';
    if (c == '"') c = '\'';
  }
  return text;
}

/// Runs a model to its end, for steps and seconds, once and then as often as it pays; `look(state)`
/// is shown the end and may throw. What fails is told in the row.
template <class Look>
void run_and_time(const Model& model, const Setting& setting, double allowed, Row& row,
                  Look&& look) {
  const Silence silence;
  double total = 0, before = 0;
  row.seconds = std::numeric_limits<double>::infinity();
  std::unique_ptr<Run> run;
  try {
    for (int i = 0; i == 0 || (i < most_repeats && total < repeat_seconds); ++i) {
      const double set_up = measure::cpu_seconds();
      run = setting.start(model, row.value);
      const double all_before = process_seconds();
      before = measure::cpu_seconds();
      run->run(allowed);
      const double seconds = measure::cpu_seconds() - before;
      const double elsewhere = process_seconds() - all_before - seconds;
      if (elsewhere > 0.05 * seconds + 1e-4)
        throw std::runtime_error("it works on other threads, whose time is not measured");
      row.seconds = std::min(row.seconds, seconds);
      total += measure::cpu_seconds() - set_up;
      row.steps = run->steps();
      if (i == 0) look(run->state());
    }
    return;
  } catch (const CutShort& cut) {
    row.failure = one_line(cut.what());
    row.seconds = measure::cpu_seconds() - before;
    row.steps = run->steps();
  } catch (const std::exception& failure) {
    row.failure = one_line(failure.what());
    row.seconds = before > 0 ? measure::cpu_seconds() - before : 0;
    row.steps = 0;
  }
  row.error.reset();
  row.energy_error = row.joint_gap = 0;
}

/// Whether the joints of a run are open by less than a part is long: a step of a chain that lies in
/// pieces costs this solver more, and is nobody's price.
bool holds(const Model& model, const Row& row) {
  double reach = 0;
  for (const Part& part : model.parts) reach = std::max(reach, part.x.norm());
  return row.joint_gap < reach / model.size();
}

constexpr auto not_at_all = [](const State&) {};

/// The next value of a ladder: half the step, or half a digit more.
double finer(const Setting& setting, double value) {
  return setting.rung == Rung::step ? value / 2 : value / std::sqrt(10.0);
}

/// Of one step at the coarsest rung, run alone. 0 where the engine chooses its steps itself.
double one_step(const Model& model, const Setting& setting) {
  if (setting.rung == Rung::accuracy) return 0;
  Model short_model = model;
  short_model.duration = setting.first;
  Row row{"", "", "", false, model.size(), setting.rung, setting.first};
  run_and_time(short_model, setting, 0, row, not_at_all);
  return row.seconds;
}

/// What one step of a longer chain may cost: more by the cube of its length at the worst.
double foreseen_step(const std::vector<Row>& before, const Engine& engine, const Setting& setting,
                     int parts) {
  if (setting.rung == Rung::accuracy) return 0;  // such a run can be cut short
  double seconds = std::numeric_limits<double>::infinity();
  double growth = 0;
  for (const Row& row : before)
    if (row.engine == engine.name && row.setting == setting.name && row.steps > 0) {
      seconds = std::min(seconds, row.seconds_a_step());
      growth = std::pow(static_cast<double>(parts) / row.parts, 3);
    }
  return growth > 0 ? seconds * growth : 0.0;
}

/// Climbs the ladder of one setting.
void climb(const Model& model, const Setting& setting, const Limits& limits, double step,
           const Row& blank, std::vector<Row>& rows) {
  double least = std::numeric_limits<double>::infinity();
  int since_least = 0, failures = 0;
  bool finished = false;
  double value = setting.first, seconds = 0;
  for (int i = 0; i < (setting.is_default ? 1 : limits.most_rungs); ++i) {
    // A ladder that has not come to a run that goes well yet may spend more.
    const double allowed = finished ? limits.run_seconds : limits.first_seconds;
    const double expected = setting.rung == Rung::step
                                ? step * static_cast<double>(whole_steps(model, value))
                                : 2 * seconds;
    if (expected > allowed && finished) break;
    Row& row = rows.emplace_back(blank);
    row.value = value;
    const long all = whole_steps(model, value);
    if (expected > allowed) {  // a few steps, to learn what they cost
      const long some = std::max(1L, std::min(all, static_cast<long>(allowed / step)));
      Model short_model = model;
      short_model.duration = model.duration * static_cast<double>(some) / static_cast<double>(all);
      run_and_time(short_model, setting, allowed, row, not_at_all);
      if (row.failure.empty())
        row.failure =
            fmt::format("cut short: {} of {} steps; all would take {:.2g} s", some, all, expected);
      break;
    }
    run_and_time(model, setting, allowed, row,
                 [&](const State& state) { look(model, state, row); });
    seconds = std::max(seconds, row.seconds);
    if (row.failure.empty()) {
      finished = finished || holds(model, row);
      const double now = row.error.value_or(row.energy_error);
      since_least = now < 0.9 * least ? 0 : since_least + 1;
      least = std::min(least, now);
    }
    failures = row.failure.empty() ? 0 : failures + 1;
    const bool cut_short = failures > 0 && row.steps > 0;
    if (cut_short || (setting.rung == Rung::accuracy && failures >= most_failures)) break;
    if (i + 1 >= least_rungs && since_least >= 2) break;
    value = finer(setting, value);
  }
}

}  // namespace

std::vector<Row> climb(const Model& model, const std::vector<Engine>& engines, const Limits& limits,
                       const std::vector<Row>& before, const Progress& progress) {
  std::vector<Row> rows;
  double done = 0, all = 0;
  for (const Engine& engine : engines) all += static_cast<double>(engine.settings.size());
  for (const Engine& engine : engines)
    for (const Setting& setting : engine.settings) {
      progress(done++ / all, engine.name + ", " + setting.name);
      if (!model.rail && !setting.in_chain) continue;
      const Row blank{engine.name,  engine.version, setting.name, setting.is_default,
                      model.size(), setting.rung,   setting.first};
      double step = foreseen_step(before, engine, setting, model.size());
      if (step <= limits.first_seconds) step = one_step(model, setting);
      if (step <= limits.first_seconds) {
        climb(model, setting, limits, step, blank, rows);
        continue;
      }
      rows.push_back(blank);
      rows.back().failure = fmt::format(
          "left out: one step may take {:.2g} s, more than the {:g} s allowed for a whole run",
          step, limits.first_seconds);
    }
  return rows;
}

}  // namespace peers
