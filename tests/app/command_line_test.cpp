// The contract of the command line, asked of every chapter's program as a user would ask it.

#include <fmt/format.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "catch.hpp"
#include "instruments/measure/clock.hpp"
#include "instruments/measure/report.hpp"

namespace fs = std::filesystem;

namespace {

std::string slurp(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// An empty folder that goes away with the test.
struct Folder {
  fs::path path = fs::temp_directory_path() / fmt::format("command_line_test_{}", getpid());
  Folder() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() { fs::remove_all(path); }
};

struct Result {
  int status;
  std::string out, err;
};

Result shell(const std::string& command) {
  const fs::path base = fs::temp_directory_path() / fmt::format("command_line_test_{}_", getpid());
  const std::string out = base.string() + "out", err = base.string() + "err";
  const int status =
      std::system(fmt::format("( {} ) >{} 2>{} </dev/null", command, out, err).c_str());
  Result result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(out), slurp(err)};
  fs::remove(out);
  fs::remove(err);
  return result;
}

std::vector<std::string> chapters() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(TUTORIAL_SOURCE "/chapters"))
    if (entry.is_directory()) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

std::string program(const std::string& chapter) { return TUTORIAL_BIN "/" + chapter; }

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void check_refused(const std::string& command, const std::string& named, int status = 2) {
  INFO(command);
  const Result result = shell(command);
  INFO(result.err);
  CHECK(result.status == status);
  CHECK(result.out.empty());
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK(holds(result.err, named));
}

}  // namespace

TEST_CASE("a run says what its scene uses and what was left out, as counted by hand") {
  // bodies have 3 coordinates, particles 2; the ground's rows are 3, a pin's and a rail's 2
  const std::vector<std::string> uses{
      "1 thing, 2 coordinates, 1 row of rank 1, 1 degree of freedom, 32 bytes of state, ",
      "1 thing, 1 coordinate, 0 rows of rank 0, 1 degree of freedom, 16 bytes of state, ",
      "2 things, 4 coordinates, 3 rows of rank 3, 1 degree of freedom, 4 blocks of J, 5 of the "
      "factor "
      "of J W Jᵀ, 64 bytes of state, ",
      "1 thing, 3 coordinates, 3 rows of rank 3, 0 degrees of freedom, 1 block of J, 1 of the "
      "factor "
      "of J W Jᵀ, 48 bytes of state, ",
      "1 thing, 3 coordinates, 2 rows of rank 2, 1 degree of freedom, 1 block of J, 1 of the "
      "factor "
      "of J W Jᵀ, 48 bytes of state, ",
      "1 thing, 3 coordinates, 2 rows of rank 2, 1 degree of freedom, 1 block of J, 1 of the "
      "factor "
      "of J W Jᵀ, 48 bytes of state, ",
      "3 things, 9 coordinates, 8 rows of rank 8, 1 degree of freedom, 6 blocks of J, 7 of the "
      "factor "
      "of J W Jᵀ, 144 bytes of state, ",
      "1 thing, 1 coordinate, 0 rows of rank 0, 1 degree of freedom, 16 bytes of state, ",
      "3 things, 9 coordinates, 9 rows of rank 9, 0 degrees of freedom, 7 blocks of J, 10 of the "
      "factor of J W Jᵀ, 144 bytes of state, "};
  const std::vector<std::string> names = chapters();
  REQUIRE(names.size() == uses.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string out = shell(program(names[i]) + " run").out;
    INFO(out);
    CHECK(holds(out, "\nuses: " + uses[i]));
    CHECK(holds(out, " ns a step\n"));
    CHECK(holds(out, "\nbuilt without optimisation") == !measure::optimised);
  }
  const std::string crank = program("07_slider_crank") + " run ";
  CHECK(holds(shell(crank).out, "\nleft out: the frame, feedback, projection\n"));
  CHECK(holds(shell(crank + "--simulate-frame 1 --stabilization projection").out,
              "\nuses: 4 things, 12 coordinates, 11 rows of rank 11, 1 degree of freedom"));
  CHECK(
      holds(shell(crank + "--stabilization feedback").out, "\nleft out: the frame, projection\n"));
  CHECK(holds(shell(program(names[2]) + " run").out, "\nleft out: angles, feedback, projection\n"));
}

