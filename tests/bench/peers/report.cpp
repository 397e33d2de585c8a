#include "report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "instruments/files/table.hpp"

namespace peers {
namespace {

constexpr double levels[] = {1e-2, 1e-4, 1e-6, 1e-8, 1e-10};
const std::string dash = "–";

std::string number(double value) { return fmt::format("{:.3g}", value); }
/// A number of milliseconds or a ratio: three digits, never as a power of ten.
std::string plain(double value) {
  const int digits = value > 0 ? static_cast<int>(std::floor(std::log10(value))) : 0;
  return fmt::format("{:.{}f}", value, std::clamp(2 - digits, 0, 6));
}

std::string rung(const Row& row) {
  if (row.rung == Rung::accuracy) return fmt::format("accuracy {:.2g}", row.value);
  return row.value < 1e-3 ? fmt::format("step {:.3g} ms", 1e3 * row.value)
                          : fmt::format("step 1/{:.4g} s", 1 / row.value);
}

std::string heading(const std::vector<std::string>& machine) {
  std::string text;
  for (const std::string& line : machine) text += line + "\n";
  return text;
}

/// With a column for each level.
files::Table level_table() {
  files::Table table({""});
  for (const double level : levels) table.header().push_back(fmt::format("{:.0e}", level));
  return table;
}

/// The engines' names, and columns beside them.
std::string text(const files::Table& table) { return table.text({-18, 11, 11, 11, 11, 11}); }

std::vector<int> lengths(const std::vector<Row>& rows) {
  std::set<int> parts;
  for (const Row& row : rows) parts.insert(row.parts);
  return {parts.begin(), parts.end()};
}

/// The best run of an engine on one chain: the least error, or the least energy error where there
/// is no exact answer.
const Row* best(const std::vector<Row>& rows, const std::string& engine, int parts) {
  const Row* best = nullptr;
  const auto measure = [](const Row& row) { return row.error.value_or(row.energy_error); };
  for (const Row& row : rows)
    if (row.engine == engine && row.parts == parts && row.failure.empty())
      if (best == nullptr || measure(row) < measure(*best)) best = &row;
  return best;
}

}  // namespace

std::vector<std::string> names(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  for (const Row& row : rows)
    if (std::find(names.begin(), names.end(), row.engine) == names.end())
      names.push_back(row.engine);
  return names;
}

double lasting_error(const std::vector<Row>& rows, const Row& row) {
  double error = 0;
  for (const Row& other : rows)
    if (other.engine == row.engine && other.setting == row.setting && other.rung == row.rung &&
        other.value <= row.value && other.failure.empty())
      error = std::max(error, other.error.value_or(0));
  return error;
}

const Row* cheapest(const std::vector<Row>& rows, const std::string& engine, double level) {
  const Row* cheapest = nullptr;
  for (const Row& row : rows)
    if (row.engine == engine && row.failure.empty() && row.error &&
        lasting_error(rows, row) <= level)
      if (cheapest == nullptr || row.seconds < cheapest->seconds) cheapest = &row;
  return cheapest;
}

const Row* default_run(const std::vector<Row>& rows, const std::string& engine, int parts) {
  for (const Row& row : rows)
    if (row.engine == engine && row.is_default && row.parts == parts && row.failure.empty())
      return &row;
  return nullptr;
}

double step_seconds(const std::vector<Row>& rows, const std::string& engine, int links) {
  double least = std::numeric_limits<double>::infinity();
  for (const Row& row : rows)
    if (row.engine == engine && row.parts == links && row.steps > 0)
      least = std::min(least, row.seconds_a_step());
  return least;
}

std::string csv(const std::vector<std::string>& machine, const std::vector<Row>& rows,
                const std::string& error_unit) {
  files::Table table({"engine", "version", "setting", "is_default", "parts", "step_s", "accuracy",
                      "steps", "seconds", "error_" + error_unit, "energy_error", "joint_gap_m",
                      "failure"});
  for (const std::string& line : machine) table.note(line);
  for (const Row& row : rows) {
    const bool ran = row.failure.empty();
    const auto value = [](bool known, double number) {
      return known ? files::digits(number) : std::string();
    };
    table.add(row.engine, row.version, row.setting, row.is_default ? 1 : 0, row.parts,
              value(row.rung == Rung::step, row.value),
              value(row.rung == Rung::accuracy, row.value),
              row.steps > 0 ? std::to_string(row.steps) : "", value(row.steps > 0, row.seconds),
              value(ran && row.error, row.error.value_or(0)), value(ran, row.energy_error),
              value(ran, row.joint_gap), row.failure);
  }
  return table.csv();
}

std::string slider_crank_table(const Report& report) {
  const std::vector<Row>& rows = report.slider_crank;
  files::Table prices = level_table(), ratios = level_table();
  prices.header().push_back("  by, at the last level reached");
  for (const std::string& name : names(rows)) {
    files::Table::Row &price = prices.add(name), &ratio = ratios.add(name);
    const Row* hardest = nullptr;
    for (const double level : levels) {
      const Row *row = cheapest(rows, name, level), *own = cheapest(rows, ours, level);
      price.push_back(row != nullptr ? plain(1e3 * row->seconds) : dash);
      ratio.push_back(row != nullptr && own != nullptr ? plain(row->seconds / own->seconds) : dash);
      if (row != nullptr) hardest = row;
    }
    if (hardest != nullptr)
      price.push_back(fmt::format("  {}, {}", hardest->setting, rung(*hardest)));
  }

  files::Table defaults(
      {"", "time [ms]", "error [rad]", "joint gap [m]", "ours [ms]", "ratio", "  setting"});
  for (const Row& row : rows) {
    if (!row.is_default) continue;
    const std::string setting = fmt::format("  {}, {}", row.setting, rung(row));
    if (!row.failure.empty()) {
      defaults.add(row.engine, setting + ": " + row.failure);
      continue;
    }
    const Row* own = cheapest(rows, ours, *row.error);
    defaults.add(row.engine, plain(1e3 * row.seconds), number(*row.error), number(row.joint_gap),
                 own != nullptr ? plain(1e3 * own->seconds) : dash,
                 own != nullptr ? plain(row.seconds / own->seconds) : dash, setting);
  }

  std::string text = "Slider-crank, 2 s: error of the wheel's angle at the end\n" +
                     heading(report.machine) +
                     "\nprocessor time [ms] of the cheapest run whose error [rad], and that of all "
                     "finer ones, is at most\n" +
                     peers::text(prices) + "\nthe same, divided by the time of this solver\n" +
                     peers::text(ratios) +
                     "\neach engine as it comes, and what this solver pays for the same error\n" +
                     defaults.text({-18, 11, 14, 14, 11, 11});
  const Row *accurate = cheapest(rows, ours, 1e-10), *usual = default_run(rows, "Box2D", 3);
  if (accurate != nullptr && usual != nullptr)
    text += fmt::format(
        "\nthis solver's 1e-10 rad ({} ms) against Box2D as it comes ({} ms, {} rad): {} of its "
        "time\n",
        plain(1e3 * accurate->seconds), plain(1e3 * usual->seconds), number(*usual->error),
        plain(accurate->seconds / usual->seconds));
  return text;
}

std::string chain_table(const Report& report) {
  const std::vector<Row>& rows = report.chain;
  const std::vector<int> parts = lengths(rows);
  std::string text = "Chain of N links, 0.5 s from horizontal\n" + heading(report.machine);

  const auto empty = [&] {
    files::Table table({""});
    for (const int n : parts) table.header().push_back(fmt::format("N = {}", n));
    return table;
  };
  const auto table = [&](const std::string& title, auto value) {
    files::Table values = empty();
    for (const std::string& name : names(rows)) {
      files::Table::Row& row = values.add(name);
      for (const int n : parts) row.push_back(value(name, n));
    }
    text += "\n" + title + "\n" + peers::text(values);
  };

  files::Table steps = empty();
  std::vector<int> widths{-18};
  widths.resize(1 + parts.size(), 11);
  widths.resize(2 * parts.size(), 14);
  for (std::size_t i = 1; i < parts.size(); ++i)
    steps.header().push_back(fmt::format("{} to {}", parts[i - 1], parts[i]));
  for (const std::string& name : names(rows)) {
    files::Table::Row& row = steps.add(name);
    for (const int n : parts) {
      const double seconds = step_seconds(rows, name, n);
      row.push_back(std::isfinite(seconds) ? plain(1e6 * seconds) : dash);
    }
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const double growth =
          std::log(step_seconds(rows, name, parts[i]) / step_seconds(rows, name, parts[i - 1])) /
          std::log(double(parts[i]) / parts[i - 1]);
      row.push_back(std::isfinite(growth) ? fmt::format("{:.2f}", growth) : dash);
    }
  }
  text += "\nprocessor time of one step [µs], and the exponent by which it grows from N to 10 N\n" +
          steps.text(widths);

