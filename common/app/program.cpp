#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <tuple>

#include "app/advice.hpp"
#include "app/chapter.hpp"
#include "app/live.hpp"
#include "app/snapshot.hpp"
#include "instruments/files/files.hpp"
#include "instruments/files/progress.hpp"
#include "instruments/files/table.hpp"
#include "instruments/measure/clock.hpp"
#include "instruments/measure/report.hpp"
#include "instruments/measure/run.hpp"
#include "instruments/pictures/stability_pictures.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "mechanics/motion/watch.hpp"

namespace app {
namespace {

/// A stream that was closed would lend its number to the next file or to the display, which would
/// then be written into. Reading alone makes writing fail, as it did before.
void open_standard_streams() {
  for (int stream = 0; stream <= 2; ++stream)
    if (fcntl(stream, F_GETFD) == -1) open("/dev/null", O_RDONLY);
}

/// A line on standard error; if that cannot be written, there is nobody to tell.
void say(const std::string& text) { std::fputs(text.c_str(), stderr); }

using mechanics::most_steps;
constexpr int cells_across = 24;  // of a stability map

/// What the command line asks for, beside the scene's parameters.
struct Request {
  measure::RunOptions run;
  bool integrator_given = false, step_given = false;
  std::optional<mechanics::Stabilization> stabilization;
  mechanics::Stabilization unless_given = mechanics::Stabilization::none;
  std::optional<double> ks, kd, tolerance;
  bool strict = false;
  std::string out = ".";
  Snapshot snapshot;
};

/// The unit as --help shows it; in ASCII, since CLI11 aligns its columns by bytes.
std::string with_unit(std::string unit) {
  for (const auto& [sign, ascii] : {std::pair{"²", "^2"}, std::pair{"·", " "}})
    if (const std::size_t at = unit.find(sign); at != std::string::npos)
      unit.replace(at, std::string_view(sign).size(), ascii);
  return unit.empty() ? "X" : "[" + unit + "]";
}

CLI::Option* add_number(CLI::App& app, const std::string& option, const std::string& unit,
                        const std::string& help, Range allowed,
                        const std::function<void(double)>& take, bool only_whole = false) {
  return app
      .add_option_function<std::string>(
          option, [=](const std::string& text) { take(number(option, text, allowed, only_whole)); },
          help)
      ->type_name(with_unit(unit));
}

template <class Names>
[[noreturn]] void refuse_name(const std::string& option, const std::string& text,
                              const Names& names) {
  throw UsageError(fmt::format("{} {}: allowed is one of {}", option, text.empty() ? "''" : text,
                               fmt::join(names, ", ")));
}

std::vector<std::string_view> integrator_names() {
  std::vector<std::string_view> names;
  for (const auto& scheme : integrators::schemes) names.push_back(scheme.text);
  return names;
}

void add_scene(CLI::App& app, const Chapter& chapter) {
  for (const Parameter& parameter : chapter.parameters)
    add_number(
        app, parameter.option, parameter.unit,
        fmt::format("{} (default {:g})", parameter.help, *parameter.value), parameter.allowed,
        [value = parameter.value](double number) { *value = number; }, parameter.is(whole))
        ->group("Scene");
}

void add_method(CLI::App& app, const Chapter& chapter, Request& request,
                std::string_view usual = "none") {
  app.add_option_function<std::string>(
         "--integrator",
         [&request](const std::string& text) {
           const auto name = integrators::find(text);
           if (!name) refuse_name("--integrator", text, integrator_names());
           request.run.method.integrator = *name;
           request.integrator_given = true;
         },
         fmt::format("{} (default {})", fmt::join(integrator_names(), ", "),
                     integrators::info(chapter.defaults.method.integrator).text))
      ->type_name("NAME")
      ->group("Method");
  // A scene without constraints has nothing to stabilize.
  const std::vector<std::string_view> stabilizations(
      std::begin(mechanics::stabilization_names),
      chapter.has_constraints ? std::end(mechanics::stabilization_names)
                              : std::begin(mechanics::stabilization_names) + 1);
  app.add_option_function<std::string>(
         "--stabilization",
         [&request, stabilizations](const std::string& text) {
           const auto found = std::find(stabilizations.begin(), stabilizations.end(), text);
           if (found == stabilizations.end()) refuse_name("--stabilization", text, stabilizations);
           request.stabilization =
               static_cast<mechanics::Stabilization>(found - stabilizations.begin());
         },
         chapter.has_constraints
             ? fmt::format("none, feedback, projection (default {}; feedback when --ks or --kd is "
                           "given)",
                           usual)
             : "none: this scene has no constraint to stabilize")
      ->type_name("NAME")
      ->group("Method");
  const Range gains = chapter.has_constraints ? not_negative : Range{0.0, 0.0};
  add_number(app, "--ks", "1/s²", "feedback of C (default kd²/4, or 100)", gains,
             [&request](double ks) { request.ks = ks; })
      ->group("Method");
  add_number(app, "--kd", "1/s", "feedback of dC/dt (default 2√ks: critical damping)", gains,
             [&request](double kd) { request.kd = kd; })
      ->group("Method");
}

void add_tolerance(CLI::App& app, Request& request) {
  add_number(app, "--tolerance", "",
             "dop853 chooses its own steps, each with an error of at most this part of the state, "
             "1e-14 to 0.1; --step is then the longest, by default a fiftieth of --duration",
             {mechanics::finest_tolerance, mechanics::coarsest_allowed},
             [&request](double tolerance) { request.tolerance = tolerance; })
      ->group("Method");
}

/// What the default step is good for.
std::string step_help(const Chapter& chapter) {
  return fmt::format(
      "step of the integrator (default {:g}{}: keeps the energy to 1 % over {:g} s{})",
      chapter.defaults.step, chapter.fastest ? ", less in a faster scene" : "",
      chapter.defaults.duration, chapter.has_constraints ? ", with projection" : "");
}

void add_times(CLI::App& app, Request& request, const std::string& step_help) {
  add_number(app, "--duration", "s",
             fmt::format("time simulated (default {:g})", request.run.duration), positive,
             [&request](double s) { request.run.duration = s; })
      ->group("Method");
  add_number(app, "--step", "s", step_help, positive, [&request](double s) {
    request.run.step = s;
    request.step_given = true;
  })->group("Method");
}

void add_strict(CLI::App& app, Request& request) {
  app.add_flag("--strict", request.strict,
               "ends with status 1 where the run is far from right, which is a warning else")
      ->group("Output");
}

void add_out(CLI::App& app, Request& request) {
  app.add_option("--out", request.out, "folder for the files, made if missing (default: this one)")
      ->type_name("DIR")
      ->group("Output");
}

/// "4x3": two whole numbers, which an error calls by their names.
std::pair<int, int> sides(const std::string& option, const std::string& text,
                          const std::array<std::string, 2>& names, Range width, Range height) {
  const std::size_t x = text.find('x');
  const auto side = [&](const std::string& digits, Range range) {
    try {
      return static_cast<int>(number("", digits, range, true));
    } catch (const UsageError&) {
      throw UsageError(fmt::format(
          "{} {}: allowed is {}x{}, {} from {:g} to {:g}, {} from {:g} to {:g}", option, text,
          names[0], names[1], names[0], width.low, width.high, names[1], height.low, height.high));
    }
  };
  return {side(text.substr(0, x), width),
          side(x == std::string::npos ? "" : text.substr(x + 1), height)};
}

void add_page(CLI::App& app, Request& request) {
  add_out(app, request);
  app.add_option_function<std::string>(
         "--size",
         [&request](const std::string& text) {
           std::tie(request.snapshot.page.width, request.snapshot.page.height) =
               sides("--size", text, {"W", "H"}, {480.0, 4000.0}, {300.0, 4000.0});
         },
         "size in points (default 960x600)")
      ->type_name("WxH")
      ->group("Output");
  add_number(app, "--scale", "", "pixels in a point (default 2)", Range{0.5, 4.0},
             [&request](double scale) { request.snapshot.page.scale = scale; })
      ->type_name("X")
      ->group("Output");
  app.add_option_function<std::string>(
         "--theme",
         [&request](const std::string& text) {
           if (text != "light" && text != "dark")
             refuse_name("--theme", text, std::vector<std::string>{"light", "dark"});
           request.snapshot.page.theme = draw::theme(text);
         },
         "light (for print, the default) or dark")
      ->type_name("NAME")
      ->group("Output");
  app.add_option_function<std::string>(
         "--at",
         [&request](const std::string& texts) {
           std::size_t from = 0;
           while (from <= texts.size()) {
             const std::size_t comma = std::min(texts.find(',', from), texts.size());
             request.snapshot.at.push_back(
                 number("--at", texts.substr(from, comma - from), not_negative));
             from = comma + 1;
           }
           auto& at = request.snapshot.at;
           std::sort(at.begin(), at.end());
           at.erase(std::unique(at.begin(), at.end()), at.end());
         },
         "the scene at these times, at the nearest step, instead of the lesson's pictures")
      ->type_name("T[,T...] [s]")
      ->group("Output");
  add_number(
      app, "--frames", "", "a numbered series: so many pictures from t = 0", {1.0, 1e5},
      [&request](double frames) { request.snapshot.frames = std::lround(frames); }, true)
      ->type_name("N")
      ->group("Output");
  add_number(app, "--fps", "1/s", "how many of the series show a second (default 25)",
             {0.001, 1000.0}, [&request](double fps) { request.snapshot.fps = fps; })
      ->group("Output");
  app.add_option_function<std::string>(
         "--sheet",
         [&request](const std::string& text) {
           std::tie(request.snapshot.sheet_columns, request.snapshot.sheet_rows) =
               sides("--sheet", text, {"COLS", "ROWS"}, {1.0, 20.0}, {1.0, 20.0});
         },
         "small scenes on one page, at equal times up to --duration, or at those of --at")
      ->type_name("COLSxROWS")
      ->group("Output");
}

/// What was asked for, made whole: the gains that go together, and the limits that hold between
/// options.
void settle(Request& request) {
  measure::RunOptions& run = request.run;
  const bool gains = request.ks.value_or(0.0) > 0.0 || request.kd.value_or(0.0) > 0.0;
  const mechanics::Stabilization usual =
      request.ks || request.kd ? mechanics::Stabilization::none : request.unless_given;
  run.method.stabilization =
      request.stabilization.value_or(gains ? mechanics::Stabilization::feedback : usual);
  if (run.method.stabilization == mechanics::Stabilization::feedback) {
    run.method.ks = request.ks.value_or(request.kd ? *request.kd * *request.kd / 4.0 : 100.0);
    run.method.kd = request.kd.value_or(2.0 * std::sqrt(run.method.ks));
  } else if (gains) {
    throw UsageError(fmt::format("--{} {:g}: allowed only with --stabilization feedback",
                                 request.ks ? "ks" : "kd", request.ks ? *request.ks : *request.kd));
  }
  if (request.tolerance) {
    if (run.method.integrator != integrators::Scheme::dop853)
      throw UsageError(fmt::format("--tolerance {:g}: allowed only with --integrator dop853",
                                   *request.tolerance));
    run.method.tolerance = *request.tolerance;
    if (!request.step_given) run.step = run.duration / 50.0;
  }
  if (run.duration / run.step > most_steps)
    throw UsageError(
        fmt::format("--step {:g}: allowed is {:g} or more, for at most {:g} steps in {:g} s",
                    run.step, run.duration / most_steps, most_steps, run.duration));
  if (run.every != 0.0 && run.every < run.step)
    throw UsageError(
        fmt::format("--every {:g}: allowed is the step, {:g} s, or more", run.every, run.step));
}

/// Once, when the feedback itself is unstable at this step.
void warn_of_gains(const measure::RunOptions& run) {
  if (const auto fault = fault_of_gains(run)) say(fmt::format("warning: {}\n", *fault));
}

// ----------------------------------------------------------------------------------------------
// run

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

bool is_finite(const mechanics::Row& row) {
  const auto all = [](const std::vector<double>& values) {
    return std::all_of(values.begin(), values.end(),
                       [](double value) { return std::isfinite(value); });
  };
  return all(row.state) && all(row.reactions);
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
    if (!std::isfinite(error))
      throw mechanics::Diverged(mechanics::at(last.t) + "the error is no longer finite");
  finished.largest.energy_error = watch.largest_energy_error();  // counts from a closed start
  finished.verdict = measure::judge(watch, chapter.quantities, finished.errors);
  if (!finished.verdict.right()) {
    const std::string text = fmt::format("{}; try {}", finished.verdict.text(),
                                         advice(chapter, run, finished.verdict.trouble()));
    if (request.strict) throw FarFromRight(text);
    say(fmt::format("warning: {}\n", text));
  }
  return finished;
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

// -------------------------------------------------------------------------------------------
// report

void prepare_folder(const std::string& out) {
  try {
    files::make_folder(out);
  } catch (const std::runtime_error& error) {
    throw UsageError(
        fmt::format("--out {}: {}; allowed is a folder that can be written", out, error.what()));
  }
}

void report_command(const Chapter& chapter, const Request& request) {
  if (chapter.before_report) chapter.before_report();
  prepare_folder(request.out);
  mechanics::Row end = chapter.start({})->row();
  end.t = request.run.duration;  // where the errors will be asked for
  if (chapter.errors(end).empty())
    throw UsageError(
        "report: allowed are scenes with an exact answer; none is computed for this one");
  measure::Ladder ladder = chapter.ladder;
  ladder.duration = request.run.duration;
  ladder.coarsest = request.run.step;
  ladder.quantities = chapter.quantities;
  if (request.integrator_given || request.stabilization || request.ks || request.kd)
    ladder.methods = {request.run.method};
  if (ladder.duration / ladder.coarsest > static_cast<double>(ladder.most_steps >> 7))
    throw UsageError(fmt::format(
        "--step {:g}: allowed is {:.3g} s or more, so that 8 halvings stay below {} steps",
        ladder.coarsest, ladder.duration / static_cast<double>(ladder.most_steps >> 7),
        ladder.most_steps));
  measure::Report report{chapter.title,      ladder.duration,    chapter.constraint_unit,
                         chapter.quantities, measure::machine(), {},
                         chapter.remark};
  {
    files::Progress progress;
    report.rungs =
        measure::climb(ladder, chapter.start, chapter.errors,
                       [&](double done, const std::string& what) { progress.show(done, what); });
  }
  fmt::print("{}", measure::table(report));
  const std::filesystem::path out(request.out);
  fmt::print("\n");
  const auto write = [](const std::filesystem::path& path, const std::string& content) {
    files::write_file(path, content);
    fmt::print("{}\n", path.string());
  };
  write(out / "error_vs_time.csv", measure::csv(report));
  // Drawn from the file, digit for digit, as whoever draws it later will.
  const pictures::Picture picture =
      pictures::error_picture(measure::read_csv(out / "error_vs_time.csv"));
  write(out / "error_vs_time.png", draw::encode_png(draw::render({}, picture.draw)));
  if (chapter.also_report) chapter.also_report(out);
}

// -----------------------------------------------------------------------------------------
// stability

/// Whatever the chapter: no parameter takes what it does not allow.
measure::Case bad_input(const Chapter& chapter) {
  return {"bad input, each of the scene's parameters", "taken although not allowed",
          measure::accurate(0.0), [parameters = chapter.parameters] {
            double taken = 0.0;
            for (const Parameter& parameter : parameters)
              for (const std::string& text :
                   {std::string("nan"), std::string("inf"), std::string("1e400"), std::string("x"),
                    fmt::format("{:g}", 2.0 * parameter.allowed.high + 1.0),
                    fmt::format("{:g}", -1.0 - 2.0 * std::abs(parameter.allowed.low))}) {
                try {
                  number(parameter.option, text, parameter.allowed, parameter.is(whole));
                  taken += 1.0;
                } catch (const UsageError&) {
                }
              }
            return taken;
          }};
}

void stability_command(const Chapter& chapter, const Request& request) {
  prepare_folder(request.out);
  measure::Stability stability = chapter.stability();
  stability.cases.push_back(bad_input(chapter));
  std::vector<measure::CaseResult> verdicts;
  std::vector<measure::Map> maps;
  std::vector<measure::LongCurve> curves;
  {
    files::Progress progress;
    for (const measure::Case& trial : stability.cases) {
      progress.show(
          0.3 * static_cast<double>(verdicts.size()) / static_cast<double>(stability.cases.size()),
          trial.name);
      verdicts.push_back(measure::judge(trial));
    }
    for (const measure::Plan& plan : stability.plans) {
      const double before = 0.3 + 0.4 * static_cast<double>(maps.size()) / 5.0;
      maps.push_back(
          measure::measure_map(plan, cells_across, [&](double done, const std::string& what) {
            progress.show(before + 0.08 * done, "map of " + what);
          }));
      verdicts.push_back(measure::judge(maps.back()));
    }
    const measure::LongRun& run = stability.long_run;
    for (const measure::LongMethod& method : run.methods) {
      progress.show(
          0.7 + 0.3 * static_cast<double>(curves.size()) / static_cast<double>(run.methods.size()),
          "long run of " + method.method.label());
      curves.push_back(measure::long_run(*run.start(method.method), method, run.steps, run.step));
    }
  }
  const std::filesystem::path out(request.out);
  const auto write = [](const std::filesystem::path& path, const std::string& content) {
    files::write_file(path, content);
    fmt::print("{}\n", path.string());
  };
  fmt::print("{}: stability\n\n{}\n", chapter.title, measure::table(verdicts));
  if (!curves.empty())
    fmt::print("{} steps of {:g} s\n{}\n", stability.long_run.steps, stability.long_run.step,
               measure::table(curves));
  write(out / "stability.csv", measure::csv(verdicts));
  write(out / "stability_map.csv", measure::csv(maps));
  if (!curves.empty()) write(out / "long_run.csv", measure::csv(curves));
  const auto draw_picture = [&](const pictures::Picture& picture) {
    write(out / (picture.name + ".png"), draw::encode_png(draw::render({}, picture.draw)));
  };
  draw_picture(pictures::map_picture(maps, stability.map_remark));
  if (!curves.empty()) draw_picture(pictures::long_run_picture(curves, stability.long_run.step));
  const auto unexpected =
      std::count_if(verdicts.begin(), verdicts.end(),
                    [](const measure::CaseResult& v) { return !v.as_expected; });
  if (unexpected > 0)
    throw std::runtime_error(fmt::format("{} of {} cases did not end as expected; see the table",
                                         unexpected, verdicts.size()));
}

// -----------------------------------------------------------------------------------------
// snapshot

void snapshot_command(const Chapter& chapter, const Request& request) {
  request.snapshot.check(request.run, most_steps);
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

constexpr const char* window_help =
    R"(Keys: space runs and pauses (the window opens at rest), right arrow or s takes one
step, r goes back to the start (and runs on, if it ran), Escape closes. Unless you choose
otherwise the window starts with projection, and with a step that follows the scene.

At the right stand the speed, the scene's parameters, the step, the integrator, the
stabilization and its gains, and what is shown besides the bodies: constraint forces,
trail, names. What changes loads, masses or the method acts on the motion as it is;
everything else starts the scene again. A click with the control key lets you type a
slider's value, and Enter takes it.

Drag a body with the mouse: it follows through a soft, damped spring, whose force
stands beside the pointer. Below the scene run the energy error and the constraint
error. The simulated time follows the wall clock, at a speed of 1, whatever the frame
rate; where it cannot, or where a run diverges or is far from right, the window says
so. A joint that has opened is drawn with its gap, in red.

Each action is a line on standard output with its time, and closing adds what a frame
and a step took. Without a display there is the command snapshot.)";

/// "--force-x -5" reads as an option and an option; joined as "--force-x=-5" it reads as meant.
std::vector<std::string> join_negative_numbers(int argc, char** argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  for (std::size_t i = 0; i + 1 < arguments.size(); ++i) {
    const std::string& next = arguments[i + 1];
    if (arguments[i].starts_with("--") && arguments[i].size() > 2 &&
        arguments[i].find('=') == std::string::npos && next.size() > 1 && next[0] == '-' &&
        next[1] != '-') {
      arguments[i] += "=" + next;
      arguments.erase(arguments.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    }
  }
  return arguments;
}

/// Without line breaks and other control characters, and not longer than a screen.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; }, ' ');
  while (text.ends_with(' ')) text.pop_back();
  constexpr std::size_t most = 600;
  return text.size() <= most ? text : text.substr(0, most) + " ...";
}

}  // namespace

double default_step(const Chapter& chapter, double duration) {
  constexpr double angle = 0.1, most = 1e6;  // rad a step, steps
  const double step = chapter.defaults.step;
  if (!chapter.fastest) return step;
  return std::min(step, std::max(angle / chapter.fastest(), duration / most));
}

int run_chapter(int argc, char** argv, const Chapter& chapter) {
  open_standard_streams();
  Request request;
  request.run = chapter.defaults;
  Request ladder_request = request;
  ladder_request.run.duration = chapter.ladder.duration;
  ladder_request.run.step = chapter.ladder.coarsest;

  CLI::App app(chapter.title, chapter.directory);
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);