TEST_CASE("help names every option with its unit and exits with 0") {
  for (const std::string& chapter : chapters()) {
    INFO(chapter);
    const Result top = shell(program(chapter) + " --help");
    CHECK(top.status == 0);
    for (const char* command : {"run", "report"}) CHECK(holds(top.out, command));
    const Result run = shell(program(chapter) + " run --help");
    CHECK(run.status == 0);
    for (const char* option :
         {"--duration [s]", "--step [s]", "--integrator", "--stabilization", "--ks [1/s^2]",
          "--kd [1/s]", "--tolerance", "--every [s]", "--csv FILE", "keeps the energy to 1 %"}) {
      INFO(option);
      CHECK(holds(run.out, option));
    }
    CHECK(run.err.empty());
  }
}

TEST_CASE("without --step a run keeps its energy to 1 %, in a faster scene too") {
  struct Run {
    const char *chapter, *options;
    double energy;  ///< that becomes motion, at least [J]
  };
  for (const auto& [chapter, options, energy] :
       {Run{"01_particle_on_curve_implicit", "--p 1 --x0 40", 9.81 * 800.0},  // m g x0²/2p
        Run{"02_parametric_lagrangian", "--p 1 --x0 40", 9.81 * 800.0},
        Run{"03_global_jacobian_solver", "--p 2", 9.81 * 100.0},  // bead1 falls x1²/2p
        Run{"05_revolute", "--links 20", 9.81 / 2.0},             // M g L/2
        Run{"05_revolute", "--length 0.01 --gravity 1000", 5.0},
        Run{"06_prismatic", "--spin 1000", 0.5e6},  // of the rail, 1 kg·m²
        Run{"06_prismatic", "--stiffness 1e8 --s0 0.1", 5e5},
        Run{"07_slider_crank", "--omega0 500", 0.02e6},  // of the wheel, 0.16 kg·m²
        Run{"08_paths", "--radius 0.01", 0.19},          // m g (y(0) − y(q0))
        Run{"08_paths", "--path circle --by length --speed 40", 800.0}}) {
    const bool one = chapter[1] == '2' || chapter[1] == '8';  // coordinate
    const std::string method = one ? "" : " --stabilization projection";
    const std::string command = fmt::format("{} run {}{}", program(chapter), options, method);
    INFO(command);
    const std::string out = shell(command).out, name = "energy error";
    INFO(out);
    REQUIRE(holds(out, name));
    CHECK(std::stod(out.substr(out.find(name) + name.size())) < 0.01 * energy);
  }
}

TEST_CASE("with a damper the energy is not compared, and the velocity is") {
  const std::string stiff = program("06_prismatic") +
                            " run --incline 0 --stiffness 1e4 --damping 1e5 --s0 0.1 --step 0.25 "
                            "--integrator implicit_midpoint --v0 ";
  const Result slow = shell(stiff + "-0.01000001"), kicked = shell(stiff + "1 --strict");
  CHECK(slow.status == 0);
  CHECK(slow.err.empty());
  CHECK(holds(slow.out, "energy error                not compared: a load takes energy"));
  CHECK(holds(slow.out, "8.53e-07 m"));
  CHECK(kicked.status == 1);
  CHECK(holds(kicked.err, "the velocity is off by"));
}

TEST_CASE("the CSV has the contract's columns, all finite, and standard output holds it alone") {
  for (const std::string& chapter : chapters()) {
    INFO(chapter);
    const Result result = shell(program(chapter) + " run --duration 0.5 --step 0.01 --csv -");
    REQUIRE(result.status == 0);
    CHECK(result.err.empty());
    const std::vector<std::string> lines = split(result.out, '\n');
    REQUIRE(lines.size() == 52);
    const std::vector<std::string> header = split(lines[0], ',');
    CHECK(header.front() == "t");
    for (const char* column : {"energy", "constraint_error", "velocity_error"})
      CHECK(std::count(header.begin(), header.end(), column) == 1);
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const std::vector<std::string> cells = split(lines[i], ',');
      REQUIRE(cells.size() == header.size());
      for (const std::string& cell : cells) CHECK(std::isfinite(std::stod(cell)));
    }
  }
  const auto header = [](const std::string& chapter) {
    return split(shell(program(chapter) + " run --duration 0.01 --csv -").out, '\n').at(0);
  };
  const std::string particle =
      "particle.x,particle.y,particle.vx,particle.vy,energy,constraint_error,velocity_error,"
      "particle_curve.fx,particle_curve.fy,particle_curve.moment";
  CHECK(header("01_particle_on_curve_implicit") == "t," + particle);
  CHECK(header("02_parametric_lagrangian") == "t,q,qdot," + particle);
  CHECK(header("08_paths") ==
        "t,q,speed,particle.x,particle.y,particle.vx,particle.vy,energy,constraint_error,"
        "velocity_error,particle_path.fx,particle_path.fy,particle_path.moment");
}