  const auto of_default = [&](auto value) {
    return [&, value](const std::string& name, int n) {
      const Row* row = default_run(rows, name, n);
      return row != nullptr ? value(*row) : dash;
    };
  };
  table("each engine as it comes: time of the whole run [ms]",
        of_default([](const Row& row) { return plain(1e3 * row.seconds); }));
  table("the same: error of the free end [m], or, marked E, relative energy error",
        of_default([](const Row& row) {
          return row.error ? number(*row.error) : "E " + number(row.energy_error);
        }));
  table("the same: largest joint gap [m]",
        of_default([](const Row& row) { return number(row.joint_gap); }));

  const auto of_best = [&](auto value) {
    return [&, value](const std::string& name, int n) {
      const Row* row = best(rows, name, n);
      return row != nullptr ? value(*row) : dash;
    };
  };
  table("the most accurate run: time [ms]",
        of_best([](const Row& row) { return plain(1e3 * row.seconds); }));
  table("the same: error of the free end [m], or, marked E, relative energy error",
        of_best([](const Row& row) {
          return row.error ? number(*row.error) : "E " + number(row.energy_error);
        }));
  table("the same: largest joint gap [m]",
        of_best([](const Row& row) { return number(row.joint_gap); }));

  std::string failures;
  for (const Row& row : rows)
    if (row.is_default && !row.failure.empty())
      failures += fmt::format("  {}, N = {}, {}, {}: {}\n", row.engine, row.parts, row.setting,
                              rung(row), row.failure);
  if (!failures.empty()) text += "\nas it comes, these do not get through\n" + failures;

  const int longest = parts.back();
  double step = std::numeric_limits<double>::infinity();
  for (const Row& row : rows)
    if (row.engine == ours && row.setting == "rk4" && row.parts == longest && row.steps > 0)
      step = std::min(step, row.seconds_a_step());
  const Row* usual = default_run(rows, "Box2D", longest);
  if (std::isfinite(step) && usual != nullptr)
    text += fmt::format(
        "\none RK4 step of this solver at N = {} ({} µs) against one Box2D step of 8/3 iterations "
        "({} µs): {} of its time\n",
        longest, plain(1e6 * step), plain(1e6 * usual->seconds_a_step()),
        plain(step / usual->seconds_a_step()));
  return text;
}

}  // namespace peers