  CLI::App* run =
      app.add_subcommand("run", "one simulation and its error against the exact answer");
  add_scene(*run, chapter);
  add_method(*run, chapter, request);
  add_tolerance(*run, request);
  add_times(*run, request, step_help(chapter));
  run->add_option_function<std::string>(
         "--csv",
         [&request](const std::string& name) {
           if (name.empty())
             throw UsageError(
                 "--measure::csv '': allowed is a file name, or - for standard output");
           request.run.csv = name;
         },
         "writes the trajectory; - writes it to standard output, alone")
      ->type_name("FILE")
      ->group("Output");
  add_number(
      *run, "--every", "s",
      "time between rows: a row at the first step at or after each multiple (default: every step)",
      positive, [&](double s) { request.run.every = s; })
      ->group("Output");
  add_strict(*run, request);
  const auto settle_step = [&] {
    if (!request.step_given) request.run.step = default_step(chapter, request.run.duration);
  };
  run->callback([&] {
    settle_step();
    settle(request);
    run_command(chapter, request);
  });

  if (chapter.pictures) {
    CLI::App* snapshot = app.add_subcommand("snapshot", "PNG pictures of the scene");
    add_scene(*snapshot, chapter);
    add_method(*snapshot, chapter, request);
    add_tolerance(*snapshot, request);
    add_times(*snapshot, request, step_help(chapter));
    add_page(*snapshot, request);
    add_strict(*snapshot, request);
    snapshot->callback([&] {
      settle_step();
      settle(request);
      snapshot_command(chapter, request);
    });
  }

