// The commands that measure: report and stability.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/commands.hpp"
#include "instruments/draw/image.hpp"
#include "instruments/files/files.hpp"
#include "instruments/files/progress.hpp"
#include "instruments/measure/report.hpp"
#include "instruments/pictures/stability_pictures.hpp"

namespace app {
namespace {

constexpr int cells_across = 24;  // of a stability map

void write(const std::filesystem::path& path, const std::string& content) {
  files::write_file(path, content);
  fmt::print("{}\n", path.string());
}

void write(const std::filesystem::path& folder, const pictures::Picture& picture,
           const draw::Page& page) {
  write(folder / (picture.name + ".png"), draw::encode_png(draw::render(page, picture.draw)));
}

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
                  number(parameter.option, text, parameter.allowed, parameter.is_whole());
                  taken += 1.0;
                } catch (const UsageError&) {
                }
              }
            return taken;
          }};
}

}  // namespace

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
  const bool one_method =
      request.integrator_given || request.stabilization || request.ks || request.kd;
  if (one_method) ladder.methods = {request.run.method};
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
    const auto& [start, errors, methods] = chapter.one_coordinate;
    const double part = start && !one_method ? 0.9 : 1.0;
    report.rungs = measure::climb(
        ladder, chapter.start, chapter.errors,
        [&](double done, const std::string& what) { progress.show(part * done, what); });
    if (part < 1.0) {
      ladder.methods = methods;
      for (measure::Rung& rung :
           measure::climb(ladder, start, errors, [&](double done, const std::string&what) {
             progress.show(part + (1.0 - part) * done, measure::one_coordinate + what);
           })) {
        rung.method = measure::one_coordinate + rung.method;
        report.rungs.push_back(rung);
      }
    }
  }
  fmt::print("{}", measure::table(report));
  const std::filesystem::path out(request.out);
  fmt::print("\n");
  write(out / "error_vs_time.csv", measure::csv(report));
  // Drawn from the file, digit for digit, as whoever draws it later will.
  write(out, pictures::error_picture(measure::read_csv(out / "error_vs_time.csv")),
        request.snapshot.page);
  if (chapter.also_report && !one_method) chapter.also_report(out);
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
  fmt::print("{}: stability\n\n{}\n", chapter.title, measure::table(verdicts));
  if (!curves.empty())
    fmt::print("{} steps of {:g} s\n{}\n", stability.long_run.steps, stability.long_run.step,
               measure::table(curves));
  write(out / "stability.csv", measure::csv(verdicts));
  write(out / "stability_map.csv", measure::csv(maps));
  if (!curves.empty()) write(out / "long_run.csv", measure::csv(curves));
  const draw::Page& page = request.snapshot.page;
  write(out, pictures::map_picture(chapter.title, maps, stability.map_remark), page);
  if (!curves.empty())
    write(out, pictures::long_run_picture(chapter.title, curves, stability.long_run.step), page);
  const auto unexpected =
      std::count_if(verdicts.begin(), verdicts.end(),
                    [](const measure::CaseResult& v) { return !v.as_expected; });
  if (unexpected > 0)
    throw std::runtime_error(fmt::format("{} of {} cases did not end as expected; see the table",
                                         unexpected, verdicts.size()));
}

}  // namespace app
