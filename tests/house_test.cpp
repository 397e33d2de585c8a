// The rules of the house: who may know whom. Read from the sources and from the built programs.

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "catch.hpp"

namespace fs = std::filesystem;

namespace {

const fs::path source = TUTORIAL_SOURCE;

std::vector<fs::path> sources(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(source / folder))
    if (entry.path().extension() == ".hpp" || entry.path().extension() == ".cpp")
      files.push_back(entry.path());
  return files;
}

std::vector<std::string> includes(const fs::path& file) {
  static const std::regex include("\\s*#\\s*include\\s*[<\"]([^>\"]+)[>\"].*");
  std::vector<std::string> names;
  std::ifstream stream(file);
  std::smatch match;
  for (std::string line; std::getline(stream, line);)
    if (std::regex_match(line, match, include)) names.push_back(match[1]);
  return names;
}

bool starts_with_any(const std::string& text, const std::vector<std::string>& starts) {
  return std::any_of(starts.begin(), starts.end(),
                     [&](const std::string& start) { return text.starts_with(start); });
}

std::string output(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::array<char, 4096> buffer{};
  while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) text += buffer.data();
  CHECK(pclose(pipe) == 0);
  return text;
}

}  // namespace

TEST_CASE("the floors of common include only what stands below them") {
  const std::map<std::string, std::set<std::string>> may_include{
      {"mechanics", {"mechanics"}},
      {"instruments", {"instruments", "mechanics"}},
      {"app", {"app", "instruments", "mechanics"}},
      // the rooms of the first floor, and what its solver must not know
      {"mechanics/integrators", {"mechanics/integrators"}},
      {"mechanics/dynamics", {"mechanics/dynamics"}},
      {"mechanics/joints", {"mechanics/joints", "mechanics/dynamics"}},
      {"mechanics/forces", {"mechanics/forces", "mechanics/dynamics"}},
      {"mechanics/paths", {"mechanics/paths"}},
      {"mechanics/motion",
       {"mechanics/motion", "mechanics/integrators", "mechanics/joints", "mechanics/dynamics"}},
      {"instruments/draw", {"instruments/draw"}},
      {"instruments/files", {"instruments/files"}},
      {"instruments/measure",
       {"instruments/measure", "instruments/files", "mechanics/motion", "mechanics/integrators",
        "mechanics/dynamics"}},
  };
  for (const auto& entry : fs::directory_iterator(source / "common"))
    if (entry.is_directory()) REQUIRE(may_include.contains(entry.path().filename()));
  for (const auto& [folder, allowed] : may_include) {
    const auto depth = std::count(folder.begin(), folder.end(), '/') + 1;
    for (const fs::path& file : sources("common/" + folder))
      for (const std::string& name : includes(file)) {
        INFO(file << " includes " << name);
        std::size_t end = 0;
        for (auto i = 0; i < depth && end != std::string::npos; ++i) end = name.find('/', end + 1);
        const std::string first = name.substr(0, end);
        if (fs::is_directory(source / "common" / first)) CHECK(allowed.contains(first));
        CHECK(name.find("..") == std::string::npos);
        if (folder == "mechanics" && !fs::exists(source / "common" / name))
          CHECK((name.find_first_of("./") == std::string::npos || name.starts_with("Eigen/")));
      }
  }
}

TEST_CASE("a chapter builds on earlier ones only, and chapters 1 and 2 know no solver") {
  std::set<std::string> chapters;
  for (const auto& entry : fs::directory_iterator(source / "chapters"))
    if (entry.is_directory()) chapters.insert(entry.path().filename());
  for (const std::string& folder : chapters)
    for (const fs::path& file : sources("chapters/" + folder))
      for (const std::string& name : includes(file)) {
        INFO(file << " includes " << name);
        CHECK(name.find("..") == std::string::npos);
        const std::string first = name.substr(0, name.find('/'));
        if (chapters.contains(first)) CHECK(first < folder);
        if (folder < "03")
          CHECK_FALSE(starts_with_any(
              name, {"mechanics/dynamics/", "mechanics/joints/", "mechanics/motion/mechanism"}));
      }
}

TEST_CASE(
    "drawing libraries stay in instruments/draw, OpenGL in its window, Boost.Math in exact.hpp and "
    "measure") {
  for (const char* folder : {"common", "chapters"})
    for (const fs::path& file : sources(folder)) {
      const bool draw = file.parent_path().filename() == "draw";
      const bool exact = file.filename().string().starts_with("exact") ||
                         file.parent_path().filename() == "measure";
      const bool test = file.filename() == "test.cpp";
      for (const std::string& name : includes(file)) {
        INFO(file << " includes " << name);
        if (!draw || file.extension() == ".hpp")
          CHECK_FALSE(starts_with_any(name, {"imgui", "backends/", "GL/", "EGL/", "GLFW/", "png.h"}));
        if (file.filename() != "window.cpp")
          CHECK_FALSE(starts_with_any(name, {"backends/", "GL/", "EGL/", "GLFW/"}));
        if (!exact && !test) CHECK_FALSE(starts_with_any(name, {"boost/"}));
      }
    }
}