  bool controls = false;
  if (live != nullptr && chapter.stage) {
    CLI::App* window = app.add_subcommand(
        "live",
        "the scene in a window: space runs and pauses, right arrow or s takes a step, r goes back");
    add_scene(*window, chapter);
    add_method(*window, chapter, request, "projection");
    add_times(*window, request, step_help(chapter));
    window->add_flag("--controls", controls, "prints where each control stands, for scripts")
        ->group("Output");
    window->footer(window_help);
    window->callback([&] {
      settle_step();
      if (chapter.has_constraints) request.unless_given = mechanics::Stabilization::projection;
      settle(request);
      warn_of_gains(request.run);
      live(chapter, request.run, request.step_given, controls);
    });
  }

  CLI::App* report = app.add_subcommand(
      "report", "error against run time: a table, error_vs_time.csv and error_vs_time.png");
  add_scene(*report, chapter);
  add_method(*report, chapter, ladder_request);
  add_tolerance(*report, ladder_request);
  add_times(*report, ladder_request,
            fmt::format("coarsest step, halved from row to row; three times as long for dop853 "
                        "(default {:g})",
                        chapter.ladder.coarsest));
  add_out(*report, ladder_request);
  report->callback([&] {
    settle(ladder_request);
    report_command(chapter, ladder_request);
  });

