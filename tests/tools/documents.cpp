// Keeps what the documents show in step with what the sources say and the programs print.
//
//   documents [--check | --numbers | --commands | --times] SOURCE BIN [PAGE...]
//
// The pages are files in SOURCE; without any, all of README.md, docs and chapters.
//
// A comment in a document names where the fenced block after it comes from:
//
//   <!-- excerpt: FILE NAME -->   the lines of FILE between two lines "// [NAME]"
//   <!-- output: COMMAND -->      what the shell command prints in SOURCE; the programs are on its
//   path
//   <!-- report: CSV -->          the short table of a saved report
//   <!-- cases: CSV -->           the table of saved stability cases; likewise
//   <!-- long_run: CSV -->        the energy errors of saved long runs
//
// and one names where the figures of the paragraph after it come from:
//
//   <!-- figures: COMMAND -->     each number with a decimal point, a factor before its power of
//                                 ten or three digits is one that the shell command prints, rounded
//   <!-- given -->                they are chosen, or a source's; nothing here measures them
//
// Without --check the blocks are written anew. With it nothing is written: each block that differs
// and each link without a target is named, and the exit status is 1. With --numbers each paragraph
// is named instead that has such numbers and neither of these two comments, and the exit status
// is 1. With --commands the commands that the documents show in indented lines, and those of
// build/bin in the text, are run instead; with --times the reports of the tables are measured again
// and their times compared with the saved, within the noise of a busy machine.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "instruments/files/files.hpp"
#include "instruments/measure/cases.hpp"
#include "instruments/measure/report.hpp"

namespace fs = std::filesystem;

namespace {

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// The lines between the two markers, without the indentation that they share.
std::vector<std::string> excerpt(const fs::path& file, const std::string& name) {
  std::vector<std::string> lines;
  int markers = 0;
  for (const std::string& line : lines_of(file)) {
    const std::size_t start = line.find_first_not_of(' ');
    if (start != std::string::npos && line.substr(start) == "// [" + name + "]")
      ++markers;
    else if (markers == 1)
      lines.push_back(line);
  }
  if (markers != 2)
    throw std::runtime_error(fmt::format("{} has no pair of lines // [{}]", file.string(), name));
  std::size_t indentation = std::string::npos;
  for (const std::string& line : lines)
    if (!line.empty()) indentation = std::min(indentation, line.find_first_not_of(' '));
  for (std::string& line : lines)
    if (!line.empty()) line.erase(0, indentation);
  return lines;
}

std::vector<std::string> output(const std::string& command) {
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("cannot run " + command);
  std::string text;
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), static_cast<int>(buffer.size()), pipe) != nullptr)
    text += buffer.data();
  if (pclose(pipe) != 0) throw std::runtime_error(command + " failed");
  return split_lines(text);
}

/// A line without what no two runs agree on.
std::string timeless(const std::string& line) {
  static const std::regex time("[0-9.e+]+ ns a step");
  return std::regex_replace(line, time, "ns a step");
}

bool alike(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return timeless(x) == timeless(y); });
}

std::vector<std::string> block(const fs::path& source, const std::string& kind,
                               const std::string& argument) {
  if (kind == "excerpt") {
    const std::size_t space = argument.find(' ');
    return excerpt(source / argument.substr(0, space), argument.substr(space + 1));
  }
  if (kind == "report")
    return split_lines(measure::short_table(measure::read_csv(source / argument)));
  if (kind == "cases")
    return split_lines(measure::table(measure::read_verdicts(source / argument)));
  if (kind == "long_run")
    return split_lines(measure::table(measure::read_curves(source / argument)));
  return output(argument);
}

/// The name that GitHub gives a heading: small letters, hyphens for blanks, no other punctuation.
std::string anchor(std::string heading) {
  heading.erase(0, heading.find_first_not_of("# "));
  std::string name;
  for (const char c : heading)
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || (c & 0x80))
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (c == ' ')
      name += '-';
  return name;
}

bool has_heading(const fs::path& file, const std::string& name) {
  bool code = false;
  for (const std::string& line : lines_of(file)) {
    if (line.starts_with("```")) code = !code;
    if (!code && line.starts_with("#") && anchor(line) == name) return true;
  }
  return false;
}

