#include "instruments/measure/cases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "instruments/files/table.hpp"

namespace measure {
namespace {

using Outcome = Expected::Outcome;

constexpr char separator = ';';  // of the files: names of cases hold commas

std::string text(const Expected& expected) {
  switch (expected.outcome) {
    case Outcome::accurate:
      return fmt::format("accurate to {:g}", expected.most);
    case Outcome::degraded:
      return fmt::format("degraded, {:g} to {:g}", expected.least, expected.most);
    case Outcome::refused:
      break;
  }
  return "refused";
}

bool fits(const Expected& expected, double figure) {
  return expected.outcome != Outcome::refused && figure >= expected.least &&
         figure <= expected.most;
}

constexpr std::size_t widest_found = 120;

/// What a table has room for; the whole stands in the CSV.
std::string shortened(const std::string& found) {
  const std::string first = found.substr(0, found.find(';'));
  return first.size() <= widest_found ? first : first.substr(0, widest_found - 3) + "...";
}

/// The unit of a column by its name: places, velocities, angles, rates, forces, moments.
struct Kind {
  std::string name;
  double factor;  ///< from the first units to the second
};
Kind kind(const std::string& column, const Units& in) {
  const auto ends = [&](const char* end) { return column.ends_with(end); };
  const double speed = in.length / in.time, force = in.mass * speed / in.time;
  if (ends(".theta")) return {"angle", 1.0};
  if (ends(".omega")) return {"rate", 1.0 / in.time};
  if (ends(".vx") || ends(".vy") || ends("qdot")) return {"velocity", speed};
  if (ends(".fx") || ends(".fy")) return {"force", force};
  if (ends(".moment")) return {"moment", force * in.length};
  return {"place", in.length};
}

/// How far the rows of two simulations differ, each kind of column as a part of its largest value.
double difference(const Units& units, mechanics::Simulation& first, mechanics::Simulation& second) {
  const mechanics::Row a = first.row(), b = second.row();
  const mechanics::Columns columns = first.columns();
  std::map<std::string, std::pair<double, double>> worst;  // difference and size, kind by kind
  const auto compare = [&](const std::vector<std::string>& names, const std::vector<double>& x,
                           const std::vector<double>& y) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const Kind k = kind(names[i], units);
      auto& [off, size] = worst[k.name];
      off = std::max(off, std::abs(y[i] - k.factor * x[i]));
      size = std::max(size, std::abs(y[i]));
    }
  };
  compare(columns.state, a.state, b.state);
  compare(columns.reactions, a.reactions, b.reactions);
  double largest = 0.0;
  for (const auto& [name, values] : worst)
    if (values.first > 0.0) largest = std::max(largest, values.first / values.second);
  return largest;
}

}  // namespace

CaseResult judge(const Case& trial) {
  const auto verdict = [&](const std::string& found, bool as_expected) {
    return CaseResult{trial.name, trial.figure, text(trial.expected), found, as_expected};
  };
  try {
    const double figure = trial.run();
    return verdict(fmt::format("{:.2g}", figure), fits(trial.expected, figure));
  } catch (const std::exception& error) {
    const std::string message = error.what();
    return verdict(message, trial.expected.outcome == Outcome::refused &&
                                message.find(trial.expected.message) != std::string::npos);
  }
}

CaseResult judge(const measure::Map& map) {
  const int differing = map.compared() - map.agreeing();
  const Expected expected = accurate(map.plan.differing);
  return {fmt::format("map of {}, {} cells compared", map.plan.title(), map.compared()),
          "cells that differ from theory", text(expected), fmt::format("{}", differing),
          fits(expected, differing)};
}

std::function<double()> drift(const measure::Start& start, const mechanics::Method& method,
                              long steps, double h) {
  return [=] { return measure::run_and_watch(*start(method), steps, h).constraint_error; };
}

std::function<double()> energy_error(const measure::Start& start, const mechanics::Method& method,
                                     long steps, double h) {
  return [=] { return measure::run_and_watch(*start(method), steps, h).energy_part(); };
}

std::function<double()> final_error(const measure::Start& start, const measure::Errors& errors,
                                    std::size_t quantity, const mechanics::Method& method,
                                    long steps, double h) {
  return [=] {
    const auto simulation = start(method);
    measure::run_and_watch(*simulation, steps, h);
    return errors(simulation->row()).at(quantity);
  };
}

void Stability::add_feedback(const measure::Start& start, const measure::FeedbackTrial& trial) {
  // At critical damping both roots are one, so that what the motion changes in a step and what C
  // has of second order move the limit by their square roots: hence less of both.
  measure::FeedbackTrial finer = trial;
  finer.step *= 1e-3;
  finer.nudge *= 1e-4;
  finer.steps *= 4;
  for (const auto& scheme : integrators::schemes) {
    const double limit = measure::theoretical_limit(scheme.id);
    const std::string name = limit < 8.0
                                 ? fmt::format("{}: feedback limit s = {:.4g}", scheme.text, limit)
                                 : fmt::format("{}: feedback at any s (to 8)", scheme.text);
    cases.push_back({name, "limit found, off theory's", accurate(0.01), [=, name = scheme.id] {
                       const double found = measure::measured_limit(name, start, finer);
                       return std::abs(found / limit - 1.0);
                     }});
  }
  plans = measure::feedback_plans(start, trial);
}

