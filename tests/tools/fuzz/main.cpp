// Calls the chapters' programs with made-up command lines and checks what they promise of each:
//
//   exit status 0, 1 or 2; with 1 and 2 one line on standard error that says why; no number that is
//   none in what they print or write; no file left behind by a run that did not end well; an end,
//   in at most a minute of processor time.
//
// With --coarse the command lines are runs with coarse steps, and what is checked is that those
// that are far from right say so (coarse.cpp).
//
// All in one process, so that a hundred thousand take minutes even under the sanitizers. inputs.cpp
// makes the command lines; a program's own --help says which options there are.

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "coarse.hpp"
#include "inputs.hpp"

// A sanitizer that finds something ends in SIGABRT, so that what ran can be said.
extern "C" const char* __asan_default_options() { return "abort_on_error=1"; }
extern "C" const char* __ubsan_default_options() { return "abort_on_error=1:print_stacktrace=1"; }

// The chapters' main functions, renamed by the build: main is called as a C function is.
extern "C" {
int chapter_1_main(int, char**);
int chapter_2_main(int, char**);
int chapter_3_main(int, char**);
int chapter_4_main(int, char**);
int chapter_5_main(int, char**);
int chapter_6_main(int, char**);
int chapter_7_main(int, char**);
int chapter_8_main(int, char**);
int chapter_9_main(int, char**);
}

namespace fs = std::filesystem;

namespace {

struct Program {
  const char* name;
  int (*main)(int, char**);
  std::vector<fuzz::Option> options = {};
};
std::array<Program, 9> programs{{{"01_particle_on_curve_implicit", chapter_1_main},
                                 {"02_parametric_lagrangian", chapter_2_main},
                                 {"03_global_jacobian_solver", chapter_3_main},
                                 {"04_ground", chapter_4_main},
                                 {"05_revolute", chapter_5_main},
                                 {"06_prismatic", chapter_6_main},
                                 {"07_slider_crank", chapter_7_main},
                                 {"08_paths", chapter_8_main},
                                 {"09_drivers", chapter_9_main}}};
static_assert(FUZZ_CHAPTERS == std::tuple_size_v<decltype(programs)>);

// -------------------------------------------------------------------------------------------------
// What must still be said when the process is about to die: only what a signal handler may touch.

int terminal = STDERR_FILENO;  // standard error as it was before it was redirected
std::array<char, 1 << 16> running{};

void remember(const std::string& line) {
  const std::size_t size = std::min(line.size(), running.size() - 1);
  std::copy_n(line.data(), size, running.begin());
  running[size] = '\0';
}

void say(const std::string& text) { dprintf(terminal, "%s", text.c_str()); }

void say_what_ran(const char* reason) {
  for (const char* text :
       {"FAILURE: ", reason, "\n  ", static_cast<const char*>(running.data()), "\n"})
    if (write(terminal, text, std::strlen(text)) < 0) return;
}

/// What the sanitizer or the C library says of it went where standard error went.
void show_captured() {
  std::array<char, 4096> text;
  off_t at = 0;
  for (ssize_t n; (n = pread(STDERR_FILENO, text.data(), text.size(), at)) > 0; at += n)
    if (write(terminal, text.data(), static_cast<std::size_t>(n)) < 0) return;
}

void out_of_time(int) {
  say_what_ran("takes too long");
  _exit(1);
}

void crashed(int signal) {
  say_what_ran("crashes");
  show_captured();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void watch() {
  std::signal(SIGPROF, out_of_time);
  std::signal(SIGABRT, crashed);
#ifndef __SANITIZE_ADDRESS__  // which says more of these
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL}) std::signal(signal, crashed);
#endif
}

/// `seconds` of processor time from now on; 0 stops the clock.
void limit_time(double seconds) {
  const auto whole = static_cast<time_t>(seconds);
  const itimerval timer{
      {0, 0}, {whole, static_cast<suseconds_t>((seconds - static_cast<double>(whole)) * 1e6)}};
  setitimer(ITIMER_PROF, &timer, nullptr);
}

// -------------------------------------------------------------------------------------------------
// One call

/// A standard stream that goes into memory.
class Captured {
 public:
  explicit Captured(int stream) : memory_(memfd_create("captured", 0)) {
    if (memory_ < 0 || dup2(memory_, stream) < 0) throw std::runtime_error("cannot capture");
  }
  /// What was written since the last time.
  std::string take() const {
    std::string text(static_cast<std::size_t>(lseek(memory_, 0, SEEK_CUR)), '\0');
    const bool whole = pread(memory_, text.data(), text.size(), 0) == ssize_t(text.size());
    if (!whole || ftruncate(memory_, 0) != 0 || lseek(memory_, 0, SEEK_SET) != 0)
      throw std::runtime_error("cannot read what was captured");
    return text;
  }