TEST_CASE(
    "rows are thinned by --every, which keeps first and last, and does not change the motion") {
  for (const std::string& chapter : chapters()) {
    INFO(chapter);
    const auto every =
        split(shell(program(chapter) + " run --duration 0.5 --step 0.01 --csv -").out, '\n');
    const auto some =
        split(shell(program(chapter) + " run --duration 0.5 --step 0.01 --every 0.125 --csv -").out,
              '\n');
    REQUIRE(some.size() == 6);
    CHECK(some[1] == every[1]);
    CHECK(some[2] == every[1 + 13]);  // the first step at or after 0.125 s
    CHECK(some[3] == every[1 + 25]);
    CHECK(some[5] == every[1 + 50]);
  }
}

TEST_CASE("a duration that is no whole number of steps is reached exactly") {
  const auto lines =
      split(shell(program(chapters()[0]) + " run --duration 1 --step 0.3 --csv -").out, '\n');
  REQUIRE(lines.size() == 6);
  CHECK(std::stod(lines.back()) == 1.0);
}

TEST_CASE(
    "with a tolerance dop853 chooses its own steps, and rows stand where they are asked for") {
  for (const std::string& chapter : chapters()) {
    INFO(chapter);
    const std::string run =
        program(chapter) + " run --duration 0.5 --integrator dop853 --tolerance 1e-8";
    const Result fine = shell(run + " --every 0.1 --step 0.1 --csv -");
    CHECK(fine.status == 0);
    CHECK(split(fine.out, '\n').size() == 7);
    CHECK(holds(shell(run).out, "steps of its own choice"));
    check_refused(program(chapter) + " run --tolerance 1e-8", "--tolerance");
    check_refused(program(chapter) + " run --integrator dop853 --tolerance 0", "--tolerance");
  }
}

TEST_CASE(
    "what --without leaves out stands in the help, and the constraints or the energy miss it") {
  struct Term {
    std::string chapter, name, run, error;
    double least;  ///< of what the run prints of that error
  };
  for (const Term& term : std::vector<Term>{
           {"01_particle_on_curve_implicit", "jdotv", "--duration 6", "constraint error", 1.0},
           {"02_parametric_lagrangian", "velocity-term", "", "energy error", 1.0},
           {"03_global_jacobian_solver", "coupling", "--duration 3", "constraint error", 1.0},
           {"05_revolute", "jdotv", "--duration 0.5", "constraint error", 0.01},
           {"06_prismatic", "coriolis", "--spin 5 --duration 0.4", "constraint error", 0.01},
           {"07_slider_crank", "jdotv", "--duration 1", "constraint error", 0.01}}) {
    const std::string run = program(term.chapter) + " run " + term.run;
    INFO(run);
    CHECK(holds(shell(program(term.chapter) + " run --help").out, term.name + ": "));
    const auto error = [&](const std::string& options) {
      const std::string text = shell(run + options).out;
      const std::size_t at = text.rfind(term.error);
      return at == std::string::npos ? -1.0 : std::stod(text.substr(text.find("  ", at)));
    };
    CHECK(error(" --without " + term.name) > term.least);
    const std::string warning = shell(run + " --without " + term.name).err;
    CHECK(holds(warning, "; --without " + term.name + " leaves out a term of the equation"));
    CHECK_FALSE(holds(warning, "try "));
    CHECK(error("") < 1e-3 * term.least);
    check_refused(run + " --without friction",
                  "--without friction: allowed is one of " + term.name);
  }
  check_refused(program("06_prismatic") + " run --without coriolis",
                "--without coriolis: allowed only with --spin");
}

TEST_CASE("without a caption a picture is another, and its sentence is printed all the same") {
  const Folder folder;
  const std::string with = folder.path / "with", without = folder.path / "without";
  const std::string snapshot = program("04_ground") + " snapshot --at 0 --scale 0.5 --out ";
  const Result captioned = shell(snapshot + with),
               bare = shell(snapshot + without + " --no-caption");
  CHECK(captioned.status == 0);
  CHECK(split(captioned.out, '\n')[1] == split(bare.out, '\n')[1]);
  CHECK(slurp(with + "/at_0s.png") != slurp(without + "/at_0s.png"));
}

