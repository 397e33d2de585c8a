// The saved tables of error against run time: their errors and counts, held against fresh runs.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "catch.hpp"
#include "instruments/measure/report.hpp"

namespace fs = std::filesystem;

namespace {

std::string output(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen((command + " 2>/dev/null").c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) text += buffer.data();
  pclose(pipe);  // 1 where the run is far from right, as coarse ones are
  return text;
}

/// The number behind a name, or in front of it.
double number(const std::string& text, const std::string& pattern) {
  std::smatch match;
  INFO(pattern << " in\n" << text);
  REQUIRE(std::regex_search(text, match, std::regex(pattern)));
  return std::stod(match[1]);
}

/// Prints have three digits; what is rounding differs from machine to machine.
void same(const std::string& text, const std::string& name, double saved, double rounding) {
  INFO(name);
  const double fresh = number(text, "\n  " + name + " +([-+.0-9a-z]+)");
  CHECK(std::abs(fresh - saved) <= 0.006 * std::abs(saved) + rounding);
}

#ifdef __SANITIZE_ADDRESS__
constexpr long most_steps = 200;  // to start a program takes long there
#else
constexpr long most_steps = 1000;
#endif
}  // namespace

TEST_CASE("errors and counts of the saved reports are those of a fresh run") {
  const std::map<std::string, std::string> options{{"06_prismatic", "--spin 5"}};
  std::set<std::string> chapters;
  int rows = 0;
  for (const auto& folder : fs::directory_iterator(fs::path(TUTORIAL_SOURCE) / "chapters")) {
    const fs::path saved = folder.path() / "snapshots" / "error_vs_time.csv";
    const std::string chapter = folder.path().filename();
    if (!fs::exists(saved)) continue;
    const measure::Report report = measure::read_csv(saved);
    for (const measure::Rung& rung : report.rungs) {
      const bool projected = rung.method.ends_with(" + projection");
      const std::string integrator = rung.method.substr(0, rung.method.find(' '));
      if (rung.steps > most_steps || rung.tolerance > 0 || !rung.failure.empty()) continue;
      if (!projected && integrator != rung.method) continue;  // feedback, by the chapter's gains
      const std::string command = fmt::format(
          "{}/{} run --integrator {} --stabilization {} --duration {} --step {} {}", TUTORIAL_BIN,
          chapter, integrator, projected ? "projection" : "none", report.duration, rung.step,
          options.contains(chapter) ? options.at(chapter) : "");
      INFO(command);
      const std::string all = output(command);
      // How often the implicit method iterates may depend on when it is looked at.
      CHECK(number(all, ": ([0-9]+) evaluations") ==
            Approx(rung.evaluations).epsilon(integrator == "implicit_midpoint" ? 0.01 : 0.0));
      const std::string text = all.substr(all.find("\nerror against the exact answer"));
      for (std::size_t k = 0; k < report.quantities.size(); ++k)
        same(text, report.quantities[k].name, rung.errors[k], 1e-8);
      same(text, "constraint error .C.", rung.constraint_error, 1e-10);
      if (std::isfinite(rung.energy_error)) same(text, "energy error", rung.energy_error, 1e-10);
      chapters.insert(chapter);
      ++rows;
    }
  }
  CHECK(chapters.size() >= 7);
  CHECK(rows > 50);
}