 private:
  int memory_;
};

struct Result {
  int status;
  std::string out, err;
};

Result call(const Program& program, std::vector<std::string> arguments, double seconds) {
  static const Captured out(STDOUT_FILENO), err(STDERR_FILENO);
  arguments.insert(arguments.begin(), program.name);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  limit_time(seconds);
  const int status = program.main(static_cast<int>(arguments.size()), argv.data());
  limit_time(0.0);
  std::fflush(nullptr);  // std::cout, too, since it is in step with stdout
  return {status, out.take(), err.take()};
}

// -------------------------------------------------------------------------------------------------
// What is promised: each check returns what is wrong, or nothing.

/// Whether some word of the text is a number that is none.
bool has_no_number(const std::string& text) {
  std::string word;
  for (const char c : text + ' ') {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_') {
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    } else {
      if (word == "nan" || word == "inf" || word == "infinity") return true;
      word.clear();
    }
  }
  return false;
}

std::string check_table(const std::string& text) {
  if (!text.ends_with('\n')) return "a table ends in the middle of a line";
  std::istringstream stream(text);
  std::string line;
  std::getline(stream, line);
  const auto columns = std::count(line.begin(), line.end(), ',');
  const std::string last = "velocity_error";  // before the reactions, which may be not determined
  const auto end_of_last = line.begin() + static_cast<std::ptrdiff_t>(line.find(last));
  const auto always = std::count(line.begin(), end_of_last, ',');
  while (std::getline(stream, line)) {
    if (std::count(line.begin(), line.end(), ',') != columns) return "a row of another length";
    std::ptrdiff_t column = 0;
    for (const char* cell = line.c_str();; ++cell, ++column) {
      if (column > always && (*cell == ',' || *cell == '\0')) {
        if (*cell == '\0') break;
        continue;
      }
      char* end = nullptr;
      const double value = std::strtod(cell, &end);
      if (end == cell || (*end != ',' && *end != '\0') || !std::isfinite(value))
        return "a cell without a number";
      cell = end;
      if (*cell == '\0') break;
    }
  }
  return {};
}

std::string check_message(const Result& result) {
  std::istringstream stream(result.err);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  if (!result.err.empty() && !result.err.ends_with('\n')) return "half a line on standard error";
  const auto warnings =
      std::erase_if(lines, [](const std::string& line) { return line.starts_with("warning: "); });
  if (lines.size() != (result.status == 0 ? 0 : 1))
    return fmt::format("{} lines on standard error beside warnings", lines.size());
  return result.status == 2 && warnings > 0 ? "a warning beside a refusal" : "";
}