TEST_CASE("the same run writes the same bytes") {
  const Folder folder;
  for (const std::string& chapter : chapters()) {
    INFO(chapter);
    const std::string base = folder.path.string() + "/" + chapter;
    for (const char* copy : {"a", "b"}) {
      CHECK(shell(fmt::format("{} run --duration 1 --csv {}{}.csv", program(chapter), base, copy))
                .status == 0);
      CHECK(shell(fmt::format("{} snapshot --at 0.5 --scale 1 --out {}{}", program(chapter), base,
                              copy))
                .status == 0);
    }
    CHECK(slurp(base + "a.csv") == slurp(base + "b.csv"));
    CHECK(slurp(base + "a.csv").size() > 1000);
    CHECK(slurp(base + "a/at_0.5s.png") == slurp(base + "b/at_0.5s.png"));
    CHECK(slurp(base + "a/at_0.5s.png").size() > 5000);
  }
}

TEST_CASE("without arguments a chapter runs the loop of its main and prints its error") {
  for (const std::string& chapter : chapters()) {
    INFO(chapter);
    const auto ran = shell(program(chapter));
    CHECK(ran.status == 0);
    CHECK(holds(ran.out, "error"));
    CHECK(ran.err.empty());
  }
}

TEST_CASE("unusable arguments: one line that names them, exit status 2") {
  const std::vector<std::string> names = chapters();
  for (const std::string& chapter : names) {
    // How a number is read is one code: all its ways to be wrong are tried in one chapter.
    const auto of = [&](std::vector<std::string> bad) {
      if (chapter != names.front()) bad.resize(1);
      return bad;
    };
    const std::string p = program(chapter) + " ";
    check_refused(p + "fly", "fly");
    check_refused(p + "run --fly 3", "--fly");
    check_refused(p + "run --step", "--step");
    for (const std::string& bad : of({"0", "-1", "nan", "inf", "1e400", "abc", "''", "1e-300"})) {
      check_refused(p + "run --step " + bad, "--step");
      check_refused(p + "run --duration " + bad, "--duration");
    }
    check_refused(p + "run --step 1e-9 --duration 1e6", "--step 1e-09");
    check_refused(p + "run --every -1", "--every -1");
    check_refused(p + "run --every 0.001 --step 0.01", "--every 0.001");
    check_refused(p + "run --integrator euler", "--integrator euler");
    check_refused(p + "run --stabilization glue", "--stabilization glue");
    check_refused(p + "run --stabilization none --ks 1", "--ks 1");
    CHECK(shell(p + "run --duration 0.1 --stabilization none").status == 0);
    check_refused(p + "run --ks -1", "--ks -1");
    check_refused(p + "run --csv /nowhere/at/all.csv", "--csv /nowhere/at/all.csv");
    check_refused(p + "run --csv /dev/full", "--csv /dev/full");
    check_refused(p + "report --out /proc/none", "--out /proc/none");
    check_refused(p + "report --out /dev/null", "--out /dev/null");
    check_refused(p + "snapshot --out /proc/none", "--out /proc/none");
    check_refused(p + "snapshot --size 10x10", "--size 10x10");
    check_refused(p + "snapshot --size 960", "--size 960");
    check_refused(p + "snapshot --size 96e1x600y", "--size");
    check_refused(p + "snapshot --scale 0", "--scale 0");
    check_refused(p + "snapshot --theme pink", "--theme pink");
    check_refused(p + "snapshot --at 1,x", "--at x");
    check_refused(p + "snapshot --at -1", "--at -1");
    for (const std::string& bad : of({"0", "-1", "1.5", "100001", "x"}))
      check_refused(p + "snapshot --frames " + bad, "--frames " + bad);
    check_refused(p + "snapshot --fps 30", "--fps 30");
    for (const std::string& bad : of({"0", "1001", "nan"}))
      check_refused(p + "snapshot --frames 2 --fps " + bad, "--fps " + bad);
    for (const std::string& bad : of({"4", "0x3", "4x21", "4x3x2", "4.5x3", "x"}))
      check_refused(p + "snapshot --sheet " + bad, "--sheet " + bad);
    check_refused(p + "snapshot --sheet 20x20", "--sheet 20x20");  // too small to be made out
    check_refused(p + "snapshot --sheet 6x2 --size 480x300", "--sheet 6x2");
    check_refused(p + "snapshot --sheet 2x2 --duration 2 --step 1", "--sheet 2x2");
    check_refused(p + "snapshot --frames 3 --sheet 4x3", "--sheet 4x3");
    check_refused(p + "snapshot --frames 3 --fps 51 --step 0.02", "--fps 51");  // some twice
    check_refused(p + "snapshot --frames 3 --at 1", "--at 1");
    check_refused(p + "snapshot --sheet 2x1 --at 0,0.1,0.2", "--sheet 2x1");
    check_refused(p + "snapshot --frames 100000 --fps 0.001 --step 0.001", "--frames 100000");
  }
  const std::string p = program("01_particle_on_curve_implicit") + " run ";
  for (const char* option : {"--mass", "--p"})
    for (const char* bad : {"0", "-2", "nan", "1e13"})
      check_refused(p + option + " " + bad, option);
  check_refused(p + "--gravity -1", "--gravity -1");
  check_refused(p + "--x0 1e13", "--x0 1e13");
  const std::string block = program("06_prismatic");
  for (const char* option : {"--stiffness", "--damping"})
    for (const char* bad : {"-1", "nan", "inf", "1e13", "stiff"})
      check_refused(block + " run " + option + " " + bad, std::string(option) + " " + bad);
  for (const char* option : {"--s0", "--v0"})
    for (const char* bad : {"nan", "1e7", "-1e7"})
      check_refused(block + " run " + option + " " + bad, std::string(option) + " " + bad);
  for (const char* option : {"--stiffness 100", "--damping 2.5", "--s0 0.1", "--v0 -1"})
    for (const char* command : {" run", " report", " snapshot --at 0"})
      check_refused(block + command + " --spin 5 " + option, option);
  check_refused(program("02_parametric_lagrangian") + " run --stabilization projection",
                "--stabilization projection");
  check_refused(program("02_parametric_lagrangian") + " run --kd 1", "--kd 1");
  const std::string wire = program("08_paths") + " run --path ";
  check_refused(wire + "snail", "--path snail: allowed is one of cycloid, line, ");
  check_refused(wire + "circle --by angle", "--by angle: allowed is one of parameter, length");
  check_refused(wire + "cubic --points '0,0 1,1'", "--points 0,0 1,1: a cubic needs 4, not 2");
  check_refused(wire + "line --points '1,1 1,1'", "--points 1,1 1,1: all of a line are (1, 1)");
  check_refused(wire + "linear_spline --points '0,0 1,1 1,1'", "two in a row");
  check_refused(wire + "hermite_spline --tangents '1,0'", "--tangents 1,0: ");
  check_refused(wire + "projectile --launch 0,-1", "--launch 0,-1: straight up");
  // What helps over a corner, and beside it: the length. What |x'| does not disturb: the step.
  CHECK(shell(wire + "linear_spline --by parameter").err.ends_with("; try --by length\n"));
  CHECK(holds(shell(wire + "cycloid --q0 3.1415926").err,
              "energy does not reach; try --by length, a smaller --step"));
  CHECK(holds(shell(wire + "circle --step 0.5").err, "; try a smaller --step"));
  check_refused(wire + "line --q0 2", "--q0 2: allowed is a place on the wire, 0 to 1");
  check_refused(wire + "cycloid --q0 3.141592653589793", "--q0 3.14159: there x' = 0");
  check_refused(wire + "sequence --file none", "--file none: cannot be read");
}

