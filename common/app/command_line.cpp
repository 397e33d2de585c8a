#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "app/advice.hpp"
#include "app/commands.hpp"
#include "app/live.hpp"

namespace app {
namespace {

using mechanics::most_steps;

/// A stream that was closed would lend its number to the next file or to the display, which would
/// then be written into. Reading alone makes writing fail, as it did before.
void open_standard_streams() {
  for (int stream = 0; stream <= 2; ++stream)
    if (fcntl(stream, F_GETFD) == -1) open("/dev/null", O_RDONLY);
}

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

[[noreturn]] void refuse_name(const std::string& option, const std::string& text,
                              const std::vector<std::string>& names) {
  throw UsageError(fmt::format("{} {}: allowed is one of {}", option, text.empty() ? "''" : text,
                               fmt::join(names, ", ")));
}

/// One of some names; takes which.
CLI::Option* add_name(CLI::App& app, const std::string& option,
                      const std::vector<std::string>& names, const std::string& help,
                      const std::function<void(std::size_t)>& take) {
  return app
      .add_option_function<std::string>(
          option,
          [=](const std::string& text) {
            const auto found = std::find(names.begin(), names.end(), text);
            if (found == names.end()) refuse_name(option, text, names);
            take(static_cast<std::size_t>(found - names.begin()));
          },
          help)
      ->type_name("NAME");
}

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  for (const auto& scheme : integrators::schemes) names.emplace_back(scheme.text);
  return names;
}

void add_scene(CLI::App& app, const Chapter& chapter) {
  std::vector<std::string> names, meanings;
  std::vector<const Parameter*> switches;
  for (const Parameter& parameter : chapter.parameters) {
    if (parameter.option.starts_with(without)) {
      names.push_back(parameter.option.substr(without.size()));
      meanings.push_back(parameter.help);
      switches.push_back(&parameter);
      continue;
    }
    add_number(
        app, parameter.option, parameter.unit,
        fmt::format("{} (default {:g})", parameter.help, parameter.value()), parameter.allowed,
        [&parameter](double number) { parameter.set(number); }, parameter.is_whole())
        ->group("Scene");
  }
  for (const Text& text : chapter.texts)
    if (text.names.empty())
      app.add_option(text.option, *text.place, text.help)->type_name(text.form)->group("Scene");
    else
      add_name(
          app, text.option, text.names,
          fmt::format("{}: {} (default {})", fmt::join(text.names, ", "), text.help, *text.place),
          [&text](std::size_t which) { *text.place = text.names[which]; })
          ->group("Scene");
  if (names.empty()) return;
  add_name(app, "--without", names,
           fmt::format("{}: left out, to see what fails ({})", fmt::join(names, ", "),
                       fmt::join(meanings, "; ")),
           [switches](std::size_t which) { switches[which]->set(1.0); })
      ->group("Scene");
}

void add_method(CLI::App& app, const Chapter& chapter, Request& request,
                std::string_view usual = "none") {
  add_name(app, "--integrator", integrator_names(),
           fmt::format("{} (default {})", fmt::join(integrator_names(), ", "),
                       integrators::info(chapter.defaults.method.integrator).text),
           [&request](std::size_t which) {
             request.run.method.integrator = integrators::schemes[which].id;
             request.integrator_given = true;
           })
      ->group("Method");
  // A scene without constraints has nothing to stabilize.
  const auto* names = mechanics::stabilization_names;
  add_name(
      app, "--stabilization",
      {names, chapter.has_constraints ? std::end(mechanics::stabilization_names) : names + 1},
      chapter.has_constraints
          ? fmt::format("none, feedback, projection (default {}; feedback when --ks or --kd is "
                        "given)",
                        usual)
          : "none: this scene has no constraint to stabilize",
      [&request](std::size_t which) {
        request.stabilization = static_cast<mechanics::Stabilization>(which);
      })
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
  app.add_flag_callback(
         "--no-caption", [&request] { request.snapshot.page.captions = false; },
         "pictures without the sentence under them, which snapshot prints all the same")
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
  add_name(app, "--theme", {"light", "dark"}, "light (for print, the default) or dark",
           [&request](std::size_t which) {
             request.snapshot.page.theme = draw::theme(which == 0 ? "light" : "dark");
           })
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
             throw UsageError("--csv '': allowed is a file name, or - for standard output");
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
    const auto named = [&](const auto& p) { return p.option == first; };
    const bool option = std::any_of(chapter.parameters.begin(), chapter.parameters.end(), named) ||
                        std::any_of(chapter.texts.begin(), chapter.texts.end(), named);
    return complain(option ? "--" + text : text, 2);
  } catch (const mechanics::Diverged& diverged) {
    return complain(fmt::format("stopped {}; {}", diverged.what(),
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
