#include "instruments/measure/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "instruments/files/table.hpp"

namespace measure {
namespace {

std::string order_text(const measure::Rung* coarse, const measure::Rung& fine, std::size_t k) {
  if (coarse == nullptr || fine.tolerance > 0.0) return "";
  const double order = measure::observed_order(*coarse, fine, k);
  return std::isfinite(order) ? fmt::format("{:.2f}", order) : "";
}

std::string time_table(const Report& report) {
  const auto& first = report.quantities.front();
  files::Table table({fmt::format("time to reach, ms ({} error)", first.name)});
  for (const double level : error_levels)
    table.header().push_back(fmt::format("{:g} {}", level, first.unit));
  const std::vector<std::string> names = methods(report);
  std::vector<std::pair<std::vector<double>, std::size_t>> fastest;  // by the hardest level reached
  for (std::size_t i = 0; i < names.size(); ++i) {
    fastest.emplace_back(std::vector<double>{}, i);
    for (const double level : error_levels)
      fastest[i].first.insert(fastest[i].first.begin(), time_to_reach(report, names[i], level));
  }
  std::sort(fastest.begin(), fastest.end());
  for (const auto& [times, i] : fastest) {
    files::Table::Row& row = table.add("  " + names[i]);
    for (auto seconds = times.rbegin(); seconds != times.rend(); ++seconds)
      row.push_back(std::isfinite(*seconds) ? files::digits(1e3 * *seconds, 3) : "not reached");
  }
  return table.text({-34, 14, 14, 14});
}

}  // namespace

std::vector<std::string> methods(const Report& report) {
  std::vector<std::string> names;
  for (const measure::Rung& rung : report.rungs)
    if (std::find(names.begin(), names.end(), rung.method) == names.end())
      names.push_back(rung.method);
  return names;
}

double time_to_reach(const Report& report, const std::string& method, double level) {
  constexpr double never = std::numeric_limits<double>::infinity();
  double reached = never;
  const measure::Rung* before = nullptr;
  for (const measure::Rung& rung : report.rungs) {
    if (rung.method != method) continue;
    if (!rung.errors.empty() && rung.errors[0] > level) {
      reached = never;
    } else if (!rung.errors.empty() && reached == never) {
      reached = rung.seconds;
      if (before != nullptr && !before->errors.empty() && rung.errors[0] > 0.0) {
        const double part =
            std::log(before->errors[0] / level) / std::log(before->errors[0] / rung.errors[0]);
        reached = before->seconds * std::pow(rung.seconds / before->seconds, part);
      }
    }
    before = &rung;
  }
  return reached;
}

std::string short_table(const Report& report) {
  std::string machine;
  for (const std::string& line : report.machine)
    if (!line.starts_with("flags:")) machine += (machine.empty() ? "" : "; ") + line;
  return time_table(report) + machine + "\n";
}

std::string table(const Report& report) {
  std::string text =
      fmt::format("{}: error against run time, {:g} s of motion\n", report.title, report.duration);
  for (const std::string& line : report.machine) text += "  " + line + "\n";

  files::Table table({"method", "step s", "evaluations", "time ms"});
  std::vector<int> widths{-28, 12, 12, 12};
  for (const auto& quantity : report.quantities) {
    table.header().insert(table.header().end(), {quantity.name + " " + quantity.unit, "order"});
    widths.insert(widths.end(), {22, 7});
  }
  table.header().insert(table.header().end(), {"|C| " + report.constraint_unit, "energy J"});
  widths.insert(widths.end(), {12, 12});

  const measure::Rung* coarse = nullptr;
  for (const measure::Rung& rung : report.rungs) {
    if (coarse != nullptr && coarse->method != rung.method) {
      coarse = nullptr;
      table.add();
    }
    files::Table::Row& row =
        table.add(rung.method, rung.tolerance > 0.0 ? fmt::format("tol {:g}", rung.tolerance)
                                                    : files::digits(rung.step));
    const auto add = [&row](auto... cells) { (row.push_back(cells), ...); };
    if (rung.errors.empty()) {
      add("  failed: " + rung.failure);
    } else {
      add(fmt::format("{}", rung.evaluations), files::digits(1e3 * rung.seconds, 4));
      for (std::size_t k = 0; k < rung.errors.size(); ++k)
        add(fmt::format("{:.2e}", rung.errors[k]), order_text(coarse, rung, k));
      add(fmt::format("{:.2e}", rung.constraint_error),
          std::isnan(rung.energy_error) ? "" : fmt::format("{:.2e}", rung.energy_error));
      if (!rung.far_off.empty()) add("  far off: " + rung.far_off);
    }
    coarse = &rung;
  }
  return text + "\n" + table.text(widths) + "\n" + time_table(report);
}

std::string csv(const Report& report) {
  using files::digits;
  files::Table table({"method", "order", "tolerance", "step", "steps", "evaluations", "seconds",
                      "constraint_error", "energy_error", "far_off", "failure"});
  table.note("title", report.title);
  table.note("duration", digits(report.duration, 17));
  table.note("constraint_unit", report.constraint_unit);
  for (const auto& quantity : report.quantities)
    table.note("quantity", quantity.name + "|" + quantity.unit);
  for (const std::string& line : report.machine) table.note("machine", line);
  if (!report.remark.empty()) table.note("remark", report.remark);
  for (const auto& quantity : report.quantities) table.header().push_back(quantity.name + "_error");
  for (const measure::Rung& r : report.rungs) {
    files::Table::Row& row =
        table.add(r.method, r.order, digits(r.tolerance), digits(r.step, 17), r.steps,
                  r.evaluations, digits(r.seconds), digits(r.constraint_error, 17),
                  digits(r.energy_error, 17), r.far_off, r.failure);
    for (std::size_t k = 0; k < report.quantities.size(); ++k)
      row.push_back(r.errors.empty() ? "" : digits(r.errors[k], 17));
  }
  return table.csv();
}

Report read_csv(const std::filesystem::path& path) {
  Report report;
  files::read_csv(
      path,
      [&](const files::SavedRow& row) {
        Rung rung{.method = row["method"],
                  .order = row.number<int>("order"),
                  .tolerance = row.number("tolerance"),
                  .step = row.number("step"),
                  .steps = row.number<long>("steps"),
                  .evaluations = row.number<long>("evaluations"),
                  .seconds = row.number("seconds"),
                  .constraint_error = row.number("constraint_error"),
                  .energy_error = row["energy_error"].empty()
                                      ? std::numeric_limits<double>::quiet_NaN()
                                      : row.number("energy_error"),
                  .far_off = row["far_off"],  // came later
                  .failure = row["failure"]};
        if (rung.failure.empty())
          for (const auto& quantity : report.quantities)
            rung.errors.push_back(row.number(quantity.name + "_error"));
        report.rungs.push_back(rung);
      },
      [&](const std::string& name, const std::string& value) {
        if (name == "title") report.title = value;
        if (name == "duration") report.duration = std::stod(value);
        if (name == "constraint_unit") report.constraint_unit = value;
        if (name == "remark") report.remark = value;
        if (name == "machine") report.machine.push_back(value);
        if (name == "quantity") {
          const std::size_t bar = value.find('|');
          report.quantities.push_back({value.substr(0, bar), value.substr(bar + 1)});
        }
      });
  return report;
}

}  // namespace measure