TEST_CASE("an exact answer of a chapter knows parameters and mathematics") {
  for (const fs::path& file : sources("chapters")) {
    const std::string name = file.filename();
    if (!name.starts_with("exact") && name != "scene.hpp") continue;
    for (const std::string& included : includes(file)) {
      INFO(file << " includes " << included);
      CHECK_FALSE(starts_with_any(included, {"app/", "instruments/", "mechanics/"}));
      CHECK_FALSE(starts_with_any(included, {"study", "mechanism"}));
    }
  }
}

TEST_CASE("pictures have no shape of Dear ImGui's own, whose edges differ between processors") {
  const std::regex shape("(->|\\.)(Add|Path)(?!Text\\b|FontFrom)\\w+\\(");
  for (const fs::path& file : sources("common/instruments/draw")) {
    INFO(file);
    std::ifstream stream(file);
    for (std::string line; std::getline(stream, line);) {
      INFO(line);
      CHECK_FALSE(std::regex_search(line, shape));
    }
  }
}

TEST_CASE("tests mirror common name by name") {
  for (const char* floor : {"mechanics", "instruments", "app"})
    for (const fs::path& file : sources(fs::path("tests") / floor)) {
      const std::string name = file.stem(), mark = "_test";
      if (!name.ends_with(mark)) continue;  // a helper
      INFO(file);
      const fs::path place = fs::relative(file.parent_path(), source / "tests"),
                     tested = place / name.substr(0, name.size() - mark.size());
      const auto exists = [&](const fs::path& root, const char* ending) {
        return fs::exists(fs::path(source / root / tested) += ending);
      };
      CHECK((exists("common", "") || exists("common", ".hpp") || exists("common", ".cpp") ||
             exists("tests", ".hpp")));  // the joint of the documents stands beside its test
    }
}

TEST_CASE("the top level holds what the plan names and nothing else") {
  const std::set<std::string> allowed{"README.md", "CMakeLists.txt", "CMakePresets.json",
                                      "tutorial",  "chapters",       "common",
                                      "tests",     "docs",           "LICENSE"};
  for (const auto& entry : fs::directory_iterator(source)) {
    const std::string name = entry.path().filename();
    INFO(name);
    CHECK((allowed.contains(name) || name.starts_with('.') || name.starts_with("build")));
  }
}

TEST_CASE("chapters 1 and 2 carry no solver, the solver and the integrators nothing that draws") {
  for (const auto& chapter : fs::directory_iterator(source / "chapters")) {
    if (!chapter.is_directory()) continue;
    const std::string name = chapter.path().filename(), program = TUTORIAL_BIN "/" + name;
    INFO(name);
    const std::string symbols = output("nm -C " + program);
    CHECK(symbols.find("app::run_chapter") !=
          std::string::npos);  // the symbols are readable at all
    if (name.starts_with("01") || name.starts_with("02")) {
      CHECK(symbols.find("dynamics::") == std::string::npos);
      CHECK(symbols.find("joints::") == std::string::npos);
    }
  }
  for (const char* test : {"test_dynamics", "test_integrators"}) {
    INFO(test);
    const std::string symbols = output("nm -C " TUTORIAL_BIN "/" + std::string(test));
    CHECK(symbols.find("Catch::") != std::string::npos);
    for (const char* part : {"draw::", "ImGui", "png_", "glfw"}) {
      INFO(part);
      CHECK(symbols.find(part) == std::string::npos);
    }
  }
}

TEST_CASE("a case that fails is red, whatever its number of failed checks") {
  std::istringstream lines(output(TUTORIAL_RED " || [ $? = 8 ]"));  // 8: there are red ones
  int red = 0, green = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.find(" #") == std::string::npos) continue;  // not the line of a test
    INFO(line);
    const auto says = [&](const char* word) { return line.find(word) != std::string::npos; };
    if (says("random numbers")) {
      ++green;
      CHECK(says(" Passed "));
    } else {
      ++red;
      CHECK((says("***Failed ") || says("***Exception")));
    }
  }
  CHECK(green == 2);
  CHECK(red >= 22);
}

TEST_CASE("a case sees the same random numbers alone and after others") {
  CHECK(output(TUTORIAL_BIN "/test_red '*random numbers'").find("2 test cases") !=
        std::string::npos);
}