void Stability::add_units(const std::function<measure::Start(const Units&)>& scene_in,
                          const std::vector<mechanics::Method>& methods, long steps, double h) {
  for (const mechanics::Method& method : methods)
    cases.push_back(
        {"in µm and in Mm, ms: " + method.label(), "difference, relative", accurate(1e-12), [=] {
           double largest = 0.0;
           for (const Units& units : {Units{1e6, 1.0, 1e8}, Units{1e-6, 1e3, 1.0}}) {
             mechanics::Method scaled = method;
             scaled.ks /= units.time * units.time;
             scaled.kd /= units.time;
             const auto here = scene_in({1.0, 1.0, 1.0})(method), there = scene_in(units)(scaled);
             here->advance(steps, h);
             there->advance(steps, h * units.time);
             largest = std::max(largest, difference(units, *here, *there));
           }
           return largest;
         }});
}

std::string table(const std::vector<CaseResult>& verdicts) {
  files::Table table({"case", "measured", "expected", "found"});
  long unexpected = 0;
  for (const CaseResult& v : verdicts) {
    table.add(v.name, v.figure, v.expected,
              shortened(v.found) + (v.as_expected ? "" : "   NOT AS EXPECTED"));
    unexpected += v.as_expected ? 0 : 1;
  }
  return table.text({-50, -34, -26}) +
         fmt::format("{} cases, {} not as expected\n", verdicts.size(), unexpected);
}

std::string table(const std::vector<measure::LongCurve>& curves) {
  files::Table table(
      {"energy over a long run", "at the end, relative", "grows as t^", "  which is"});
  for (const measure::LongCurve& curve : curves) {
    if (!curve.failure.empty()) {
      table.add(curve.method, "  failed: " + curve.failure);
      continue;
    }
    const bool lost = !curve.bounded() && curve.exponent() < 0.25;
    const std::string which = curve.bounded() ? "bounded"
                              : lost          ? "no longer the motion"
                                              : "growing";
    table.add(curve.method, fmt::format("{:.2e}", curve.looks.back().energy_error),
              lost ? "" : fmt::format("{:.2f}", curve.exponent()),
              fmt::format("  {}{}", which,
                          curve.bounded() == curve.expected_bounded ? "" : ": NOT AS EXPECTED"));
  }
  return table.text({-32, 24, 16});
}

std::string csv(const std::vector<CaseResult>& verdicts) {
  files::Table table({"case", "measured", "expected", "found", "as expected"});
  for (const CaseResult& v : verdicts)
    table.add(v.name, v.figure, v.expected, v.found, v.as_expected ? "yes" : "no");
  return table.csv(separator);
}

std::vector<CaseResult> read_verdicts(const std::filesystem::path& path) {
  std::vector<CaseResult> verdicts;
  const auto take = [&](const files::SavedRow& row) {
    verdicts.push_back(
        {row["case"], row["measured"], row["expected"], row["found"], row["as expected"] == "yes"});
  };
  files::read_csv(path, take, {}, separator);
  return verdicts;
}

std::string csv(const std::vector<measure::Map>& maps) {
  files::Table table({"integrator", "x", "y", "stable", "theory", "compared"});
  for (const measure::Map& map : maps)
    for (const measure::Cell& cell : map.cells)
      table.add(map.plan.title(), files::digits(cell.x), files::digits(cell.y), int{cell.stable},
                int{cell.theory}, int{cell.compared});
  return table.csv(separator);
}

std::string csv(const std::vector<measure::LongCurve>& curves) {
  files::Table table({"method", "expected", "t", "energy_error", "failure"});
  for (const measure::LongCurve& curve : curves) {
    const char* expected = curve.expected_bounded ? "bounded" : "growing";
    for (const auto& [t, error] : curve.looks)
      table.add(curve.method, expected, files::digits(t, 9), files::digits(error), "");
    if (!curve.failure.empty()) table.add(curve.method, expected, "", "", curve.failure);
  }
  return table.csv(separator);
}

std::vector<measure::LongCurve> read_curves(const std::filesystem::path& path) {
  std::vector<measure::LongCurve> curves;
  const auto take = [&](const files::SavedRow& row) {
    if (curves.empty() || curves.back().method != row["method"])
      curves.push_back({.method = row["method"], .expected_bounded = row["expected"] == "bounded"});
    if (row["failure"].empty())
      curves.back().looks.push_back({row.number("t"), row.number("energy_error")});
    else
      curves.back().failure = row["failure"];
  };
  files::read_csv(path, take, {}, separator);
  return curves;
}

}  // namespace measure