  if (chapter.stability) {
    CLI::App* stability =
        app.add_subcommand("stability", "the stiff and extreme cases: tables as CSV, maps as PNG");
    add_out(*stability, request);
    stability->callback([&] { stability_command(chapter, request); });
  }

  const auto complain = [&](const std::string& message, int status) {
    say(fmt::format("{}: {}\n", chapter.directory, one_line(message)));
    return status;
  };
  try {
    std::vector<std::string> arguments = join_negative_numbers(argc, argv);
    std::vector<std::string> commands;
    for (const CLI::App* command : app.get_subcommands({})) commands.push_back(command->get_name());
    if (arguments.empty()) refuse_name("command", "missing", commands);
    if (!arguments[0].starts_with('-') &&
        std::find(commands.begin(), commands.end(), arguments[0]) == commands.end())
      refuse_name("command", arguments[0], commands);
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants a vector
    app.parse(arguments);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help
      app.exit(error);
      return std::fflush(stdout) == 0 ? 0 : complain("cannot write standard output", 1);
    }
    return complain(std::string(error.what()) + "; see --help", 2);
  } catch (const UsageError& error) {
    return complain(error.what(), 2);
  } catch (const std::invalid_argument& error) {  // a scene's own, which knows no options
    const std::string text = error.what(), first = "--" + text.substr(0, text.find(' '));
    const bool option = std::any_of(chapter.parameters.begin(), chapter.parameters.end(),
                                    [&](const Parameter& p) { return p.option == first; });
    return complain(option ? "--" + text : text, 2);
  } catch (const mechanics::Diverged& diverged) {
    return complain(fmt::format("stopped {}; try {}", diverged.what(),
                                advice(chapter, request.run, diverged.trouble)),
                    1);
  } catch (const std::exception& error) {
    return complain(error.what(), 1);
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    return complain("cannot write standard output", 1);
  return 0;
}

}  // namespace app
