#include <fmt/format.h>
#include <unistd.h>

#include <Eigen/Core>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "allocations.hpp"
#include "catch.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/pictures/stage.hpp"
#include "main_check.hpp"
#include "orders.hpp"
#include "path_bead.hpp"
#include "picture_check.hpp"
#include "stability_check.hpp"
#include "study.hpp"
#include "wire.hpp"

using namespace any_wire;
using mechanics::Method;
using mechanics::Motion;
using std::numbers::pi;

namespace {

Scene scene_of(const std::string& path, const std::string& by = "parameter") {
  Scene scene = preset(path).scene;
  scene.by = by;
  return scene;
}

/// q and speed after a time, by RK4.
Now after(const Scene& scene, double t, long steps) {
  const auto bead = start(scene)({});
  bead->advance(steps, t / static_cast<double>(steps));
  const std::vector<double> state = bead->row().state;
  return {state[0], state[1]};
}

std::string refusal(const std::function<void()>& make) {
  try {
    make();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("the loop in main ends where the exact motion does") {
  const std::string text = printed_by("08_paths");
  CHECK(std::abs(number_after(text, "q = ") - 0.0473844853696141) < 1e-7);
  CHECK(std::abs(number_after(text, "error")) < 1e-7);
}

TEST_CASE("both descriptions obey Newton's law with a force across the wire, on every path") {
  std::mt19937 generator(4);
  for (const Preset& one : presets()) {
    const paths::Path path = path_of(one.scene);
    for (int trial = 0; trial < 20; ++trial) {
      const double last = one.scene.path == "projectile" ? 2.0 : path.last;
      Scene scene = one.scene;
      scene.q0 = std::uniform_real_distribution<double>(path.first, last)(generator);
      scene.speed = std::uniform_real_distribution<double>(-3, 3)(generator);
      scene.mass = 2.5;
      INFO(scene.path << " at " << scene.q0);
      const auto [x, d, dd] = path(scene.q0);
      const BeadByParameter bead(scene);
      const double qdot = bead.initial_velocity();
      double qddot = 0.0;
      bead.acceleration(0, scene.q0, qdot, qddot);
      const Vector2d weight(0, scene.mass * scene.gravity);
      const Vector2d force = scene.mass * (d * qddot + dd * qdot * qdot) - weight;
      const double size = 1.0 + force.norm();
      CHECK(std::abs(force.dot(d)) <= 1e-10 * size * d.norm());
      CHECK((bead.constraint_force({scene.q0, scene.speed}) - force).norm() <= 1e-9 * size);
      // d|v|/dt along the wire, from q̈: x′·ẍ/|x′|
      scene.by = "length";
      const BeadByLength other(scene);
      double sddot = 0.0;
      other.acceleration(0, other.initial_position(), scene.speed, sddot);
      CHECK(sddot == Approx(d.dot(d * qddot + dd * qdot * qdot) / d.norm()).margin(1e-10));
    }
  }
}

TEST_CASE("the energy quadrature is the closed form where there is one") {
  SECTION("cycloid, swinging") {
    const EnergyMotion motion(as_energy_sees(paths::cycloid(1)), 9.81, {3.0, 0.0});
    for (const double t : {0.1, 1.0, 2.5, 5.0, 37.0}) {
      const auto exact = on_cycloid(1, 9.81, {3.0, 0.0}, t);
      CHECK(motion.at(t)->q == Approx(exact->q).margin(1e-11));
      CHECK(motion.at(t)->speed == Approx(exact->speed).margin(1e-11));
    }
  }
  SECTION("circle: the pendulum's elliptic functions") {
    const double k = std::sin(1.0), w = std::sqrt(9.81 / 1.5);
    const EnergyMotion motion(as_energy_sees(paths::circle(1.5)), 9.81, {2.0, 0.0});
    for (const double t : {0.3, 1.0, 4.0, 20.0})
      CHECK(motion.at(t)->q ==
            Approx(2 * std::asin(k * boost::math::jacobi_cd(k, w * t))).margin(1e-11));
  }
  SECTION("circle, around: sin(q/2) = sn, of a modulus below 1") {
    const double v = 10, R = 1.5, k = 2 * std::sqrt(9.81 * R) / v;
    const EnergyMotion motion(as_energy_sees(paths::circle(R)), 9.81, {0.0, v});
    for (const double t : {0.1, 0.4, 2.0}) {
      const double u = v * t / (2 * R);
      CHECK(std::sin(motion.at(t)->q / 2) == Approx(boost::math::jacobi_sn(k, u)).margin(1e-11));
      CHECK(motion.at(t)->speed == Approx(v * boost::math::jacobi_dn(k, u)).margin(1e-10));
    }
    CHECK(motion.at(2.0)->q > 2 * pi);
  }
  SECTION("spiral without gravity: a constant speed") {
    const EnergyMotion motion(as_energy_sees(paths::spiral(1, 0.2, 4)), 0, {0.0, 1.5});
    CHECK(motion.at(0.9)->q == Approx(0.388780604852920).epsilon(1e-12));
    CHECK(motion.end() == Approx(2.55119487598440 / 1.5).epsilon(1e-12));
  }
  SECTION("projectile: q is the time") {
    const EnergyMotion motion(as_energy_sees(paths::projectile({2, -3}, 9.81)), 9.81,
                              {0.0, std::sqrt(13.0)});
    for (const double t : {0.2, 1.0, 7.0}) CHECK(motion.at(t)->q == Approx(t).epsilon(1e-11));
  }
  SECTION("published numbers") {
    const auto motion = [](const char* path) {
      const Scene scene = scene_of(path);
      return EnergyMotion(as_energy_sees(path_of(scene)), 9.81, {scene.q0, scene.speed});
    };
    CHECK(motion("cubic").at(0.8)->q == Approx(0.729926329575106).epsilon(1e-12));
    CHECK(motion("cubic").at(0.8)->speed == Approx(2.36918527948779).epsilon(1e-12));
    CHECK(motion("cubic").end() == Approx(1.16289102374221).epsilon(1e-12));
    CHECK(motion("sine").at(0.5)->q == Approx(0.407249600014423).epsilon(1e-12));
    CHECK(motion("sine").at(0.5)->speed == Approx(4.66835222282484).epsilon(1e-12));
    CHECK(motion("catmull_rom").at(1.0)->q == Approx(3.41018465248534).epsilon(1e-12));
    CHECK(motion("catmull_rom").at(1.0)->speed == Approx(5.48287240315683).epsilon(1e-12));
    CHECK(motion("catmull_rom").at(0.336597890624980)->q == Approx(1.0).epsilon(1e-12));
    CHECK(motion("catmull_rom").end() == Approx(1.22631302922089).epsilon(1e-12));
  }
  SECTION("what rests stays, and nothing is said of what all but stays") {
    CHECK(EnergyMotion(as_energy_sees(paths::cycloid(1)), 9.81, {0, 0}).at(9)->q == 0.0);
    CHECK_FALSE(EnergyMotion(as_energy_sees(paths::circle(1)), 9.81, {pi - 1e-7, 0}).at(1));
  }
}

TEST_CASE("both descriptions come to the published numbers, on every wire of the lesson") {
  struct Known {
    const char* path;
    double t, q, speed;
    long steps;
  };
  for (const char* by : {"parameter", "length"})
    for (const auto& [path, t, q, speed, steps] :
         {Known{"cycloid", 5.0, 0.0473844853696141, -6.24672959353405, 20000},
          Known{"cubic", 0.8, 0.729926329575106, 2.36918527948779, 4000},
          Known{"sine", 0.5, 0.407249600014423, 4.66835222282484, 4000}}) {
      INFO(path << " by " << by);
      const Now end = after(scene_of(path, by), t, steps);
      CHECK(end.q == Approx(q).epsilon(1e-9));
      CHECK(end.speed == Approx(speed).epsilon(1e-9));
    }
  const Now end = after(scene_of("catmull_rom", "length"), 1.0, 20000);
  CHECK(end.q == Approx(3.41018465248534).epsilon(1e-8));
  CHECK(end.speed == Approx(5.48287240315683).epsilon(1e-8));
}

TEST_CASE("RK4 converges with its order on smooth wires, by parameter and by length") {
  using enum integrators::Scheme;
  for (const char* by : {"parameter", "length"}) {
    Scene scene = scene_of("cubic", by);
    INFO(by);
    CHECK(check_orders(
              {.methods = {{explicit_euler}, {implicit_midpoint}, {rk4}},
               .duration = 0.8,
               .coarsest = 0.8 / 64,
               .rungs = 8},
              start(scene), [&](const mechanics::Row& row) { return errors(scene, row); },
              [](const measure::Rung& rung, std::size_t k) {
                return rung.errors[k] > 1e-10 && rung.step < 0.8 / 500;
              }) > 10);
  }
}

TEST_CASE("how smooth a wire is decides the order, which is one more by length") {
  const std::vector<Order> found = orders();
  // C2, C1, linear: by parameter, by length; C1 also with steps that end at the knots, as if there
  // were none.
  const double expected[] = {2, 3, 1, 2, 4, 0, 1};
  REQUIRE(found.size() == 7);
  for (std::size_t i = 0; i < 7; ++i) {
    INFO(found[i].wire << " by " << found[i].by);
    CHECK(found[i].order == Approx(expected[i]).margin(0.4));
  }
  picture_check::compare("08_paths", "orders",
                         draw::render({.captions = false}, orders_picture(found).draw));
}

TEST_CASE("a projectile on its own path feels no wire") {
  for (const char* by : {"parameter", "length"}) {
    const Scene scene = scene_of("projectile", by);
    const auto bead = start(scene)({});
    measure::run(*bead, {100, 0.01}, [&](const mechanics::Row& row) {
      // By the parameter q̈ = 0, which RK4 takes without error.
      const double most = scene.by_length() ? 1e-6 : 1e-12;
      CHECK(std::hypot(row.reactions[0], row.reactions[1]) < most);
      CHECK(row.state[0] == Approx(row.t).epsilon(most));
    });
  }
}

TEST_CASE("a bead leaves an open wire, at the exact time, and counts on along a closed one") {
  for (const char* by : {"parameter", "length"}) {
    const std::string text = refusal([&] { after(scene_of("cubic", by), 2.0, 2000); });
    CHECK(number_after(text, "leaves the wire at t = ") == Approx(1.16289102374221).epsilon(1e-8));
    CHECK(text.ends_with("at its end q = 1"));
    Scene back = scene_of("line", by);
    back.q0 = 0.5;
    back.speed = -10;
    CHECK(refusal([&] { after(back, 2.0, 2000); }).ends_with("at its end q = 0"));
  }
  Scene ring = scene_of("circle", "length");
  ring.speed = -20;
  CHECK(after(ring, 5.0, 10000).q < -50);
  CHECK(after(ring, 5.0, 10000).q == Approx(exact_motion(ring)(5.0)->q).epsilon(1e-8));
}

TEST_CASE("semi-implicit Euler keeps the energy by length, and not by parameter") {
  const auto energy = [](const char* by) {
    Scene scene = scene_of("cycloid", by);
    scene.q0 = 2.0;
    const auto bead = start(scene)({.integrator = integrators::Scheme::semi_implicit_euler});
    const double before = bead->measures().energy;
    bead->advance(200000, 0.02);
    return std::abs(bead->measures().energy - before);
  };
  CHECK(energy("length") < 0.5);
  CHECK(refusal([&] { energy("parameter"); }).ends_with("which its energy does not reach"));
}

TEST_CASE(
    "a corner leaves the speed as a rounded one does, by length, and q̇ alone is another speed") {
  Scene scene = scene_of("linear_spline", "length");
  scene.points = fmt::format("0,0 1,0 {},{}", 1 + 2 * std::cos(0.6), 2 * std::sin(0.6));
  scene.gravity = 0;
  scene.speed = 1;
  CHECK(after(scene, 2.0, 2000).speed == 1.0);
  CHECK(after(scene, 2.0, 2000).q == Approx(1.5).epsilon(1e-12));
  // The impulse of the corner on 1 kg, from v before and behind it: 2 m v sin(α/2).
  const auto impulse = [&] {
    const auto bead = start(scene)({});
    bead->advance(1500, 0.001);
    const std::vector<double> state = bead->row().state;
    return std::hypot(state[4] - 1, state[5]);
  };
  CHECK(impulse() == Approx(0.591040413322679).epsilon(1e-12));
  scene.by = "parameter";
  CHECK(after(scene, 1.5, 1500).speed == Approx(2.0).epsilon(1e-5));
  CHECK(impulse() == Approx(std::sqrt(5 - 4 * std::cos(0.6))).epsilon(1e-5));
}

TEST_CASE("x' = 0 stops the parameter, with its place, and not the length") {
  Scene cusp = scene_of("cycloid");
  cusp.q0 = pi;
  CHECK(refusal([&] { start(cusp)({}); }).starts_with("q0 3.14159: there x' = 0"));
  cusp.by = "length";
  // From the cusp to the bottom in π√(R/g).
  const Now bottom = after(cusp, pi * std::sqrt(1 / 9.81), 1000);
  CHECK(std::abs(bottom.q) < 1e-9);
  CHECK(bottom.speed == Approx(-2 * std::sqrt(9.81)).epsilon(1e-9));
}

TEST_CASE("the exact answer on a closed wire is that of a start some rounds before") {
  Scene scene = scene_of("circle");
  for (const double speed : {2.0, 7.0})
    for (const double rounds : {-3.0, 400.0}) {
      scene.q0 = 0.3;
      scene.speed = speed;
      const EnergyMotion here(as_energy_sees(path_of(scene)), 9.81, {scene.q0, scene.speed});
      const double far = rounds * 2 * std::numbers::pi;
      const EnergyMotion there(as_energy_sees(path_of(scene)), 9.81, {scene.q0 + far, scene.speed});
      for (const double t : {0.0, 0.7, 5.0})
        CHECK(std::abs(there.at(t)->q - here.at(t)->q - far) < 1e-9);
    }
}

TEST_CASE("the exact answer of a small swing is that of the linear pendulum") {
  const double w = std::sqrt(9.81);
  for (const double v : {1e-10, 1e-6, 1e-3}) {
    const EnergyMotion motion(as_energy_sees(paths::circle(1)), 9.81, {0.0, v});
    for (const double t : {0.1, 1.0, 5.0}) {  // the next term is (v/w)²/16 of it, times wt
      const double phase = w * t;
      REQUIRE(motion.at(t));
      CHECK(std::abs(motion.at(t)->q - v / w * std::sin(phase)) < 0.1 * v * v * v + 1e-9 * v);
      CHECK(std::abs(motion.at(t)->speed - v * std::cos(phase)) < v * v * v + 1e-9 * v);
    }
  }
  // And a larger one that of the elliptic functions: sin(q/2) = k sn(wt, k).
  const EnergyMotion motion(as_energy_sees(paths::circle(1)), 9.81, {0.0, 0.1});
  const double k = 0.1 / (2 * w);
  for (const double t : {0.3, 5.0})
    CHECK(motion.at(t)->q == Approx(2 * std::asin(k * boost::math::jacobi_sn(k, w * t))));
}

TEST_CASE("the exact answer of a small swing in a corner is a parabola on each side") {
  Scene scene = scene_of("linear_spline", "length");
  scene.points = "0,0 1,1 2,0";
  scene.q0 = 1;
  const double a = 9.81 / std::sqrt(2);
  for (const double v : {1e-4, 1e-2, 1.0}) {
    scene.speed = v;
    const double back = 2 * v / a;  // when it is in the corner again
    for (const double part : {0.3, 0.5, 0.8}) {
      const double t = part * back, s = v * t - a * t * t / 2;
      INFO(v << " m/s, at " << part);
      REQUIRE(exact_motion(scene)(t));
      CHECK(exact_motion(scene)(t)->q - 1 == Approx(s / std::sqrt(2)).epsilon(1e-6));
      REQUIRE(exact_motion(scene)(t + 3 * back));  // on the other side
      CHECK(exact_motion(scene)(t + 3 * back)->q - 1 == Approx(-s / std::sqrt(2)).epsilon(1e-6));
    }
  }
}

TEST_CASE("in a corner the bead rests, starts down the lower side, or has two ways to go") {
  using enum integrators::Scheme;
  for (const char* by : {"parameter", "length"}) {
    Scene scene = scene_of("linear_spline", by);
    scene.speed = 0;
    scene.q0 = 1;
    scene.points = "0,0 1,1 3,0.5";  // a valley: y is down
    INFO(by);
    for (const Method& method : {Method{}, Method{.integrator = dop853, .tolerance = 1e-8}}) {
      const auto bead = start(scene)(method);
      bead->advance(50, 0.02);
      CHECK(bead->row().state[0] == 1.0);
      CHECK(bead->row().reactions[1] == Approx(-9.81));  // it carries the whole weight
      CHECK(bead->steps() <= 50);
    }
    CHECK(exact_motion(scene)(5.0)->q == 1.0);
    scene.points = "0,0.5 1,0 3,-1";  // falls backwards, by g/√5 along the first piece
    const double fallen = 9.81 / std::sqrt(5) / 2 * 0.01;
    CHECK(after(scene, 0.1, 10).q == Approx(1 - fallen / std::sqrt(1.25)).epsilon(1e-12));
    CHECK(exact_motion(scene)(0.1)->q == Approx(1 - fallen / std::sqrt(1.25)).epsilon(1e-9));
    scene.points = "0,1 1,0 2,1";
    CHECK_FALSE(exact_motion(scene)(0.1));
    scene.gravity = 0;  // and backwards from a corner at a speed
    scene.speed = -2;
    scene.points = "0,0 1,0 1,5";
    CHECK(after(scene, 0.25, 1).q == Approx(0.5).epsilon(1e-12));
    CHECK(start(scene)({})->row().state[4] == -2.0);
  }
}

TEST_CASE("an energy error beside no energy at all is told in J, not as a part of it") {
  Scene scene = scene_of("linear_spline", "length");
  scene.speed = 0;
  scene.q0 = 1 + 1e-9;  // RK4's steps of 5 ms are too long for its tiny swings
  scene.points = "0,0 1,1 2,0";
  const auto bead = start(scene)({});
  mechanics::Watch watch(*bead);
  measure::run(*bead, {200, 0.005}, watch);
  const std::string text = watch.verdict().text();
  CHECK(text.starts_with("the energy balance is off by "));
  CHECK(text.ends_with(" J"));
}

TEST_CASE("a start beside a cusp is integrated or said to be too close, by parameter") {
  Scene scene = scene_of("cycloid");
  scene.q0 = 3.14154;
  const double h = 0.1 / fastest(scene);
  CHECK(h < 1e-5);
  CHECK(after(scene, 1e-3, std::lround(1e-3 / h)).q ==
        Approx(on_cycloid(1, 9.81, {scene.q0, 0}, 1e-3)->q).margin(1e-7));
  CHECK(refusal([&] { after(scene, 0.05, 10); }) ==
        "at t = 0.005 s: its steps take the bead over the end of the wire, q = 3.14159, which its "
        "energy does not reach");
}

TEST_CASE("an adaptive run starts beside a cusp, where its first step is far too long") {
  Scene scene = scene_of("cycloid");
  scene.q0 = 3.14159;
  const auto bead = start(scene)({.integrator = integrators::Scheme::dop853, .tolerance = 1e-9});
  bead->advance(50, 0.1);
  CHECK(bead->row().state[0] == Approx(on_cycloid(1, 9.81, {scene.q0, 0}, 5.0)->q).margin(1e-8));
}

TEST_CASE("where the speed jumps with the parameter, and where it is only a poor coordinate") {
  const auto kind = [](const char* path) { return parameter_of(path_of(scene_of(path))); };
  CHECK(kind("linear_spline") == Parameter::wrong);
  CHECK(kind("sequence") == Parameter::wrong);
  for (const char* path : {"cycloid", "catmull_rom"}) CHECK(kind(path) == Parameter::poor);
  Scene closed = scene_of("catmull_rom");
  closed.points = "0,0 1,0 1,1 0,0";
  CHECK(parameter_of(path_of(closed)) == Parameter::wrong);
  for (const char* path : {"circle", "line", "spiral"}) CHECK(kind(path) == Parameter::good);
}

TEST_CASE("what makes no wire is refused by the name of its option") {
  const auto message = [](const char* path, auto change) {
    Scene scene = scene_of(path);
    change(scene);
    return refusal([&] { start(scene)({}); });
  };
  CHECK(message("cubic", [](Scene& s) { s.points = "0,0 1,1"; }) ==
        "points 0,0 1,1: a cubic needs 4, not 2");
  CHECK(message("cubic", [](Scene& s) { s.points = "0,0 1"; }) ==
        "points 0,0 1: allowed are pairs of numbers, x,y x,y");
  CHECK(message("cubic", [](Scene& s) { s.points = "0,0 1,nan"; }) ==
        "points nan: allowed is a number from -1e+12 to 1e+12");
  CHECK(message("projectile", [](Scene& s) { s.launch = "0,-1"; }).starts_with("launch 0,-1: "));
  CHECK(message("line", [](Scene& s) { s.q0 = 1.5; }) ==
        "q0 1.5: allowed is a place on the wire, 0 to 1");
  CHECK(message("quadratic", [](Scene& s) { s.points = "1,1 1,1 1,1"; }) ==
        "points 1,1 1,1 1,1: all of a quadratic are (1, 1)");
  CHECK(message("cubic", [](Scene& s) { s.points = "0,0 0,0 0,0 1,1"; }) ==
        "points 0,0 0,0 0,0 1,1: no tangent at q = 0, where x' and x'' are zero");
  CHECK(message("sequence", [](Scene& s) { s.file = "none"; }).starts_with("file none: cannot"));
}

TEST_CASE("a sequence is read from a file, which may name others, to a limit") {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("paths_test_{}", getpid());
  std::filesystem::create_directories(folder);
  const auto write = [&](const char* name, const char* text) {
    std::ofstream(folder / name) << text;
  };
  write("outer", "0 line --points \"0,0 1,0\"\n\n0.5 sequence --file inner\n");
  write("inner", "0 line --points \"1,0 2,0\"\n0.5 line --points \"2,0 2,3\"\n");
  write("itself", "0 sequence --file itself\n");
  write("torn", "0 line --points \"0,0 1,0\"\n0.5 line --points \"2,0 3,0\"\n");
  write("odd", "0 line --points\n");
  write("word", "0 snail\n");
  write("empty", "");
  write("waves", "0 sine --waves 1e6\n");
  std::string many;
  for (int i = 0; i < 9000; ++i) many += fmt::format("{},{} ", i, i % 2);
  write("long", fmt::format("0 linear_spline --points \"{}\"\n", many).c_str());
  write("longer", fmt::format("0 linear_spline --points \"{}\"\n"
                              "0.5 linear_spline --points \"8999,1 {}\"\n",
                              many, many)
                      .c_str());
  Scene scene = scene_of("sequence");
  const auto refused = [&](const char* file) {
    scene.file = (folder / file).string();
    return refusal([&] { path_of(scene); });
  };
  CHECK(refused("outer") == "accepted");
  const paths::Path path = path_of(scene);
  CHECK((path(0.75).x - Vector2d(2, 0)).norm() < 1e-12);
  CHECK((path(0.875).x - Vector2d(2, 1.5)).norm() < 1e-12);
  CHECK(refused("empty").ends_with("empty: it has no piece"));
  CHECK(refused("waves").ends_with("line 1: --waves 1e6: allowed is a number from 0 to 1000"));
  CHECK(refused("longer").ends_with("line 2: with it there are more than 10000 segments"));
  CHECK(refused("long") == "accepted");
  CHECK(exact_motion(scene)(0.1));  // in a moment
  CHECK(refused("itself").ends_with("files nest deeper than 8"));
  CHECK(refused("torn").ends_with("pieces 1 and 2 do not meet: (1, 0), (2, 0)"));
  CHECK(refused("odd").ends_with("line 1: a piece is its cue, its path, and options with values"));
  CHECK(refused("word").ends_with("line 1: snail is not the name of a path"));
  std::filesystem::remove_all(folder);
}

TEST_CASE("a step allocates nothing") {
  for (const char* by : {"parameter", "length"}) {
    const auto bead = start(scene_of("catmull_rom", by))({});
    const long before = allocations();
    bead->advance(20, 0.01);
    CHECK(allocations() == before);
  }
}

TEST_CASE("solution 1: around the circle from 2√(gR) at its lowest point") {
  for (const double part : {0.999, 1.001}) {
    Scene scene = scene_of("circle");
    scene.q0 = 0;
    scene.speed = part * 2 * std::sqrt(9.81);
    CHECK((after(scene, 5.0, 5000).q > 2 * pi) == (part > 1));
  }
}

TEST_CASE("solution 2: at k times the speed of the throw the wire carries 1 − k² of the weight") {
  for (const double k : {0.0, 0.5, 1.0, 2.0}) {
    Scene scene = scene_of("projectile");
    scene.speed *= k;
    const auto row = start(scene)({})->row();
    const Vector2d across = Vector2d(3, 2) / std::sqrt(13.0);  // to (2, −3), with y down
    const double weight = 9.81 * across.y();
    CHECK(row.reactions[0] * across.x() + row.reactions[1] * across.y() ==
          Approx(-(1 - k * k) * weight).margin(1e-12));
  }
}

TEST_CASE("solution 3: (q, speed) is as good as the length, and inverts nothing") {
  const Scene scene = scene_of("catmull_rom");
  const paths::Path path = path_of(scene);
  using Pair = Eigen::Vector2d;  // q, speed
  const auto rate = [&](const Pair& now) {
    const auto [x, d, dd] = path(now[0]);
    return Pair(now[1] / d.norm(), 9.81 * d.y() / d.norm());
  };
  const auto error = [&](int steps) {
    Pair now(scene.q0, scene.speed);
    const double h = 1.0 / steps;
    for (int i = 0; i < steps; ++i) {
      const Pair k1 = rate(now), k2 = rate(now + h / 2 * k1), k3 = rate(now + h / 2 * k2),
                 k4 = rate(now + h * k3);
      now += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    return std::abs(now[0] - 3.41018465248534);
  };
  CHECK(error(400) < 3e-5);
  CHECK(std::abs(after(scene, 1.0, 400).q - 3.41018465248534) > 20 * error(400));
}

namespace {
const measure::RunOptions defaults{.duration = 5.0, .step = 0.005};
}

TEST_CASE("the pictures of the lesson are those that the program draws") {
  picture_check::compare_all("08_paths", any_wire::pictures(Scene{}, defaults));
  for (const Preset& one : presets())
    picture_check::compare(
        "08_paths", "path_" + one.scene.path,
        draw::render(
            {.width = 480, .height = 300, .scale = 1, .captions = false},
            any_wire::pictures(one.scene, {.duration = one.duration, .step = 0.005})[0].draw));
}

TEST_CASE("pictures can be drawn of every path, by parameter and by length") {
  for (const Preset& one : presets())
    for (const char* by : {"parameter", "length"}) {
      Scene scene = one.scene;
      scene.by = by;
      const measure::RunOptions run{.duration = one.duration, .step = 0.01};
      CHECK_NOTHROW(draw::render({.width = 480, .height = 300},
                                 pictures::picture_at(stage(scene, run), 0.2 * one.duration).draw));
    }
}

TEST_CASE("every stiff and extreme case ends as expected, and the map is that of theory") {
  check_stability(stability());
}