TEST_CASE("report of chapter 6 measures the fixed rail where an option speaks of it") {
  const Folder folder;
  const auto first_error = [&](const std::string& options) {
    const Result result =
        shell(fmt::format("{} report --integrator rk4 --duration 0.4 --step 0.1 --out {} {}",
                          program("06_prismatic"), folder.path.string(), options));
    INFO(options << "\n" << result.err);
    REQUIRE(result.status == 0);
    return measure::read_csv(folder.path / "error_vs_time.csv").rungs.front().errors.at(0);
  };
  CHECK(first_error("") > 1e-6);  // that of the rail that turns
  for (const char* options : {"--incline 20", "--gravity 3", "--s0 1", "--v0 1", "--damping 0"})
    CHECK(first_error(options) < 1e-14);  // RK4 is exact there
  CHECK(first_error("--spin 5 --gravity 3") > 1e-6);
}

TEST_CASE("a full disk: one line, exit status 1, nothing left under the name") {
  if (!fs::exists("/dev/full")) return;
  for (const std::string& chapter : chapters()) {
    check_refused(program(chapter) + " run --csv - >/dev/full", "standard output", 1);
    check_refused(program(chapter) + " run >/dev/full", "standard output", 1);
  }
}

TEST_CASE(
    "a run that cannot go on: the time, what failed, what to try, exit status 1 and no file") {
  const Folder folder;
  const std::string file = (folder.path / "run.csv").string();
  for (const char* chapter : {"01_particle_on_curve_implicit", "02_parametric_lagrangian"}) {
    const std::string command = fmt::format(
        "{} run --integrator explicit_euler --duration 1e9 --step 1e6 --x0 1e10", program(chapter));
    check_refused(command + " --csv " + file, "stopped at t = ", 1);
    CHECK(fs::is_empty(folder.path));
    const Result result = shell(command + " --csv -");
    CHECK(result.status == 1);
    CHECK(holds(result.err, "--step"));
    CHECK(!holds(result.out, "nan"));
    CHECK(!holds(result.out, "inf"));
  }
}