/// Links of the form [text](target), to files and headings, and the pictures of src="file"; the
/// rest of the world is not looked at.
void check_links(const fs::path& file, const std::vector<std::string>& lines,
                 std::vector<std::string>& complaints) {
  static const std::regex link(R"re((?:\]\(|src=")([^)#"\s]*)(?:#([^)"\s]*))?[)"])re");
  bool code = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].starts_with("```")) code = !code;
    if (code) continue;
    for (std::sregex_iterator match(lines[i].begin(), lines[i].end(), link), end; match != end;
         ++match) {
      const std::string target = (*match)[1], heading = (*match)[2];
      if (target.find("://") != std::string::npos) continue;
      const fs::path path = target.empty() ? file : file.parent_path() / target;
      if (!fs::exists(path))
        complaints.push_back(fmt::format("{}:{}: no file {}", file.string(), i + 1, target));
      else if (!heading.empty() && !has_heading(path, heading))
        complaints.push_back(
            fmt::format("{}:{}: no heading #{} in {}", file.string(), i + 1, heading, target));
    }
  }
}

/// A number as it is written, and half a unit of its last digit.
struct Figure {
  std::string text;
  double value, half_unit;
};

/// The numbers of a text, in the ways in which documents and programs write them: 0.37, 1.5e-07,
/// 6.8·10⁻⁶, 56 000.
std::vector<Figure> figures(const std::string& text) {
  static const std::regex number(
      R"re((\d{1,3}(?: \d{3})+|\d+)(\.\d+)?(?:e([-+]?\d+)|·10((?:⁻|⁰|¹|²|³|⁴|⁵|⁶|⁷|⁸|⁹)+))?)re");
  static const std::vector<std::string> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::vector<Figure> found;
  for (std::sregex_iterator match(text.begin(), text.end(), number), end; match != end; ++match) {
    std::string mantissa = (*match)[1].str() + (*match)[2].str();
    std::erase(mantissa, ' ');
    std::string exponent = (*match)[3].str(), raised = (*match)[4].str();
    if (raised.starts_with("⁻")) exponent = "-";
    for (std::size_t at = 0; at < raised.size(); ++at)
      for (std::size_t digit = 0; digit < digits.size(); ++digit)
        if (raised.compare(at, digits[digit].size(), digits[digit]) == 0)
          exponent += std::to_string(digit);
    const double scale = exponent.empty() ? 1.0 : std::stod("1e" + exponent);
    const std::size_t decimals = (*match)[2].matched ? (*match)[2].str().size() - 1 : 0;
    found.push_back({(*match)[0], std::stod(mantissa) * scale,
                     0.5 * std::pow(10.0, -static_cast<double>(decimals)) * scale});
  }
  return found;
}

/// The figures in a paragraph's prose. Not among them are those in code, formulas, addresses, names
/// (dop853), dates, years with a journal's pages, versions and sections, and numbers below 100.
std::vector<Figure> figures_of_prose(const std::string& paragraph) {
  static const std::regex other(
      R"re(`[^`]*`|\$[^$]*\$|\]\([^)]*\)|https?:\S+|\d{4}-\d\d-\d\d|§[\d.]+|\d+\.\d+\.\d+|)re"
      R"re(\b(CMake|Debian|Ubuntu|Eigen|ImGui|Box2D|MuJoCo|GLFW|C\+\+) v?\d[\d.]*|\b[A-Za-z_]\w*|)re"
      R"re(\b(19[4-9]\d|20[0-3][1-9]|20[1-3]0)\b(?!\.\d)(, \d+–\d+)?)re");
  std::vector<Figure> found = figures(std::regex_replace(paragraph, other, "|"));
  std::erase_if(found, [](const Figure& figure) {
    return figure.text.size() < 3 &&
           figure.text.find_first_not_of("0123456789") == std::string::npos;
  });
  return found;
}

