// Keeps what the documents show in step with what the sources say and the programs print.
//
//   documents [--check] SOURCE BIN
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
// Without --check the blocks are written anew. With it nothing is written: each block that differs
// and each link to a file that is not there is named, and the exit status is 1.

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "program/files.hpp"
#include "program/report.hpp"
#include "program/stability.hpp"

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
    return split_lines(program::short_table(program::read_csv(source / argument)));
  if (kind == "cases")
    return split_lines(program::table(program::read_verdicts(source / argument)));
  if (kind == "long_run")
    return split_lines(program::table(program::read_curves(source / argument)));
  return output(argument);
}

/// Links of the form [text](target) to files; the rest of the world is not looked at.
void check_links(const fs::path& file, const std::vector<std::string>& lines,
                 std::vector<std::string>& complaints) {
  static const std::regex link(R"(\]\(([^)#\s]+)[^)]*\))");
  bool code = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines[i].starts_with("```")) code = !code;
    if (code) continue;
    for (std::sregex_iterator match(lines[i].begin(), lines[i].end(), link), end; match != end;
         ++match) {
      const std::string target = (*match)[1];
      if (target.find("://") == std::string::npos && !fs::exists(file.parent_path() / target))
        complaints.push_back(fmt::format("{}:{}: no file {}", file.string(), i + 1, target));
    }
  }
}

/// The document as it should be; what differs is named.
std::vector<std::string> in_step(const fs::path& source, const fs::path& file,
                                 const std::vector<std::string>& lines,
                                 std::vector<std::string>& complaints) {
  static const std::regex marker("<!-- (excerpt|output|report|cases|long_run): (.*) -->");
  std::vector<std::string> result;
  std::smatch match;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    result.push_back(lines[i]);
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

std::vector<fs::path> documents(const fs::path& source) {
  std::vector<fs::path> files{source / "README.md"};
  for (const char* folder : {"docs", "chapters"})
    if (fs::exists(source / folder))
      for (const auto& entry : fs::recursive_directory_iterator(source / folder))
        if (entry.path().extension() == ".md") files.push_back(entry.path());
  return files;
}

}  // namespace

int main(int argc, char** argv) try {
  const bool check = argc == 4 && std::string(argv[1]) == "--check";
  if (argc != (check ? 4 : 3)) {
    fmt::print(stderr, "usage: documents [--check] SOURCE BIN\n");
    return 2;
  }
  const fs::path source = ".", bin = fs::absolute(argv[argc - 1]);
  fs::current_path(argv[argc - 2]);  // commands and names are relative to it
  setenv("PATH", (bin.string() + ":" + std::getenv("PATH")).c_str(), 1);
  bool differs = false;
  for (const fs::path& file : documents(source)) {
    std::vector<std::string> complaints;
    const std::vector<std::string> old = lines_of(file);
    const std::vector<std::string> fresh = in_step(source, file, old, complaints);
    if (!check && fresh != old)
      program::write_file(file, fmt::format("{}\n", fmt::join(fresh, "\n")));
    for (const std::string& complaint : complaints) fmt::print("{}\n", complaint);
    differs |= !complaints.empty();
  }
  if (differs)
    fmt::print("{}\n", check ? "bring them in step: ./tutorial docs" : "brought in step");
  return check && differs ? 1 : 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "documents: {}\n", error.what());
  return 1;
}
