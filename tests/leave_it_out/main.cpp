// What a step costs with and without what a scene does not need: the ladder from the article's full
// matrices to the solver of this tutorial, and chains of 1 to 10000 links.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include "05_revolute/cost.hpp"
#include "leave_it_out/rungs.hpp"
#include "measure/ladder.hpp"
#include "program/files.hpp"

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
  std::string text =
      fmt::format("{:<40}{:>12}{:>6}{:>13}{:>7}{:>18}{:>14}\n", "one RK4 step of the slider-crank",
                  "coordinates", "rows", "allocations", "µs", "of the one above", "of the first");
  for (std::size_t i = 0; i < rungs.size(); ++i) {
    text += fmt::format("{:<40}{:>12}{:>6}{:>13}{:>7.2f}", rungs[i].name, rungs[i].coordinates,
                        rungs[i].rows, costs[i].allocations, 1e6 * costs[i].seconds);
    if (i > 0)
      text += fmt::format("{:>18.2f}{:>14.3f}", costs[i].seconds / costs[i - 1].seconds,
                          costs[i].seconds / costs[0].seconds);
    text += '\n';
  }
  return text;
}

std::string chain_table() {
  constexpr int longest_dense = 300, first_of_growth = 10;
  std::string text = fmt::format("{:>8}{:>20}{:>14}{:>14}\n", "links", "full matrices, µs",
                                 "blocks, µs", "a link, µs");
  double first = 0, thousand = 0, last = 0;
  for (const int links : {1, 3, 10, 30, 100, 300, 1000, 3000, 10000}) {
    const bool dense = links <= longest_dense;
    last = revolute::seconds_per_step(links);
    if (links == first_of_growth) first = last;
    if (links == 1000) thousand = last;
    text += fmt::format(
        "{:>8}{:>20}{:>14.4g}{:>14.3g}\n", links,
        dense ? fmt::format("{:.4g}", 1e6 * measure_costs({dense_chain(links)})[0].seconds) : "–",
        1e6 * last, 1e6 * last / links);
  }
  return text + fmt::format(
                    "from 10 links to 1000 the step in blocks grows as N^{:.2f}, to 10000 as "
                    "N^{:.2f}\n",
                    std::log10(thousand / first) / 2, std::log10(last / first) / 3);
}

void save(const std::filesystem::path& file, const std::string& text) {
  program::write_file(file, machine() + text);
  fmt::print("{}\n", file.string());
}

}  // namespace

int main(int argc, char** argv) try {
  std::filesystem::path out;
  CLI::App app("What leaving out brings: one RK4 step, rung by rung", "leave_it_out");
  app.add_option("--out", out, "folder for ladder.txt and chain.txt (default: none written)");
  CLI11_PARSE(app, argc, argv);
  if (!out.empty()) program::make_folder(out);  // before the work, not after it
  const std::string ladder = ladder_table();
  fmt::print("{}\n", ladder);
  std::fflush(stdout);
  const std::string chain = chain_table();
  fmt::print("{}", chain);
  if (!out.empty()) {
    save(out / "ladder.txt", ladder);
    save(out / "chain.txt", chain);
  }
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "leave_it_out: {}\n", error.what());
  return 1;
}