/// Nothing, where there is no such file.
std::string read_file(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// Looks at the files in the current folder, and clears it.
std::string check_files(const fuzz::Input& input, const Result& result) {
  std::string wrong;
  for (const auto& entry : fs::directory_iterator(".")) {
    const std::string name = entry.path().filename();
    if (result.status != 0) wrong = "leaves a file behind: ";
    if (name.ends_with(".part")) wrong = "leaves an unfinished file behind: ";
    if (wrong.empty() && input.arguments[0] == "run") {
      wrong = check_table(read_file(entry.path()));
    }
    fs::remove_all(entry.path());
  }
  return wrong;
}

std::string check(const fuzz::Input& input, const Result& result) {
  if (result.status < 0 || result.status > 2) return fmt::format("exit status {}", result.status);
  if (input.must_be_refused && result.status != 2) return "accepts what it must refuse";
  if (result.status == 2 && !result.out.empty()) return "prints something, and refuses";
  if (has_no_number(result.out)) return "prints a number that is none";
  std::string wrong = check_message(result);
  const bool table = result.out.starts_with("t,");
  if (wrong.empty() && table) wrong = check_table(result.out);
  if (wrong.empty() && result.status == 1 && !table && !result.out.empty())
    wrong = "prints a summary of what it could not finish";
  return wrong;
}

// -------------------------------------------------------------------------------------------------

struct Request {
  std::uint64_t seed = 1, from = 0, inputs = 1000;
  std::size_t chapter = 0;
  bool coarse = false;
  double seconds = 60.0;
};

class Fuzzer {
 public:
  explicit Fuzzer(const Request& request) : request_(request) {
    for (Program& program : programs) {
      program.options = fuzz::read_help(call(program, {"run", "--help"}, 10.0).out);
      if (program.options.size() < 10)
        throw std::runtime_error(fmt::format("{}: no options in its help", program.name));
    }
  }

  int run() {
    const bool progress = isatty(terminal) != 0;
    for (std::uint64_t i = 0; i < request_.inputs; ++i) {
      one(request_.from + i);
      if (progress && i % 64 == 0) say(fmt::format("\r{} of {} ", i, request_.inputs));
    }
    if (progress) say("\r\x1b[K");
    return failures_ == 0 ? 0 : 1;
  }

  std::string summary() const {
    std::string text = fmt::format("{} inputs, {} failures: {} ran, {} stopped, {} refused",
                                   request_.inputs, failures_, ended_[0], ended_[1], ended_[2]);
    if (request_.coarse) text += fmt::format("; {} warned", warned_);
    return text + "\n";
  }

 private:
  void one_coarse(std::uint64_t index) {
    const fuzz::Coarse coarse = fuzz::make_coarse(request_.seed, index);
    const Program& program = programs[coarse.chapter];
    std::string line = program.name;
    for (const std::string& argument : coarse.arguments) line += ' ' + argument;
    remember(fmt::format("{}\n  fuzz --coarse --seed {} --only {}", line, request_.seed, index));
    std::vector<std::string> with_table = coarse.arguments;
    with_table.insert(with_table.end(), {"--csv", "table.csv"});
    const Result result = call(program, with_table, request_.seconds);
    const std::string table = read_file("table.csv");
    fs::remove("table.csv");
    ++ended_[static_cast<std::size_t>(result.status)];
    warned_ += result.err.find("warning: ") != std::string::npos;
    if (result.status != 0) return;
    const std::string wrong =
        fuzz::check_coarse(coarse, {result.status, result.out, result.err, table});
    if (wrong.empty()) return;
    ++failures_;
    say_what_ran(wrong.c_str());
    say("  " + result.err + "\n");
  }

  void one(std::uint64_t index) {
    if (request_.coarse) return one_coarse(index);
    const std::size_t chapter = request_.chapter != 0
                                    ? request_.chapter - 1
                                    : fuzz::choose(request_.seed, index, programs.size());
    const Program& program = programs[chapter];
    const fuzz::Input input = fuzz::make_input(request_.seed, index, program.options);
    std::string line = program.name;
    for (const std::string& argument : input.arguments) line += ' ' + fuzz::quoted(argument);
    remember(
        fmt::format("{}\n  fuzz --seed {} --only {}{}", line, request_.seed, index,
                    request_.chapter != 0 ? fmt::format(" --chapter {}", request_.chapter) : ""));
    std::string wrong, said;
    try {
      const Result result = call(program, input.arguments, request_.seconds);
      const std::string files = check_files(input, result);
      wrong = check(input, result);
      if (wrong.empty()) wrong = files;
      said = result.err;
      if (wrong.empty()) ++ended_[static_cast<std::size_t>(result.status)];
    } catch (const std::exception& error) {
      limit_time(0.0);
      wrong = fmt::format("lets an exception out: {}", error.what());
      check_files(input, {});
    }
    if (wrong.empty()) return;
    ++failures_;
    say_what_ran(wrong.c_str());
    say("  " + said + "\n");
  }

  Request request_;
  std::uint64_t failures_ = 0, warned_ = 0;
  std::array<std::uint64_t, 3> ended_{};
};

/// A folder of its own to stand in, that goes away in the end.
class Folder {
 public:
  Folder() {
    fs::create_directories(path_);
    fs::current_path(path_);
  }
  ~Folder() {
    fs::current_path("/");
    fs::remove_all(path_);
  }

 private:
  fs::path path_ = fs::temp_directory_path() / fmt::format("fuzz_{}", getpid());
};

}  // namespace

int main(int argc, char** argv) {
  Request request;
  std::optional<std::uint64_t> only;
  CLI::App app("Calls the chapters' programs with made-up command lines", "fuzz");
  app.add_option("--seed", request.seed, "of the inputs (default 1)");
  app.add_option("--inputs", request.inputs, "how many (default 1000)");
  app.add_option("--from", request.from, "the first of them (default 0)");
  app.add_option("--only", only, "this one alone");
  app.add_flag("--coarse", request.coarse,
               "runs with coarse steps: whether they say what they are");
  app.add_option("--chapter", request.chapter, "of one chapter (default: all of them)")
      ->check(CLI::Range(std::size_t{1}, programs.size()));
  app.add_option("--seconds", request.seconds, "of processor time for an input (default 60)")
      ->check(CLI::Range(0.01, 1000.0));
  CLI11_PARSE(app, argc, argv);
  if (only) request.from = *only, request.inputs = 1;

  const int screen = dup(STDOUT_FILENO);
  terminal = dup(STDERR_FILENO);
  watch();
  const Folder folder;
  try {
    Fuzzer fuzzer(request);
    const int status = fuzzer.run();
    dprintf(screen, "%s", fuzzer.summary().c_str());
    return status;
  } catch (const std::exception& error) {
    say(fmt::format("fuzz: {}\n", error.what()));
    return 2;
  }
}
