// The check of the documents is itself checked: it must fail when one character differs.

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>

#include "catch.hpp"

namespace fs = std::filesystem;

namespace {

/// A small tutorial: a source, a saved report, a program, and a document that shows all of them.
class Copy {
 public:
  Copy() : folder(fs::temp_directory_path() / ("documents_test_" + std::to_string(getpid()))) {
    fs::create_directories(folder / "docs");
    fs::create_directories(folder / "bin");
    write("source.hpp", "int before;\n// [part]\nint shown = 1;\n// [part]\n");
    write("bin/program", "#!/bin/sh\necho 'error 1.5e-07 m'\n[ \"$1\" != wrong ]\n");
    fs::permissions(folder / "bin/program", fs::perms::owner_all);
    fs::copy_file(fs::path(TUTORIAL_SOURCE) /
                      "chapters/01_particle_on_curve_implicit/snapshots/error_vs_time.csv",
                  folder / "report.csv");
    write("README.md",
          "# A tutorial\n\n[More](docs/more.md#some-part)\n\n    build/bin/program right\n\n"
          "<!-- excerpt: source.hpp part -->\n```cpp\n```\n\n"
          "<!-- output: program -->\n```text\n```\n\n<!-- report: report.csv -->\n```text\n```\n\n"
          "<!-- figures: program -->\n*Off by 1.5·10⁻⁷ m in `0.25` s.*\n");
    write("docs/more.md", "# More\n\n## Some part\n");
  }
  Copy(const Copy&) = delete;
  Copy& operator=(const Copy&) = delete;
  ~Copy() { fs::remove_all(folder); }

  /// The exit status of `documents` with an option.
  int documents(const std::string& option) const {
    const std::string command = "'" TUTORIAL_BIN "/documents' " + option + " '" + folder.string() +
                                "' '" + (folder / "bin").string() + "' >/dev/null 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::string read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(folder / name).rdbuf();
    return text.str();
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
  }
  void replace(const std::string& name, const std::string& from, const std::string& to) const {
    std::string text = read(name);
    REQUIRE(text.find(from) != std::string::npos);
    write(name, text.replace(text.find(from), from.size(), to));
  }

  const fs::path folder;
};

}  // namespace

TEST_CASE("the documents' check fails when one character of what they show changes") {
  const Copy copy;
  CHECK(copy.documents("--check") == 1);  // the blocks are empty
  CHECK(copy.documents("") == 0);
  CHECK(copy.read("README.md").find("int shown = 1;\n```\n") != std::string::npos);
  REQUIRE(copy.documents("--check") == 0);

  SECTION("of an excerpt's source") { copy.replace("source.hpp", "shown = 1", "shown = 2"); }
  SECTION("of an excerpt") { copy.replace("README.md", "shown = 1", "shown = 2"); }
  SECTION("of a program's output") { copy.replace("bin/program", "1.5e-07", "1.6e-07"); }
  SECTION("of a figure shown") { copy.replace("README.md", "1.5e-07", "1.4e-07"); }
  SECTION("of a table") { copy.replace("README.md", "not reached", "not reeched"); }
  SECTION("of a figure in a caption") { copy.replace("README.md", "1.5·", "1.6·"); }
  SECTION("of a saved report") { copy.replace("report.csv", "rk4,4,", "rk5,4,"); }
  SECTION("of a link's file") { copy.replace("README.md", "more.md#", "mare.md#"); }
  SECTION("of a link's heading") { copy.replace("README.md", "#some-part", "#some-port"); }
  CHECK(copy.documents("--check") == 1);
}

TEST_CASE("a paragraph with figures says by a comment where they come from") {
  const Copy copy;
  CHECK(copy.documents("--numbers") == 0);
  const auto add = [&](const std::string& text) {
    copy.write("docs/more.md", "# More\n\n## Some part 1.5\n\n" + text);
  };
  for (const char* other :
       {"`0.5`, $1.5$ and [two](../README.md)", "dop853 and RK4 on 2026-11-29", "99 runs, 10⁻⁶ m",
        "<img width=\"100\">", "| 0.5 | 100 |", "```text\n0.5\n```",
        "Box2D 2.4.1, CMake 3.22, §19.25", "*Methods 12*, 1985, 177–290",
        "<!-- given -->\nA rod\nof 0.5 m\n\nis long"}) {
    INFO(other);
    add(other);
    CHECK(copy.documents("--numbers") == 0);
  }
  for (const char* measured :
       {"It takes 0.5 s.", "*Off by\n2·10⁻⁶ m*", "- after 120 steps", "1.5e-07 in 1985",
        "in 2000 steps", "<!-- given -->\nA rod of 0.5 m\n\nis 0.7 m off",
        "```text\n```\n56 000 m"}) {
    INFO(measured);
    add(measured);
    CHECK(copy.documents("--numbers") == 1);
  }
}

TEST_CASE("a command that the documents show and that does not run is a fault") {
  const Copy copy;
  CHECK(copy.documents("--commands") == 0);
  copy.replace("README.md", "program right", "program wrong");
  CHECK(copy.documents("--commands") == 1);
  copy.replace("README.md", "bin/program wrong", "bin/pragram right");
  CHECK(copy.documents("--commands") == 1);
}

TEST_CASE("times of a table that a new measurement does not find again are named") {
  const Copy copy;
  const std::string saved = "chapters/one/snapshots/error_vs_time.csv";
  fs::create_directories((copy.folder / saved).parent_path());
  copy.write(saved, copy.read("report.csv"));
  copy.write("docs/more.md", "# More\n\n## Some part\n\n<!-- report: " + saved + " -->\n");
  const auto measured =
      [&](const std::string& change) {  // by a program that was so many times slower
        copy.write("bin/one",
                   "#!/bin/sh\nmkdir -p \"$3\"\nawk -F, -v OFS=, '/^[a-z]/ && !/^method/ { " +
                       change + " } 1' " + saved + " > \"$3/error_vs_time.csv\"\n");
        fs::permissions(copy.folder / "bin/one", fs::perms::owner_all);
        return copy.documents("--times");
      };
  CHECK(measured("$7 *= 1.5") == 0);
  CHECK(measured("$7 *= 2.5") == 1);
  CHECK(measured("$7 *= 0.4") == 1);
  CHECK(measured("if ($1 == \"rk4\") $7 *= 2.5") == 1);
}