/// The figures of a paragraph that a command does not print.
std::vector<std::string> strange_figures(const std::string& paragraph, const std::string& command) {
  static std::map<std::string, std::vector<Figure>> printed;  // a command may serve many paragraphs
  if (!printed.contains(command))
    printed[command] = figures(fmt::format("{}", fmt::join(output(command), "\n")));
  std::vector<std::string> strange;
  for (const Figure& shown : figures_of_prose(paragraph)) {
    const bool known =
        std::any_of(printed[command].begin(), printed[command].end(), [&](const Figure& figure) {
          return std::abs(figure.value - shown.value) <= 1.001 * shown.half_unit;
        });
    if (!known) strange.push_back(shown.text);
  }
  return strange;
}

/// Names each paragraph of running text that has figures and no comment that says where from.
void check_numbers(const fs::path& file, const std::vector<std::string>& lines,
                   std::vector<std::string>& complaints) {
  static const std::regex no_text("#.*|\\|.*|<.*|    .*|```.*|");
  bool code = false, marked = false;
  std::string paragraph;
  std::size_t first = 0;
  for (std::size_t i = 0; i <= lines.size(); ++i) {
    const std::string line = i < lines.size() ? lines[i] : "";
    if (line.starts_with("```")) code = !code;
    if (!code && !std::regex_match(line, no_text)) {
      if (paragraph.empty()) first = i + 1;
      paragraph += line + "\n";
      continue;
    }
    std::vector<std::string> found;
    for (const Figure& figure : figures_of_prose(marked ? "" : paragraph))
      found.push_back(figure.text);
    if (!found.empty())
      complaints.push_back(fmt::format("{}:{}: {} without figures: or given before the paragraph",
                                       file.string(), first, fmt::join(found, ", ")));
    paragraph.clear();
    marked = line.starts_with("<!-- figures: ") || line == "<!-- given -->";
  }
}

/// The document as it should be; what differs is named.
std::vector<std::string> in_step(const fs::path& source, const fs::path& file,
                                 const std::vector<std::string>& lines,
                                 std::vector<std::string>& complaints) {
  static const std::regex marker("<!-- (excerpt|output|report|cases|long_run): (.*) -->");
  static const std::regex of_figures("<!-- figures: (.*) -->");
  std::vector<std::string> result;
  std::smatch match;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    result.push_back(lines[i]);
    if (std::regex_match(lines[i], match, of_figures)) {
      std::string paragraph;
      for (std::size_t next = i + 1;
           next < lines.size() && !lines[next].empty() && !lines[next].starts_with("<!-- "); ++next)
        paragraph += lines[next] + "\n";
      for (const std::string& figure : strange_figures(paragraph, match[1]))
        complaints.push_back(fmt::format("{}:{}: {} is no figure of {}", file.string(), i + 2,
                                         figure, match[1].str()));
    }
    if (!std::regex_match(lines[i], match, marker)) continue;
    const std::size_t open = i + 1;
    if (open >= lines.size() || !lines[open].starts_with("```"))
      throw std::runtime_error(
          fmt::format("{}:{}: no fenced block after the comment", file.string(), i + 1));
    std::size_t close = open + 1;
    while (close < lines.size() && lines[close] != "```") ++close;
    const std::vector<std::string> fresh = block(source, match[1], match[2]);
    const std::vector<std::string> old(
        lines.begin() + static_cast<std::ptrdiff_t>(open) + 1,
        lines.begin() + static_cast<std::ptrdiff_t>(std::min(close, lines.size())));
    const bool differs = !alike(fresh, old);
    if (differs)
      complaints.push_back(
          fmt::format("{}:{}: not what {} says", file.string(), open + 1, match[2].str()));
    result.push_back(lines[open]);
    result.insert(result.end(), (differs ? fresh : old).begin(), (differs ? fresh : old).end());
    result.emplace_back("```");
    i = close;
  }
  check_links(file, lines, complaints);
  return result;
}

std::vector<fs::path> all_documents() {
  std::vector<fs::path> files{"README.md"};
  for (const char* folder : {"docs", "chapters"})
    if (fs::exists(folder))
      for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.path().extension() == ".md") files.push_back(entry.path());
  return files;
}

// -------------------------------------------------------------------------------------------------
// --commands