TEST_CASE("a bead that leaves its wire: the time, exit status 1 and no file") {
  const Folder folder;
  check_refused(program("08_paths") + " run --path cubic --duration 2 --csv " +
                    (folder.path / "run.csv").string(),
                "leaves the wire at t = 1.1628910", 1);
  CHECK(fs::is_empty(folder.path));
}

TEST_CASE(
    "a run that is far from right says so, with its table too, and with --strict ends with 1") {
  struct Torn {
    const char *command, *what;
  };
  const auto run = GENERATE(
      Torn{"07_slider_crank run --duration 30", "joints are open by "},
      Torn{"05_revolute run --links 3 --integrator dop853 --tolerance 0.1", "joints are open by "},
      Torn{"05_revolute run --step 0.5", "the position is off by 8.5 m"},
      Torn{"05_revolute run --links 30 --step 0.002 --duration 2", "joints are open by "},
      Torn{"05_revolute run --step 5 --stabilization projection", "the energy balance is off by "},
      Torn{"01_particle_on_curve_implicit run --integrator semi_implicit_euler --duration 400 "
           "--step 53.7",
           "the position is off by "});
  INFO(run.command);
  Result result = shell(program(run.command));
  CHECK(result.status == 0);
  CHECK(result.err.starts_with("warning: "));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK(holds(result.err, run.what));
  CHECK(holds(result.err, "since t = "));
  CHECK(holds(result.err, "; try "));
  CHECK(holds(result.out, "far from right: "));
  const std::string warning = result.err;
  result = shell(program(run.command) + std::string(" --csv -"));
  CHECK(result.status == 0);
  CHECK(result.err == warning);
  Folder folder;
  check_refused(
      fmt::format("cd {} && {} --strict --csv run.csv", folder.path.string(), program(run.command)),
      run.what, 1);
  CHECK(fs::is_empty(folder.path));
}

TEST_CASE("a run that is right says nothing, and --strict lets it pass") {
  for (const std::string& chapter : chapters()) {
    INFO(chapter);
    const Result result = shell(program(chapter) + " run --strict");
    CHECK(result.status == 0);
    CHECK(result.err.empty());
    CHECK_FALSE(holds(result.out, "far from right"));
  }
  for (const char* command :
       {"04_ground run --load 0 --offset-x 0.1",
        "04_ground run --load 0 --offset-x 0.1 --ks 25 --kd 10",
        "04_ground run --offset-x 0.1 --offset-theta 1 --stabilization projection",
        "04_ground run --load 0 --offset-x 1e-3 --ks 72900 --kd 540 --step 0.01 --duration 3",
        "05_revolute run --integrator dop853 --tolerance 1e-12 --stabilization projection "
        "--duration 9000",
        "07_slider_crank run --crank 1 --rod 1 --stabilization projection --duration 20"}) {
    INFO(command);
    const Result result = shell(program(command) + std::string(" --strict"));
    CHECK(result.status == 0);
    CHECK(result.err.empty());
    CHECK_FALSE(holds(result.out, "could not bring"));
  }
}

TEST_CASE("a tolerance is kept, or it is said that it was not") {
  // Through singular poses: right to ten times the tolerance, as a part of the state, or told.
  for (const char* tolerance : {"1e-5", "1e-7", "1e-9", "1e-10", "1e-11", "1e-13"})
    for (const char* scene : {"--omega0 5 --torque 0 --gravity 0 --duration 6.093825719263892",
                              "--omega0 5 --duration 3", "--omega0 -7 --torque 0 --duration 4"}) {
      const std::string command = fmt::format(
          "{} run --rod 0.3 {} --integrator dop853 --stabilization projection --tolerance {}",
          program("07_slider_crank"), scene, tolerance);
      INFO(command);
      const Result result = shell(command);
      if (result.status == 1) {
        CHECK(holds(result.err, "tolerance"));
        continue;
      }
      REQUIRE(result.status == 0);
      const auto number = [&](const std::string& name) {
        const std::size_t at = result.out.find("  " + name + " ");
        REQUIRE(at != std::string::npos);
        return std::stod(result.out.substr(at + 2 + name.size()));
      };
      const double state = std::hypot(number("wheel.theta"), number("rod.theta"));
      const bool kept = number("wheel angle") < 10.0 * std::stod(tolerance) * state;
      CHECK((kept || holds(result.err, "was not kept") || holds(result.err, "position is off")));
    }
}

