// What a step costs with and without what a scene does not need: the ladder from the article's full
// matrices to the solver of this tutorial. (Of chains: build/bin/05_revolute report.)

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "instruments/files/files.hpp"
#include "instruments/files/table.hpp"
#include "instruments/measure/ladder.hpp"
#include "leave_it_out/rungs.hpp"

namespace {

using namespace leave_it_out;

std::string machine() {
  std::string text;
  for (const std::string& line : measure::machine()) text += line + "\n";
  return text + "\n";
}

std::string ladder_table() {
  const std::vector<Rung> rungs = slider_crank_ladder();
  const std::vector<Cost> costs = measure_costs(rungs);
  files::Table table({"one RK4 step of the slider-crank", "coordinates", "rows", "allocations",
                      "µs", "of the one above", "of the first"});
  for (std::size_t i = 0; i < rungs.size(); ++i) {
    const double seconds = costs[i].seconds;
    files::Table::Row& row = table.add(rungs[i].name, rungs[i].coordinates, rungs[i].rows,
                                       costs[i].allocations, fmt::format("{:.2f}", 1e6 * seconds));
    if (i == 0) continue;
    row.push_back(fmt::format("{:.2f}", seconds / costs[i - 1].seconds));
    row.push_back(fmt::format("{:.3f}", seconds / costs[0].seconds));
  }
  return table.text({-40, 12, 6, 13, 7, 18, 14});
}

}  // namespace

int main(int argc, char** argv) try {
  std::filesystem::path out;
  CLI::App app("What leaving out brings: one RK4 step, rung by rung", "leave_it_out");
  app.add_option("--out", out, "folder for ladder.txt (default: none written)")
      ->check(CLI::Validator(
          [](const std::string& folder) { return folder.empty() ? "is empty" : ""; }, "DIR"));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help
    fmt::print(stderr, "leave_it_out: {}; see --help\n", error.what());
    return 2;
  }
  if (!out.empty()) files::make_folder(out);  // before the work, not after it
  const std::string ladder = machine() + ladder_table();
  fmt::print("{}", ladder);
  if (!out.empty()) {
    files::write_file(out / "ladder.txt", ladder);
    fmt::print("{}\n", (out / "ladder.txt").string());
  }
  if (std::fflush(stdout) != 0) throw std::runtime_error("cannot write standard output");
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "leave_it_out: {}\n", error.what());
  return 1;
}