/// The commands of a document: indented lines, and what the text quotes of build/bin.
std::vector<std::string> commands(const fs::path& file) {
  static const std::regex quoted("`(build/bin/[^` ]+ [^`]*)`");
  std::vector<std::string> found;
  bool code = false;
  std::string before;
  for (const std::string& line : lines_of(file)) {
    if (line.starts_with("```")) code = !code;
    const bool indented = line.starts_with("    ") && line.find_first_not_of(' ') == 4;
    if (!code && indented && (before.empty() || before.starts_with("    ")))
      found.push_back(line.substr(4));
    if (!code)
      for (std::sregex_iterator match(line.begin(), line.end(), quoted), end; match != end; ++match)
        found.push_back((*match)[1]);
    before = line;
  }
  return found;
}

/// Whether a `./tutorial` command is one that its help knows, with its options. It is not run: it
/// would build, and test, inside its own test.
bool known_to_tutorial(const std::string& command) {
  std::string help;
  for (const std::string& line : output("./tutorial help")) help += line + "\n";
  std::istringstream words(command);
  std::string word;
  words >> word >> word;
  bool known = help.find("\n  " + word + " ") != std::string::npos;
  while (words >> word)
    if (word.starts_with("--")) known &= help.find(word) != std::string::npos;
  return known;
}

/// The call to which `./tutorial` passes on a chapter's options, or what is no such command as it
/// is.
std::string passed_on(const std::string& command) {
  static const std::regex of_chapter(R"re(\./tutorial (\w+) (\d+) (--.*))re");
  std::smatch match;
  if (!std::regex_match(command, match, of_chapter)) return command;
  for (const auto& entry : fs::directory_iterator("chapters")) {
    const std::string name = entry.path().filename();
    if (entry.is_directory() && std::stoi(name) == std::stoi(match[2]))
      return fmt::format("build/bin/{} {} {}", name, match[1].str(), match[3].str());
  }
  return command;
}

/// Whether clips are made here, of pictures that must be there then.
const bool clips = std::system("command -v ffmpeg >/dev/null") == 0;

/// Runs a command in a folder of its own, in which build/bin are the programs, for half a second:
/// one that is still at work then is taken to run. What a program refuses is a fault; that a
/// simulation stops, with its reason, is what some documents show, and a window needs GLFW and a
/// display.
bool runs(const std::string& command, const fs::path& folder) {
  files::write_file(folder / "command.sh", command + "\n");
  const double seconds = clips && command.find("--frames") != std::string::npos ? 5 : 0.5;
  const std::string quiet = fmt::format(
      "cd '{}' && env -u DISPLAY -u WAYLAND_DISPLAY timeout {} sh command.sh >output.txt "
      "2>errors.txt",
      folder.string(), seconds);
  constexpr int timed_out = 124;
  const int status = WEXITSTATUS(std::system(quiet.c_str()));
  if (status == 0 || status == timed_out) return true;
  const std::vector<std::string> errors = lines_of(folder / "errors.txt");
  return !errors.empty() && (errors.back().find(": stopped at t = ") != std::string::npos ||
                             errors.back().find(": no display; ") != std::string::npos ||
                             errors.back().find(": command live: ") != std::string::npos);
}

/// Returns the number of faults.
int check_commands(const std::vector<fs::path>& pages, const fs::path& bin) {
  const fs::path folder = fs::temp_directory_path() / fmt::format("documents_{}", getpid());
  fs::create_directories(folder / "build");
  fs::create_directory_symlink(bin, folder / "build" / "bin");
  std::set<std::string> done;
  int faults = 0;
  for (const fs::path& file : pages)
    for (const std::string& shown : commands(file)) {
      const std::string command = passed_on(shown.substr(0, shown.find(" #")));
      if (!done.insert(command).second) continue;
      bool fine = true;
      if (command.starts_with("./tutorial")) {
        fine = known_to_tutorial(command);
      } else if (command.starts_with("ctest ")) {  // at least one test has such a name
        const std::string place = "--test-dir build";
        std::string listed = command + " -N | grep -q 'Total Tests: [1-9]'";
        listed.replace(listed.find(place), place.size(),
                       "--test-dir " + bin.parent_path().string());
        fine = runs(listed, folder);
      } else if (command.starts_with("ffmpeg ") && !clips) {
        fmt::print("skipped, ffmpeg is missing: {}\n", command);
      } else if (!command.starts_with("cmake ")) {  // it would build inside its own test
        fine = runs(command, folder);
      }
      if (!fine) fmt::print("{}: does not run: {}\n", file.string(), command);
      faults += !fine;
    }
  fmt::print("{} commands, {} faults\n", done.size(), faults);
  fs::remove_all(folder);
  return faults;
}

