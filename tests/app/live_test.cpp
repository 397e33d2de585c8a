// The window, driven as a reader would drive it: on a display of its own (Xvfb), with a mouse and
// keys that are moved from outside (xdotool), and looked at pixel by pixel.

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "ask_to_close.hpp"
#include "catch.hpp"
#include "instruments/draw/image.hpp"
#include "picture_check.hpp"

namespace fs = std::filesystem;

namespace {

constexpr int page_width = 960, page_height = 600;

std::string slurp(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

void sleep_for(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// A folder that goes away with the test, and the processes that write there.
class Session {
 public:
  explicit Session(const std::string& screen = "1320x840") {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    // Xvfb looks for a free display by itself and says which.
    start_process(server_, "Xvfb",
                  {"-displayfd", "1", "-screen", "0", screen + "x24", "-fbdir", folder_.string(),
                   "-nolisten", "tcp"},
                  "display");
    display_ = fmt::format(":{}", first_line(folder_ / "display"));
    setenv("DISPLAY", display_.c_str(), 1);
  }
  ~Session() {
    for (const pid_t process : {program_, server_})
      if (process > 0) {
        kill(process, SIGTERM);
        waitpid(process, nullptr, 0);
      }
    fs::remove_all(folder_);
  }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Opens the window of a chapter and waits until it can be used.
  void open(const std::string& chapter, std::vector<std::string> options = {}) {
    chapter_ = chapter;
    options.insert(options.begin(), {"live", "--controls"});
    start_process(program_, TUTORIAL_BIN "/" + chapter, options, "said");
    await("names ");  // the last control
    std::istringstream lines(said());
    std::string name;
    for (double x = 0.0, y = 0.0; lines >> name >> x >> y;) places_[name] = {x, y};
    sleep_for(0.5);
    rest();
  }

  void key(const std::string& name) {
    rest();
    xdotool("key " + name);
  }
  void press(const std::string& control, double aside = 0.0) {
    xdotool(fmt::format("mousemove {} {} click 1", places_.at(control).first + aside,
                        places_.at(control).second));
    sleep_for(0.5);  // else the mouse is away before a slow frame sees the click
    rest();
  }
  void control_click(const std::string& control) {
    xdotool("keydown ctrl");
    press(control);
    xdotool("keyup ctrl");
  }
  void xdotool(const std::string& command) const {
    REQUIRE(std::system(("xdotool " + command + " >/dev/null 2>&1").c_str()) == 0);
  }
  std::string answer(const std::string& command) const {
    const fs::path file = folder_ / "answer";
    REQUIRE(std::system(("xdotool " + command + " >" + file.string()).c_str()) == 0);
    return slurp(file);
  }
  /// The mouse where it covers neither the page nor a control.
  void rest() const { xdotool("mousemove 1280 790"); }

  /// Waits until the program prints a text, behind what was awaited before; what follows in that
  /// line.
  std::string await(const std::string& text, double seconds = 20.0) {
    for (double waited = 0.0; waited < seconds; waited += 0.05, sleep_for(0.05)) {
      const std::string all = said();
      const std::size_t from = all.find(text, read_) + text.size(), end = all.find('\n', from);
      if (from < text.size() || end == std::string::npos) continue;
      read_ = end;
      return all.substr(from, end - from);
    }
    FAIL("the program did not say '" << text << "' but:\n" << said());
    return {};
  }

  /// Runs the scene for a while; the time at which it was paused.
  std::string run_for(double seconds) {
    key("space");
    await("runs at t = ");
    sleep_for(seconds);
    key("space");
    std::string time = await("paused at t = ");
    sleep_for(0.3);  // the frame after it
    return time.substr(0, time.find(' '));
  }

  /// The exit status after Escape.
  int close() {
    key("Escape");
    return status();
  }
  /// The exit status after the window's own button, as the window manager passes it on.
  int close_by_button() {
    REQUIRE(ask_to_close(display_));
    return status();
  }
  std::string said() const { return slurp(folder_ / "said"); }
  bool runs() const { return waitpid(program_, nullptr, WNOHANG) == 0; }
  void signal(int number) const { kill(program_, number); }

  /// The scene's part of the screen, from Xvfb's own file (XWD: a header of big-endian words, the
  /// colours, the pixels).
  draw::Image screenshot() const {
    const std::string bytes = slurp(folder_ / "Xvfb_screen0");
    const auto word = [&](std::size_t i) {
      std::size_t value = 0;
      for (std::size_t k = 0; k < 4; ++k)
        value = value << 8 | static_cast<unsigned char>(bytes.at(4 * i + k));
      return value;
    };
    const std::size_t header = word(0), row = word(12), colors = word(19);
    REQUIRE(word(11) == 32);  // bits of a pixel: blue, green, red, nothing
    draw::Image image{page_width, page_height, {}};
    for (std::size_t y = 0; y < page_height; ++y)
      for (std::size_t x = 0; x < page_width; ++x) {
        const std::size_t at = header + 12 * colors + y * row + 4 * x;
        for (const std::size_t channel : {2U, 1U, 0U})
          image.rgba.push_back(static_cast<std::uint8_t>(bytes.at(at + channel)));
        image.rgba.push_back(255);
      }
    return image;
  }

  /// What `snapshot` draws of the same scene at a time, without a display.
  draw::Image offscreen(const std::string& time, std::string options = "") const {
    // The window starts with projection where there is a constraint.
    if (chapter_ != "02_parametric_lagrangian" && options.find("--ks") == std::string::npos)
      options += " --stabilization projection";
    REQUIRE(std::system(fmt::format("env -u DISPLAY {}/{} snapshot --at {} --size {}x{} --scale 1 "
                                    "--out {} {} >/dev/null",
                                    TUTORIAL_BIN, chapter_, time, page_width, page_height,
                                    folder_.string(), options)
                            .c_str()) == 0);
    return picture_check::read_png(folder_ / fmt::format("at_{}s.png", time));
  }

 private:
  int status() {
    int status = 0;
    for (int i = 0; i < 200; ++i, sleep_for(0.05))
      if (waitpid(program_, &status, WNOHANG) == program_) {
        program_ = 0;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      }
    return -2;
  }

  void start_process(pid_t& process, const std::string& program, std::vector<std::string> arguments,
                     const std::string& output) {
    std::fflush(nullptr);
    process = fork();
    REQUIRE(process >= 0);
    if (process > 0) return;
    const std::string file = (folder_ / output).string();
    if (std::freopen(file.c_str(), "w", stdout) == nullptr ||
        std::freopen((file + "_errors").c_str(), "w", stderr) == nullptr)
      std::_Exit(127);
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    execvp(program.c_str(), argv.data());
    std::_Exit(127);
  }

  static std::string first_line(const fs::path& path) {
    for (int i = 0; i < 200; ++i, sleep_for(0.05))
      if (const std::string text = slurp(path); text.ends_with('\n'))
        return text.substr(0, text.find('\n'));
    FAIL("Xvfb does not start");
    return {};
  }

  fs::path folder_ = fs::temp_directory_path() / fmt::format("live_test_{}", getpid());

  std::string display_, chapter_;
  std::size_t read_ = 0;  ///< of what was said
  pid_t server_ = 0, program_ = 0;
  std::map<std::string, std::pair<double, double>> places_;
};

using picture_check::alike;

}  // namespace

TEST_CASE("the window shows what a picture of the same time shows") {
  for (const char* chapter : {"01_particle_on_curve_implicit", "02_parametric_lagrangian",
                              "03_global_jacobian_solver", "05_revolute", "06_prismatic",
                              "07_slider_crank", "09_drivers"}) {  // in chapter 4 nothing moves
    INFO(chapter);
    Session session;
    session.open(chapter);
    CHECK(alike(session.screenshot(), session.offscreen("0")));
    const std::string time = session.run_for(0.6);
    INFO(time);
    const draw::Image shown = session.screenshot();
    CHECK(alike(shown, session.offscreen(time)));
    CHECK_FALSE(alike(shown, session.offscreen("0")));
    CHECK(session.close() == 0);
  }
}

TEST_CASE("the check box switches the torque off and on") {
  Session session;
  session.open("07_slider_crank");
  session.press("torque_on");
  CHECK(session.await("torque 0 N·m at t = ") == "0 s");
  const std::string time = session.run_for(0.6);
  const draw::Image shown = session.screenshot();
  CHECK(alike(shown, session.offscreen(time, "--torque 0")));
  CHECK_FALSE(alike(shown, session.offscreen(time)));
  session.press("torque_on");
  CHECK(session.await("torque 2 N·m at t = ") == time + " s");
  session.press("simulate-frame");
  CHECK(session.await("simulate-frame 1 at t = ") == "0 s");
  CHECK(session.close() == 0);
}

TEST_CASE("a slider changes the motion") {
  Session session;
  session.open("05_revolute");
  session.press("gravity", -103.0);  // its left end
  CHECK(session.await("gravity 0 m/s² at t = ") == "0 s");
  const std::string time = session.run_for(0.6);
  const draw::Image shown = session.screenshot();
  CHECK(alike(shown, session.offscreen(time, "--gravity 0")));
  CHECK_FALSE(alike(shown, session.offscreen(time)));
  CHECK(session.close() == 0);
}

TEST_CASE("a pause holds the motion, a step moves it, a reset brings it back") {
  Session session;
  session.open("05_revolute");
  const draw::Image start = session.screenshot();
  const std::string time = session.run_for(0.6);
  const draw::Image paused = session.screenshot();
  sleep_for(1.0);
  CHECK(picture_check::difference(paused, session.screenshot()).largest_step == 0);
  session.key("s");
  const std::string next = session.await("step at t = ");
  CHECK(std::stod(next) == Approx(std::stod(time) + 0.005));
  session.key("Right");
  CHECK(std::stod(session.await("step at t = ")) == Approx(std::stod(time) + 0.010));
  sleep_for(0.3);
  CHECK_FALSE(alike(paused, session.screenshot()));
  session.key("r");
  CHECK(session.await("reset at t = ") == "0 s");
  sleep_for(0.3);
  CHECK(alike(start, session.screenshot()));
  CHECK(session.close() == 0);
}

TEST_CASE("what is typed on a slider is taken at its end, and Escape takes nothing") {
  Session session;
  session.open("05_revolute");
  const auto type = [&](const std::string& text) {
    session.control_click("length");
    session.xdotool("type --delay 60 " + text);
    sleep_for(0.3);
  };
  type("0,65");  // a decimal comma is a point
  session.xdotool("key Return");
  CHECK(session.await("length ") == "0.65 m at t = 0 s");  // not "0 m", "0.6 m" on the way
  type("2");
  session.xdotool("key Escape");
  CHECK(session.await("length ") == "0.65 m at t = 0 s");
  REQUIRE(session.runs());
  session.rest();
  sleep_for(0.5);
  CHECK(alike(session.screenshot(), session.offscreen("0", "--length 0.65")));
  CHECK(session.said().find("allowed") == std::string::npos);
  CHECK(session.close() == 0);
}

TEST_CASE("keys that repeat step on, but do not run and pause") {
  Session session;
  session.open("05_revolute");
  session.xdotool("keydown s sleep 1.5 keyup s");
  session.await("step at t = ");
  CHECK(std::stod(session.await("step at t = ")) == Approx(0.010));
  session.xdotool("keydown space sleep 1.5 keyup space");
  session.await("runs at t = ");
  session.xdotool("key ctrl+r");
  sleep_for(0.3);
  CHECK(session.said().find("paused") == std::string::npos);
  CHECK(session.said().find("reset at t") == std::string::npos);
  CHECK(session.close() == 0);
}

TEST_CASE("Escape closes an open list, and then the window") {
  Session session;
  session.open("05_revolute");
  session.press("integrator");
  session.key("Escape");
  sleep_for(0.5);
  REQUIRE(session.runs());
  session.press("integrator");
  session.key("Escape");
  sleep_for(0.5);
  CHECK(session.close() == 0);
}

TEST_CASE("the window's own button closes it") {
  Session session;
  session.open("02_parametric_lagrangian");
  session.key("space");
  session.await("runs at t = ");
  sleep_for(0.3);
  CHECK(session.close_by_button() == 0);
  session.await(" frames a second of ");
}

TEST_CASE("a program that stood still goes on from where it was") {
  Session session;
  session.open("07_slider_crank");
  session.key("space");
  session.await("runs at t = ");
  session.signal(SIGSTOP);
  sleep_for(4.0);
  session.signal(SIGCONT);
  session.key("space");
  CHECK(std::stod(session.await("paused at t = ")) < 3.0);
  CHECK(session.close() == 0);
}

TEST_CASE("gains that cannot be stable at the step are told") {
  Session session;
  session.open("05_revolute", {"--ks", "10000"});
  session.press("step", 90.0);  // twenty times as long: near its end
  session.await(
      "feedback with ks = 10000 1/s², kd = 200 1/s cannot be stable with rk4 at a step of ");
  CHECK(session.close() == 0);
}

TEST_CASE("the simulated time follows the wall clock, and closing sums it up") {
  Session session;
  session.open("07_slider_crank");
  session.run_for(2.0);
  CHECK(session.close() == 0);
  const std::string line = session.await("\n");
  double simulated = 0.0, wall = 0.0;
  INFO(line);
  REQUIRE(std::sscanf(line.c_str(), "%lf s simulated in %lf s", &simulated, &wall) == 2);
  CHECK(line.find(" frames a second of ") != std::string::npos);
  CHECK(line.find(" steps a second of ") != std::string::npos);
  CHECK(wall > 1.5);
  CHECK(simulated == Approx(wall).margin(0.11));
}

TEST_CASE("a scene that takes longer than real time says by how much") {
  Session session;
  session.open("05_revolute", {"--links", "300", "--step", "2e-5"});
  session.key("space");
  const double part = std::stod(session.await("cannot keep up: "));
  CHECK(part > 0.0);
  CHECK(part < 0.96);
  CHECK(session.close() == 0);
}

TEST_CASE("more links bring a shorter step, unless the reader has chosen one") {
  Session session;
  session.open("05_revolute");
  const auto type = [&](const std::string& control, const std::string& text) {
    session.control_click(control);
    session.xdotool("type --delay 60 " + text);
    sleep_for(0.3);
    session.xdotool("key Return");
    session.await(control + " " + text);
    session.rest();
    sleep_for(0.5);
  };
  type("links", "20");
  CHECK(alike(session.screenshot(), session.offscreen("0", "--links 20")));
  CHECK_FALSE(alike(session.screenshot(), session.offscreen("0", "--links 20 --step 0.005")));
  type("step", "0.001");
  type("links", "30");
  CHECK(alike(session.screenshot(), session.offscreen("0", "--links 30 --step 0.001")));
  CHECK(session.close() == 0);
}

TEST_CASE("the window opens inside the screen that there is") {
  for (const auto& [width, height] : {std::pair{1320, 840}, {1024, 700}, {800, 600}}) {
    INFO(width << "x" << height);
    Session session(fmt::format("{}x{}", width, height));
    session.open("07_slider_crank");
    const std::string where =
        session.answer("search --name Slider-crank getwindowgeometry --shell");
    const auto value = [&](const std::string& name) {
      const std::size_t at = where.find(name + "=");
      REQUIRE(at != std::string::npos);
      return std::stoi(where.substr(at + name.size() + 1));
    };
    CHECK(value("X") >= 0);
    CHECK(value("Y") >= 0);
    CHECK(value("X") + value("WIDTH") <= width);
    CHECK(value("Y") + value("HEIGHT") <= height);
    CHECK(value("WIDTH") >= std::min(960, width));
    CHECK(value("HEIGHT") >= std::min(600, height));
    CHECK(session.close() == 0);
  }
}

TEST_CASE("the mouse drags a rod") {
  Session session;
  session.open("05_revolute");
  session.xdotool("mousemove 600 292 mousedown 1");  // the rod is level
  sleep_for(0.2);
  session.xdotool("mousemove 600 170");
  CHECK(session.await("pulled at t = ") == "0 s");
  session.xdotool("key space");
  sleep_for(0.7);
  session.xdotool("mouseup 1");
  session.await("let go at t = ");
  session.xdotool("key space");
  const std::string time = session.await("paused at t = ");
  session.rest();
  sleep_for(0.3);
  CHECK_FALSE(alike(session.screenshot(), session.offscreen(time.substr(0, time.find(' ')))));
  CHECK(session.close() == 0);
}

TEST_CASE("what is said to nobody is told at the end") {
  Session session;
  session.open("05_revolute");
  CHECK(session.close() == 0);
  CHECK(std::system("( while sleep 1; do xdotool key Escape; done ) & " TUTORIAL_BIN
                    "/05_revolute live >/dev/full 2>/dev/null; s=$?; kill $!; exit $s") == 0x100);
}

TEST_CASE("a scene that opens its joints is told, and goes on") {
  Session session;
  session.open("05_revolute", {"--links", "6", "--stabilization", "none", "--step", "0.01"});
  session.key("space");
  const std::string said = session.await("far from right: ");
  INFO(said);
  CHECK(said.find("energy balance is off by") + 1 + said.find("joints are open by") + 1 != 0);
  CHECK(said.find("stabilization projection") != std::string::npos);
  CHECK(said.find("--") == std::string::npos);  // options are controls here
  sleep_for(0.5);
  CHECK(session.runs());
  CHECK(session.close() == 0);
}

TEST_CASE("a run that diverges stands still and says why, until a reset") {
  Session session;
  session.open("07_slider_crank", {"--ks", "1e8"});
  session.key("space");
  const std::string why = session.await("stopped at t = ");
  INFO(why);
  CHECK(why.find("try a step of ") != std::string::npos);
  sleep_for(0.3);  // the frame after it
  const draw::Image stopped = session.screenshot();
  session.key("space");
  session.key("s");
  sleep_for(0.5);
  CHECK(picture_check::difference(stopped, session.screenshot()).largest_step == 0);
  session.key("r");
  CHECK(session.await("reset at t = ") == "0 s");
  sleep_for(0.3);
  CHECK(alike(session.screenshot(), session.offscreen("0", "--ks 1e8 2>/dev/null")));
  CHECK(session.close() == 0);
}

TEST_CASE("a scene that cannot be made is refused, and the one before stays as it is") {
  Session session;
  session.open("07_slider_crank");
  const std::string time = session.run_for(0.5);
  session.press("rod", -103.0);  // far shorter than the crank
  session.await("rod 0.01: allowed is the crank, 0.3 m, or more");
  CHECK(session.await("rod ") == "1 m at t = " + time + " s");
  CHECK(alike(session.screenshot(), session.offscreen(time)));
  CHECK(session.close() == 0);
}
