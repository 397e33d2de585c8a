// The tutorial's slider-crank and chain beside the same mechanisms in other engines: error against
// processor time, in one run on one machine.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>

#include "app/options.hpp"
#include "instruments/draw/image.hpp"
#include "instruments/draw/offscreen.hpp"
#include "instruments/files/files.hpp"
#include "instruments/files/progress.hpp"
#include "instruments/measure/ladder.hpp"
#include "measure.hpp"
#include "pictures.hpp"
#include "report.hpp"

namespace {

std::vector<std::string> header(const std::vector<peers::Engine>& engines) {
  std::vector<std::string> lines = measure::machine();
  std::vector<std::string> versions;
  for (const peers::Engine& engine : engines)
    if (!engine.version.empty()) versions.push_back(engine.name + " " + engine.version);
  lines.push_back(fmt::format("engines: {}", fmt::join(versions, ", ")));
  const std::vector<std::string> missing = peers::missing_engines();
  if (!missing.empty())
    lines.push_back(fmt::format("missing when this was built: {}", fmt::join(missing, ", ")));
  return lines;
}

void compare(bool quick, const std::filesystem::path& out) {
  const std::vector<peers::Engine> engines = peers::engines();
  // Seconds that one run may take: what bounds the whole to five minutes, or to one when quick.
  const peers::Limits limits{.run_seconds = quick ? 0.04 : 2.0, .first_seconds = quick ? 0.3 : 6.0};
  peers::Report report{header(engines), {}, {}};
  {
    files::Progress progress;
    const std::vector<int> lengths{1, 10, 100, 1000};
    const double all = 1.0 + static_cast<double>(lengths.size());
    const auto part = [&](double before) {
      return [&progress, before, all](double done, const std::string& what) {
        progress.show((before + done) / all, what);
      };
    };
    report.slider_crank = peers::climb(peers::slider_crank(), engines, limits, {}, part(0));
    std::vector<peers::Row> shorter;
    double done = 1;
    for (const int links : lengths) {
      shorter = peers::climb(peers::chain(links), engines, limits, shorter, part(done++));
      report.chain.insert(report.chain.end(), shorter.begin(), shorter.end());
    }
  }
  const std::string slider_crank = slider_crank_table(report), chain = chain_table(report);
  fmt::print("{}\n{}\n", slider_crank, chain);
  std::vector<std::pair<std::string, std::string>> files{
      {"slider_crank.csv", csv(report.machine, report.slider_crank, "rad")},
      {"chain.csv", csv(report.machine, report.chain, "m")},
      {"slider_crank.txt", slider_crank},
      {"chain.txt", chain}};
  files.emplace_back(
      "slider_crank.png",
      draw::encode_png(draw::render({.captions = false}, slider_crank_picture(report).draw)));
  files.emplace_back("purpose.png", draw::encode_png(draw::render({.captions = false},
                                                                  purpose_picture(report).draw)));
  files.emplace_back(
      "chain.png", draw::encode_png(draw::render({.captions = false}, chain_picture(report).draw)));
  for (const auto& [name, content] : files) {
    files::write_file(out / name, content);
    fmt::print("{}\n", (out / name).string());
  }
}

/// One line on standard error; returns the exit status.
int fail(int status, std::string message) {
  if (const std::size_t end = message.find('\n'); end != std::string::npos) message.resize(end);
  std::fputs(fmt::format("peers: {}\n", message).c_str(), stderr);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  bool quick = false;
  std::string out = ".";
  CLI::App app{"The slider-crank and the chain in other engines: error against processor time."};
  app.add_flag("--quick", quick, "coarser ladders: under a minute instead of minutes");
  app.add_option("--out", out, "folder for the files, made if missing (default: this one)")
      ->type_name("DIR");
  try {
    app.parse(argc, argv);
    try {
      files::make_folder(out);
    } catch (const std::runtime_error& error) {
      throw app::UsageError(
          fmt::format("--out {}: {}; allowed is a folder that can be written", out, error.what()));
    }
    compare(quick, out);
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
  } catch (const CLI::ParseError& error) {
    return fail(2, fmt::format("{}; see --help", error.what()));
  } catch (const app::UsageError& error) {
    return fail(2, error.what());
  } catch (const std::exception& error) {
    return fail(1, error.what());
  }
  return 0;
}