/// Measures the reports of the pages' tables again. Returns how many times differ from the saved by
/// more than a busy machine explains; on another processor they only are shown.
int check_times(const std::vector<fs::path>& pages) {
  constexpr double busy = 2.0;  // docs/error_against_run_time.md, "Noise"
  static const std::regex marker(R"(<!-- report: chapters/(\w+)/snapshots/error_vs_time.csv -->)");
  const fs::path folder = fs::temp_directory_path() / fmt::format("documents_{}", getpid());
  std::map<std::string, fs::path> chapters;  // and the page with its table
  std::smatch match;
  for (const fs::path& page : pages)
    for (const std::string& line : lines_of(page))
      if (std::regex_match(line, match, marker)) chapters.emplace(match[1], page);
  int faults = 0;
  for (const auto& [chapter, page] : chapters) {
    output(fmt::format("{} report --out {}", chapter, folder.string()));
    const std::string name = "error_vs_time.csv";
    const auto saved = measure::read_csv(fs::path("chapters") / chapter / "snapshots" / name);
    const auto fresh = measure::read_csv(folder / name);
    const bool alike = saved.machine == fresh.machine;
    double least = 1e300, most = 0;
    for (const std::string& method : measure::methods(saved))
      for (const double level : measure::error_levels) {
        const double was = measure::time_to_reach(saved, method, level);
        const double ratio = measure::time_to_reach(fresh, method, level) / was;
        if (!std::isfinite(was)) continue;
        least = std::min(least, ratio);
        most = std::max(most, ratio);
        if (!alike || (ratio < busy && ratio > 1 / busy)) continue;
        ++faults;
        fmt::print("{}: {} below {:g}: {:.2f} times the saved time\n", page.string(), method, level,
                   ratio);
      }
    fmt::print("{}: {:.2f} to {:.2f} of the saved times{}\n", chapter, least, most,
               alike ? "" : ", which are another machine's or compiler's");
    std::fflush(stdout);
  }
  fs::remove_all(folder);
  return faults;
}

}  // namespace

int main(int argc, char** argv) try {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  const std::string option = arguments.empty() ? "" : arguments[0];
  const bool check = option == "--check", numbers = option == "--numbers";
  const bool commands = option == "--commands", times = option == "--times";
  if (check || numbers || commands || times) arguments.erase(arguments.begin());
  if (arguments.size() < 2 || arguments[0].starts_with('-')) {
    fmt::print(
        stderr,
        "usage: documents [--check | --numbers | --commands | --times] SOURCE BIN [PAGE...]\n");
    return 2;
  }
  const fs::path bin = fs::absolute(arguments[1]);
  fs::current_path(arguments[0]);  // commands and names are relative to it
  setenv("PATH", (bin.string() + ":" + std::getenv("PATH")).c_str(), 1);
  std::vector<fs::path> pages(arguments.begin() + 2, arguments.end());
  if (pages.empty()) pages = all_documents();
  if (commands) return check_commands(pages, bin) == 0 ? 0 : 1;
  if (times) return check_times(pages) == 0 ? 0 : 1;
  bool differs = false;
  for (const fs::path& file : pages) {
    std::vector<std::string> complaints;
    const std::vector<std::string> old = lines_of(file);
    if (numbers) check_numbers(file, old, complaints);
    const std::vector<std::string> fresh = numbers ? old : in_step(".", file, old, complaints);
    if (!check && fresh != old)
      files::write_file(file, fmt::format("{}\n", fmt::join(fresh, "\n")));
    for (const std::string& complaint : complaints) fmt::print("{}\n", complaint);
    differs |= !complaints.empty();
  }
  if (differs && !numbers)
    fmt::print("{}\n", check ? "bring them in step: ./tutorial docs" : "brought in step");
  return (check || numbers) && differs ? 1 : 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "documents: {}\n", error.what());
  return 1;
}