TEST_CASE("feedback beyond the limit of the step is warned about once") {
  const std::string p =
      program("01_particle_on_curve_implicit") + " run --duration 0.1 --step 0.01 ";
  const Result wild = shell(p + "--ks 90000");
  CHECK(wild.status == 0);
  CHECK(std::count(wild.err.begin(), wild.err.end(), '\n') == 1);
  CHECK(holds(wild.err, "up to 0.00928 s"));  // 2.7853 / 300
  CHECK(shell(p + "--ks 100").err.empty());
}

TEST_CASE(
    "a run that diverges says when, where, by which measure and what to try, its rows stand") {
  const Result result = shell(program("07_slider_crank") + " run --ks 1e8 --csv -");
  CHECK(result.status == 1);
  for (const char* part : {"stopped at t = 0.00", "kinetic energy", "most of it in ", " row ",
                           "--step of 0.000278 s or less", "--stabilization projection"}) {
    INFO(part << " in " << result.err);
    CHECK(holds(result.err, part));
  }
  const std::vector<std::string> lines = split(result.out, '\n');
  REQUIRE(lines.size() > 2);
  for (std::size_t i = 1; i < lines.size(); ++i)
    for (const std::string& cell : split(lines[i], ',')) CHECK(std::isfinite(std::stod(cell)));
}

TEST_CASE("the summary lists the times without full rank and the rows that depended") {
  const Result result =
      shell(program("07_slider_crank") +
            " run --rod 0.3 --torque 0 --gravity 0 --omega0 9 --theta0 0 --duration 4 "
            "--stabilization projection");
  REQUIRE(result.status == 0);
  // A dead centre at every odd multiple of a quarter turn that the wheel has passed.
  const std::size_t at = result.out.find("wheel.theta");
  const double theta = std::stod(result.out.substr(at + 11));
  const int passed = static_cast<int>(theta / std::numbers::pi + 0.5);
  CHECK(passed > 4);
  CHECK(holds(result.out, fmt::format("J loses rank {} times, at t = ", passed)));
  CHECK(holds(result.out, "(slider_rod row 2)"));
  // None at all where the rod is longer, if only by a little, or the crank stays away.
  CHECK_FALSE(holds(shell(program("07_slider_crank") + " run --rod 0.31").out, "loses rank"));
  CHECK_FALSE(holds(shell(program("07_slider_crank") + " run").out, "loses rank"));
}

TEST_CASE("stability writes its table and its map, and says how many cases ended otherwise") {
  const Folder folder;
  const Result result = shell(fmt::format(
      "{} stability --out {}", program("01_particle_on_curve_implicit"), folder.path.string()));
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  CHECK(holds(result.out, "cases, 0 not as expected"));
  CHECK(holds(slurp(folder.path / "stability.csv"), "case;measured;expected;found;as expected"));
  CHECK(split(slurp(folder.path / "stability_map.csv"), '\n').size() == 1 + 5 * 24 * 24);
  CHECK(slurp(folder.path / "stability_map.png").size() > 5000);
  check_refused(program("04_ground") + " stability --out /proc/none", "--out /proc/none");
  check_refused(program("04_ground") + " stability --step 1", "--step");
}

namespace {

std::vector<std::string> files_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

bool whole_png(const fs::path& path) {
  const std::string bytes = slurp(path);
  return bytes.starts_with("\x89PNG") && bytes.ends_with("IEND\xae\x42\x60\x82");
}

}  // namespace

TEST_CASE("on a terminal long work says how far it is, however long a step takes") {
  const std::vector<std::string> runs{
      " run --links 1000 --integrator implicit_midpoint --step 0.0005",
      " run --links 300 --integrator dop853 --tolerance 1e-9 --step 5",  // one interval
  };
  for (const std::string& run : runs) {
    INFO(run);
    int terminal = -1;
    const pid_t pid = forkpty(&terminal, nullptr, nullptr, nullptr);
    REQUIRE(pid >= 0);
    if (pid == 0) {
      const std::string command = "exec " + program("05_revolute") + run + " >/dev/null";
      execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      _exit(127);
    }
    std::string seen;
    std::array<char, 256> some{};
    while (!holds(seen, "simulated, ")) {  // else it runs until it is done, and the end is seen
      const ssize_t n = read(terminal, some.data(), some.size());
      if (n <= 0) break;
      seen.append(some.data(), static_cast<std::size_t>(n));
    }
    kill(pid, SIGTERM);
    waitpid(pid, nullptr, 0);
    close(terminal);
    CHECK(holds(seen, " % simulated, "));
  }
}

