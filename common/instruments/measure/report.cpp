#include "instruments/measure/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace measure {
namespace {

std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(line);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  if (line.ends_with(separator)) parts.emplace_back();
  return parts;
}

std::string without_commas(std::string text) {
  std::replace(text.begin(), text.end(), ',', ';');
  return text;
}

std::string order_text(const measure::Rung* coarse, const measure::Rung& fine, std::size_t k) {
  if (coarse == nullptr || fine.tolerance > 0.0) return "";
  const double order = measure::observed_order(*coarse, fine, k);
  return std::isfinite(order) ? fmt::format("{:.2f}", order) : "";
}

std::string time_table(const Report& report) {
  const auto& first = report.quantities.front();
  std::string text = fmt::format("{:<34}", fmt::format("time to reach, ms ({} error)", first.name));
  for (const double level : error_levels)
    text += fmt::format("{:>14}", fmt::format("{:g} {}", level, first.unit));
  text += "\n";
  std::vector<std::string> names = methods(report);
  const auto price = [&](const std::string& name) {  // fastest first, by the hardest level reached
    std::vector<double> times;
    for (const double level : error_levels)
      times.insert(times.begin(), time_to_reach(report, name, level));
    return times;
  };
  std::stable_sort(names.begin(), names.end(),
                   [&](const auto& a, const auto& b) { return price(a) < price(b); });
  for (const std::string& name : names) {
    text += fmt::format("  {:<32}", name);
    for (const double level : error_levels) {
      const double seconds = time_to_reach(report, name, level);
      text += std::isfinite(seconds) ? fmt::format("{:>14.3g}", 1e3 * seconds)
                                     : fmt::format("{:>14}", "not reached");
    }
    text += "\n";
  }
  return text;
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
  for (const std::string& line : report.machine) machine += (machine.empty() ? "" : "; ") + line;
  return time_table(report) + machine + "\n";
}

std::string table(const Report& report) {
  std::string text =
      fmt::format("{}: error against run time, {:g} s of motion\n", report.title, report.duration);
  for (const std::string& line : report.machine) text += "  " + line + "\n";

  text += fmt::format("\n{:<28}{:>12}{:>12}{:>12}", "method", "step s", "evaluations", "time ms");
  for (const auto& quantity : report.quantities)
    text += fmt::format("{:>22}{:>7}", fmt::format("{} {}", quantity.name, quantity.unit), "order");
  text += fmt::format("{:>12}{:>12}\n", "|C| " + report.constraint_unit, "energy J");

  const measure::Rung* coarse = nullptr;
  for (const measure::Rung& rung : report.rungs) {
    if (coarse != nullptr && coarse->method != rung.method) {
      coarse = nullptr;
      text += "\n";
    }
    text += rung.tolerance > 0.0
                ? fmt::format("{:<28}{:>12}", rung.method, fmt::format("tol {:g}", rung.tolerance))
                : fmt::format("{:<28}{:>12.6g}", rung.method, rung.step);
    if (rung.errors.empty()) {
      text += fmt::format("  failed: {}\n", rung.failure);
    } else {
      text += fmt::format("{:>12}{:>12.4g}", rung.evaluations, 1e3 * rung.seconds);
      for (std::size_t k = 0; k < rung.errors.size(); ++k)
        text += fmt::format("{:>22.2e}{:>7}", rung.errors[k], order_text(coarse, rung, k));
      text += fmt::format("{:>12.2e}{:>12.2e}{}\n", rung.constraint_error, rung.energy_error,
                          rung.far_off.empty() ? "" : "  far off: " + rung.far_off);
    }
    coarse = &rung;
  }

  return text + "\n" + time_table(report);
}

std::string csv(const Report& report) {
  std::string text = fmt::format("# title: {}\n# duration: {:.17g}\n# constraint_unit: {}\n",
                                 report.title, report.duration, report.constraint_unit);
  for (const auto& quantity : report.quantities)
    text += fmt::format("# quantity: {}|{}\n", quantity.name, quantity.unit);
  for (const std::string& line : report.machine) text += fmt::format("# machine: {}\n", line);
  if (!report.remark.empty()) text += fmt::format("# remark: {}\n", report.remark);
  text +=
      "method,order,tolerance,step,steps,evaluations,seconds,constraint_error,energy_error,far_off,"
      "failure";
  for (const auto& quantity : report.quantities) text += "," + quantity.name + "_error";
  text += "\n";
  for (const measure::Rung& r : report.rungs) {
    text += fmt::format("{},{},{:g},{:.17g},{},{},{:.6g},{:.17g},{:.17g},{},{}", r.method, r.order,
                        r.tolerance, r.step, r.steps, r.evaluations, r.seconds, r.constraint_error,
                        r.energy_error, r.far_off, without_commas(r.failure));
    for (std::size_t k = 0; k < report.quantities.size(); ++k)
      text += r.errors.empty() ? "," : fmt::format(",{:.17g}", r.errors[k]);
    text += "\n";
  }
  return text;
}

Report read_csv(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) throw std::runtime_error(fmt::format("cannot read {}", path.string()));
  Report report;
  std::vector<std::string> header;
  for (std::string line; std::getline(stream, line);) {
    try {
      if (line.starts_with("# ")) {
        const std::size_t colon = line.find(": ");
        const std::string name = line.substr(2, colon - 2), value = line.substr(colon + 2);
        if (name == "title") report.title = value;
        if (name == "duration") report.duration = std::stod(value);
        if (name == "constraint_unit") report.constraint_unit = value;
        if (name == "remark") report.remark = value;
        if (name == "machine") report.machine.push_back(value);
        if (name == "quantity")
          report.quantities.push_back({split(value, '|').at(0), split(value, '|').at(1)});
      } else if (header.empty()) {
        header = split(line, ',');
      } else {
        const std::vector<std::string> cells = split(line, ',');
        const auto cell = [&](const char* name) -> std::string {  // far_off came later
          const auto column = std::find(header.begin(), header.end(), name);
          return column == header.end()
                     ? ""
                     : cells.at(static_cast<std::size_t>(column - header.begin()));
        };
        measure::Rung rung{.method = cell("method"),
                           .order = std::stoi(cell("order")),
                           .tolerance = std::stod(cell("tolerance")),
                           .step = std::stod(cell("step")),
                           .steps = std::stol(cell("steps")),
                           .evaluations = std::stol(cell("evaluations")),
                           .seconds = std::stod(cell("seconds")),
                           .constraint_error = std::stod(cell("constraint_error")),
                           .energy_error = std::stod(cell("energy_error")),
                           .far_off = cell("far_off"),
                           .failure = cell("failure")};
        if (rung.failure.empty())
          for (const auto& quantity : report.quantities)
            rung.errors.push_back(std::stod(cell((quantity.name + "_error").c_str())));
        report.rungs.push_back(rung);
      }
    } catch (const std::logic_error&) {  // std::out_of_range, std::invalid_argument
      throw std::runtime_error(fmt::format("{}: this line does not fit: {}", path.string(), line));
    }
  }
  return report;
}

}  // namespace measure