TEST_CASE("a series is numbered, in step with its frames a second, and each picture is whole") {
  const Folder folder;
  for (const std::string& chapter : chapters()) {
    INFO(chapter);
    const std::string out = (folder.path / chapter).string(),
                      p = program(chapter) + " snapshot --size 480x300 --scale 0.5 --out " + out;
    const Result result = shell(p + " --frames 6 --fps 20");
    INFO(result.err);
    CHECK(result.status == 0);
    CHECK(result.out == fmt::format("{0}/frame_0001.png\nto {0}/frame_0006.png\n", out));
    CHECK(files_in(out) == std::vector<std::string>{"frame_0001.png", "frame_0002.png",
                                                    "frame_0003.png", "frame_0004.png",
                                                    "frame_0005.png", "frame_0006.png"});
    for (const std::string& name : files_in(out)) CHECK(whole_png(fs::path(out) / name));
    CHECK(slurp(out + "/frame_0001.png") != slurp(out + "/frame_0006.png"));
    CHECK(shell(p + " --frames 1 --fps 1000").status == 0);
    CHECK(shell(p + " --at 0.25,0.250").out.find("at_0.25s") ==
          shell(p + " --at 0.25").out.rfind("at_0.25s"));
    if (chapter.starts_with("05")) {
      // Pictures stand closer than the longest step of a tolerance, and a run that diverges is
      // stopped however long the --duration.
      CHECK(shell(p + " --frames 3 --fps 50 --integrator dop853 --tolerance 1e-8").status == 0);
      CHECK(
          holds(shell(p + " --at 0.333 --integrator dop853 --tolerance 1e-8").out, "t = 0.333 s"));
      CHECK(slurp(out + "/frame_0002.png") != slurp(out + "/frame_0001.png"));
      CHECK(slurp(out + "/frame_0002.png") != slurp(out + "/frame_0003.png"));
      CHECK(shell(p + " --frames 20 --fps 10 --integrator explicit_euler --step 0.02 --links 3 "
                      "--duration 5000")
                .status == 1);
    }
    if (chapter.starts_with("04"))  // nothing there changes with what is still to come
      CHECK(slurp(out + "/frame_0006.png").size() == slurp(out + "/at_0.25s.png").size());
  }
}

TEST_CASE("a sheet shows the scene at equal times or at chosen ones") {
  const Folder folder;
  const std::string out = folder.path.string();
  for (const std::string& chapter : chapters()) {
    INFO(chapter);
    const std::string p = program(chapter) + " snapshot --sheet 3x2 --scale 1 --out " + out;
    CHECK(shell(p).out == out + "/sheet.png\n");
    CHECK(whole_png(folder.path / "sheet.png"));
    const std::string equal_times = slurp(folder.path / "sheet.png");
    CHECK(shell(p + " --at 0.3,0.1").status == 0);
    CHECK(slurp(folder.path / "sheet.png") != equal_times);
    CHECK(files_in(folder.path) == std::vector<std::string>{"sheet.png"});
  }
}

TEST_CASE("a series that is interrupted leaves whole pictures and nothing else") {
  const Folder folder;
  std::vector<std::string> names;
  for (int seconds = 1; names.size() < 2 && seconds < 100; seconds *= 2) {  // a machine may be slow
    const Result result = shell(
        fmt::format("timeout -s INT {} {} snapshot --frames 100000 --fps 100 --scale 1 --out {}",
                    seconds, program("01_particle_on_curve_implicit"), folder.path.string()));
    CHECK(result.status == 124);
    names = files_in(folder.path);
  }
  CHECK(names.size() > 1);
  for (const std::string& name : names) {
    INFO(name);
    CHECK(name.starts_with("frame_"));
    CHECK(whole_png(folder.path / name));
  }
}

#ifdef TUTORIAL_WINDOW

TEST_CASE("without a display live names what draws without one") {
  for (const std::string& chapter : chapters())
    for (const char* names_none : {"-u XDG_RUNTIME_DIR", "XDG_RUNTIME_DIR=none",
                                   "XDG_RUNTIME_DIR=/none", "-u XDG_RUNTIME_DIR DISPLAY=:9999"})
      check_refused(
          fmt::format("env -u DISPLAY -u WAYLAND_DISPLAY {} {} live", names_none, program(chapter)),
          chapter + ": live: no display; `snapshot` draws pictures without one", 1);
}

#else

TEST_CASE("a build without a window has no live") {
  for (const std::string& chapter : chapters())
    check_refused(program(chapter) + " live", "command live");
}

#endif
