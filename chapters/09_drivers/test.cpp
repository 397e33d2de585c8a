#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "07_slider_crank/exact.hpp"
#include "allocations.hpp"
#include "catch.hpp"
#include "exact.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/pictures/stage.hpp"
#include "main_check.hpp"
#include "mechanism.hpp"
#include "orders.hpp"
#include "picture_check.hpp"
#include "stability_check.hpp"
#include "study.hpp"
#include "turned_off.hpp"

using drivers::Crank;
using drivers::Function;
using drivers::make_mechanism;
using drivers::Scene;
using integrators::Scheme;
using mechanics::Method;
using mechanics::Stabilization;

namespace {

using Motion = mechanics::Motion<mechanics::Mechanism>;
const Method projected{Scheme::rk4, Stabilization::projection};

Motion motion(const Scene& scene, const Method& method = {}) {
  return {make_mechanism(scene, method), method};
}

const eases::Ease& ease(const char* name) { return eases::named(name); }

/// One unit in one second.
eases::Move unit(const eases::Ease& ease) { return {ease, 0, 1, 0, 1}; }

Scene with(const char* ease) {
  Scene scene;
  scene.ease = ease;
  return scene;
}

double value(Motion& motion, const std::string& name) {
  const mechanics::Columns columns = motion.columns();
  const mechanics::Row row = motion.row();
  for (std::size_t i = 0; i < columns.state.size(); ++i)
    if (columns.state[i] == name) return row.state[i];
  for (std::size_t i = 0; i < columns.reactions.size(); ++i)
    if (columns.reactions[i] == name) return row.reactions[i];
  FAIL("no column " << name);
  return 0;
}

std::vector<double> errors(const Scene& scene, Motion& motion) {
  return drivers::errors(scene, motion.columns(), motion.row());
}

Crank told(const Scene& scene, double t) {
  const joints::Given given = drivers::move(scene)(t);
  return {given.f, given.f_dot, given.f_ddot};
}
double exact_torque(const Scene& scene, double t) {
  return static_cast<double>(drivers::torque(scene.machine, told(scene, t)));
}

/// Other machines, and other moves.
std::vector<Scene> scenes() {
  std::vector<Scene> scenes(4);
  scenes[1].ease = "sine_in_out";
  scenes[1].turn = -9.0;
  scenes[2].ease = "quartic_in_out";
  scenes[2].machine.rod = 0.4;
  scenes[2].machine.gravity = 3.0;
  scenes[2].move = 1.1;
  scenes[3].ease = "quintic_in_out";
  scenes[3].machine.slider_mass = 20.0;
  scenes[3].delay = 0.123;
  return scenes;
}

// Reference values of the default scene in 15 digits, by mpmath with 30 and more.
struct Reference {
  const char* ease;
  double quarter, late;  // the torque at 0.25 and at 0.7 of the move [N·m]
};
const Reference references[] = {{"smooth", 1.83428981029482, -0.00895641369962081},
                                {"sine_in_out", 1.03484443604250, 0.773188597997143},
                                {"cubic_in_out", 1.68981336259877, -1.41170578031031}};
constexpr double whole_work = 2.50808757200326;  // [J], of any ease

}  // namespace

TEST_CASE("main prints the torque of the motor and its error") {
  const std::string text = printed_by("09_drivers");
  const double found = number_after(text, "turns the wheel with ");
  CHECK(found == Approx(references[0].quarter).epsilon(1e-9));
  CHECK(number_after(text, "exact answer is ") == Approx(references[0].quarter).epsilon(1e-12));
  CHECK(std::abs(number_after(text, "error ")) < 1e-9);
}

TEST_CASE("the torque, exact and simulated, is that of the reference") {
  for (const Reference& reference : references) {
    const Scene scene = with(reference.ease);
    INFO(reference.ease);
    CHECK(exact_torque(scene, 0.5) == Approx(reference.quarter).epsilon(1e-13));
    CHECK(exact_torque(scene, 1.4) == Approx(reference.late).epsilon(1e-12));
    Motion machine = motion(scene);
    machine.advance(500, 1e-3);
    CHECK(value(machine, "wheel_driver.moment") == Approx(reference.quarter).epsilon(1e-9));
    machine.advance(900, 1e-3);
    CHECK(value(machine, "wheel_driver.moment") == Approx(reference.late).margin(1e-9));
    CHECK(value(machine, "wheel_driver.fx") == 0);
    CHECK(value(machine, "wheel_driver.fy") == 0);
  }
  // What jumps.
  const auto jump = [](const char* ease, double t) {
    return exact_torque(with(ease), t) - exact_torque(with(ease), std::nextafter(t, -1.0));
  };
  CHECK(jump("cubic_in_out", 1.0) == Approx(-4.87054148771766).epsilon(1e-12));
  CHECK(exact_torque(with("sine_in_out"), 0) == Approx(0.590249392677535).epsilon(1e-12));
}

TEST_CASE("the exact torque is what the energy gains, and the work is the same for all eases") {
  for (const Scene& scene : scenes())
    for (const double part : {0.2, 0.45, 0.6, 0.93}) {
      const double t = scene.delay + part * scene.move, h = 1e-5;
      const auto energy = [&](double at) {
        return static_cast<double>(drivers::energy(scene.machine, told(scene, at)));
      };
      const double power = (energy(t + h) - energy(t - h)) / (2 * h);
      CHECK(exact_torque(scene, t) * static_cast<double>(told(scene, t).omega) ==
            Approx(power).epsilon(1e-6));
    }
  for (const eases::Ease& ease : eases::all) {
    Scene scene;
    scene.ease = ease.name;
    INFO(scene.ease);
    CHECK(static_cast<double>(drivers::energy(scene.machine, told(scene, 2)) -
                              drivers::energy(scene.machine, told(scene, 0))) ==
          Approx(whole_work).epsilon(1e-13));
    Motion machine = motion(scene);
    const double start = machine.measures().energy;
    machine.advance(2000, 1e-3);
    CHECK(machine.measures().work == Approx(whole_work).epsilon(1e-8));
    CHECK(machine.measures().energy - start == Approx(whole_work).epsilon(1e-8));
  }
}

TEST_CASE("angle, torque and pin forces of other machines and moves, with projection and without") {
  for (const Scene& scene : scenes())
    for (const Method& method :
         {Method{}, projected, Method{Scheme::rk4, Stabilization::feedback, 100, 20}}) {
      INFO(scene.ease << ", " << method.label());
      Motion machine = motion(scene, method);
      for (int i = 0; i < 4; ++i) {
        machine.advance(270, 1e-3);
        const std::vector<double> off = errors(scene, machine);
        for (std::size_t k = 0; k < off.size(); ++k)
          CHECK(off[k] < (k == 1 || k == 2 ? 1e-8 : 1e-6));
        if (method.stabilization == Stabilization::projection) CHECK(off[1] < 1e-13);
      }
    }
}

TEST_CASE("told chapter 7's own free motion, the motor gives back the torque that made it") {
  for (const double torque : {2.0, 0.0}) {  // with none: solution 3
    slider_crank::Scene machine;
    machine.torque = torque;
    const slider_crank::Exact exact(machine);
    const slider_crank::Reduced reduced(machine);
    const Function f = [&](double t) {
      const slider_crank::Exact::State now = exact.at(t).value();
      return joints::Given{
          static_cast<double>(now.theta), static_cast<double>(now.omega),
          static_cast<double>(reduced.angular_acceleration(reduced.pose(now.theta), now.omega))};
    };
    slider_crank::Scene without = machine;
    without.torque = 0.0;
    Motion driven(make_mechanism(without, f, {}), {});
    for (int i = 0; i < 5; ++i) {
      CHECK(value(driven, "wheel_driver.moment") == Approx(torque).margin(1e-8));
      driven.advance(8, 2.5e-3);
    }
  }
}

TEST_CASE("smooth converges with the order of the integrator, a jump of f'' with the first") {
  const auto columns = make_mechanism(Scene(), {}).columns();
  const auto climb = [&](const Scene& scene, const std::vector<Method>& methods, auto holds) {
    return check_orders(
        {.methods = methods, .duration = 1.4, .coarsest = 0.05, .rungs = 8},
        [&](const Method& method) { return std::make_unique<Motion>(motion(scene, method)); },
        [&](const mechanics::Row& row) { return drivers::errors(scene, columns, row); }, holds);
  };
  // RK4 integrates the rate of smooth, a polynomial, without any error; semi-implicit Euler is
  // leapfrog, of order 2, for an angle that is told from rest.
  CHECK(climb({},
              {{Scheme::explicit_euler},
               {Scheme::semi_implicit_euler},
               {Scheme::implicit_midpoint},
               {Scheme::rk4}},
              [](const measure::Rung& rung, std::size_t k) {
                return rung.step < 0.01 && rung.errors[k] > 1e-10 && !(rung.order == 4 && k == 2) &&
                       !(rung.method == "semi_implicit_euler" && k == 1);
              }) > 20);
  Scene through = with("cubic_in_out");
  through.end_at_jumps = false;
  Motion coarse = motion(through), fine = motion(through), ended = motion(with("cubic_in_out"));
  // Steps that have no rounding, so that one of them ends at 1 s.
  coarse.advance(192, 1.0 / 128);
  fine.advance(384, 1.0 / 256);
  ended.advance(192, 1.0 / 128);
  const auto a = errors(through, coarse), b = errors(through, fine), c = errors(through, ended);
  for (std::size_t k = 0; k < 4; ++k) {
    INFO("quantity " << k);
    CHECK(std::log2(a[k] / b[k]) == Approx(1).margin(0.1));
    CHECK(c[k] < 1e-3 * b[k]);
  }
  // One-sixth of a step is asked for on the wrong side: h/6 times the jump, 24 turn / move².
  CHECK(a[2] == Approx(1.0 / 128 / 6 * 24).epsilon(0.01));
}

TEST_CASE("a move that no step divides is as accurate as one that they do") {
  for (const char* ease : {"smooth", "sine_in_out", "quadratic_in_out", "quintic_in_out"}) {
    Scene scene = with(ease);
    scene.delay = 0.0371;
    scene.move = 1.3333;
    INFO(ease);
    Motion machine = motion(scene);
    machine.advance(1000, 1.5e-3);
    for (const double error : errors(scene, machine)) CHECK(error < 1e-8);
  }
}

TEST_CASE("turned off: without C_t projection stops the wheel, without C_tt nothing turns it") {
  const Scene scene;
  const Function f = drivers::move(scene);
  const auto run = [&](const Function& lie, const Method& method) {
    Motion machine(make_mechanism(scene.machine, lie, method), method);
    machine.advance(1000, 1e-3);
    return std::pair(value(machine, "wheel.theta"), value(machine, "wheel.omega"));
  };
  const joints::Given now = f(1.0);
  const auto stopped = run(drivers::without_C_t(f), projected);
  CHECK(stopped.first == Approx(now.f).epsilon(1e-12));
  CHECK(std::abs(stopped.second) < 1e-9);
  CHECK(run(drivers::without_C_t(f), {}).second == Approx(now.f_dot).epsilon(1e-9));
  const auto at_rest = run(drivers::without_C_tt(f), {});
  CHECK(at_rest.first == Approx(f(0).f).epsilon(1e-9));
  CHECK(run(drivers::without_C_tt(f), projected).first == Approx(now.f).epsilon(1e-12));
  // One step late: behind by what it turns meanwhile.
  const auto late = run(drivers::late(f, 1e-3), projected);
  CHECK(now.f - late.first == Approx(1e-3 * now.f_dot).epsilon(1e-3));
}

TEST_CASE("an ease that there is not, or whose rate jumps, and a short rod are refused") {
  CHECK_THROWS_WITH(motion(with("linear")), ContainsSubstring("ease linear: its rate jumps"));
  CHECK_THROWS_WITH(motion(with("bounce")), ContainsSubstring("ease bounce: there is none"));
  Scene scene;
  scene.machine.rod = 0.2;
  CHECK_THROWS_WITH(motion(scene), ContainsSubstring("rod 0.2"));
}

TEST_CASE("a rod as long as the crank does not start in its dead centre, but goes through it") {
  Scene scene;
  scene.machine.rod = scene.machine.crank;
  for (const double theta0 : {std::numbers::pi / 2, -std::numbers::pi / 2}) {
    scene.machine.theta0 = theta0;
    CHECK_THROWS_WITH(motion(scene), ContainsSubstring("the slider may stay in the centre"));
  }
  scene.machine.theta0 = 1.5707;  // just before
  Motion machine = motion(scene, projected);
  machine.advance(2000, 1e-3);
  for (const double error : errors(scene, machine)) CHECK(error < 1e-9);
}

TEST_CASE("the largest torque is that of a bare wheel: I turn / move² times the largest E''") {
  Scene scene;
  scene.machine.rod_mass = scene.machine.slider_mass = 1e-12;
  CHECK(drivers::largest_torque(scene) ==
        Approx(scene.machine.wheel_inertia() * 10 / std::sqrt(3)).epsilon(1e-5));
}

TEST_CASE("a step allocates nothing") {
  for (const auto stabilization :
       {Stabilization::none, Stabilization::feedback, Stabilization::projection}) {
    Motion machine = motion({}, {Scheme::rk4, stabilization, 100.0, 20.0});
    machine.advance(1, 1e-3);
    const long before = allocations();
    machine.advance(100, 1e-3);
    CHECK(allocations() == before);
  }
}

TEST_CASE("solution 1: at rest the motor holds half the weight of the rod at the crank") {
  Motion machine = motion({});
  machine.advance(2100, 1e-3);
  const double theta = std::numbers::pi / 4 + 4;
  CHECK(value(machine, "wheel.theta") == Approx(theta).epsilon(1e-12));
  CHECK(value(machine, "wheel_driver.moment") ==
        Approx(-1.0 * 9.81 * 0.3 * std::cos(theta) / 2).epsilon(1e-9));
}

TEST_CASE("solution 2: without gravity half the time takes four times the torque and the work") {
  Scene slow;
  slow.machine.gravity = 0.0;
  Scene fast = slow;
  fast.move = 1.0;
  for (const double part : {0.2, 0.3, 0.6})
    CHECK(exact_torque(fast, part) == Approx(4 * exact_torque(slow, 2 * part)).epsilon(1e-13));
  Motion machine = motion(fast);
  machine.advance(500, 1e-3);
  CHECK(value(machine, "wheel_driver.moment") == Approx(4 * exact_torque(slow, 1.0)).epsilon(1e-8));
}

namespace {
const measure::RunOptions defaults{.duration = 2.0, .step = 0.001};
}

TEST_CASE("the pictures of the lesson are those that the program draws") {
  picture_check::compare_all("09_drivers", drivers::pictures({}, defaults));
}

TEST_CASE("pictures can be drawn of every scene the options allow") {
  for (Scene scene : scenes()) {
    const measure::RunOptions run{.duration = 0.05, .step = 0.001};
    for (const auto& picture : drivers::pictures(scene, run))
      CHECK_NOTHROW(draw::render({.scale = 0.5}, picture.draw));
    CHECK_NOTHROW(draw::render({.width = 480, .height = 300},
                               pictures::picture_at(drivers::stage(scene, run), 0.02).draw));
  }
}

TEST_CASE("every stiff and extreme case ends as expected, and the map is that of theory") {
  check_stability(drivers::stability());
}

TEST_CASE("each ease goes from 0 to 1, is its own half turn about the middle, and rests outside") {
  for (const eases::Ease& one : eases::all) {
    INFO(std::string(one.name));
    const eases::Move f = unit(one);
    CHECK(f(0).f == 0);
    CHECK(f(0).f_dot == 0);
    CHECK(f(0.5).f == Approx(0.5).epsilon(1e-15));
    CHECK(f(1).f == 1);
    CHECK(f(std::nextafter(1.0, 0.0)).f == Approx(1).epsilon(1e-15));
    CHECK(f(std::nextafter(1.0, 0.0)).f_dot == Approx(0).margin(1e-14));
    for (const double s : {0.1, 0.3, 0.45}) {
      CHECK(f(1 - s).f == Approx(1 - f(s).f));
      CHECK(f(1 - s).f_dot == Approx(f(s).f_dot));
      CHECK(f(1 - s).f_ddot == Approx(-f(s).f_ddot));
    }
    for (const double outside : {-0.2, 1.0, 7.0}) {
      CHECK(f(outside).f == (outside < 0 ? 0 : 1));
      CHECK(f(outside).f_dot == 0);
      CHECK(f(outside).f_ddot == 0);
    }
  }
}

TEST_CASE("f' and f'' of a move are the slopes of f and f', on either side of its jumps") {
  for (const eases::Ease& one : eases::all) {
    const eases::Move f{one, 0.7, -4.0, 0.3, 2.0};
    INFO(std::string(one.name));
    for (const double t : {0.35, 0.6, 0.99, 1.25, 1.35, 1.7, 2.2}) {
      const double h = 1e-5;
      CHECK(f(t).f_dot == Approx((f(t + h).f - f(t - h).f) / (2 * h)).margin(1e-8));
      CHECK(f(t).f_ddot == Approx((f(t + h).f_dot - f(t - h).f_dot) / (2 * h)).margin(1e-7));
    }
    CHECK(f.jumps() == std::array<double, 3>{0.3, 1.3, 2.3});
    CHECK(f(0.29).f == 0.7);
    CHECK(f(2.31).f == -3.3);
  }
}

TEST_CASE("the eases are the curves of their names") {
  constexpr double pi = std::numbers::pi;
  for (const double s : {0.0, 0.13, 0.37, 0.49, 0.51, 0.8, 0.97}) {
    CHECK(unit(ease("smooth"))(s).f ==
          Approx(10 * std::pow(s, 3) - 15 * std::pow(s, 4) + 6 * std::pow(s, 5)).margin(1e-15));
    CHECK(unit(ease("sine_in_out"))(s).f == Approx((1 - std::cos(pi * s)) / 2).margin(1e-15));
    int p = 2;
    for (const char* name :
         {"quadratic_in_out", "cubic_in_out", "quartic_in_out", "quintic_in_out"}) {
      const double first = std::pow(2 * s, p) / 2, second = 1 - std::pow(2 - 2 * s, p) / 2;
      CHECK(unit(ease(name))(s).f == Approx(s < 0.5 ? first : second).margin(1e-15));
      ++p;
    }
  }
}

TEST_CASE("what jumps: nothing, both ends by pi^2 / 2, or the middle by -4 p (p - 1)") {
  const auto jump = [](const char* name, double at) {
    const eases::Move f = unit(ease(name));
    return f(at).f_ddot - f(std::nextafter(at, -1.0)).f_ddot;
  };
  constexpr double half_square = std::numbers::pi * std::numbers::pi / 2;
  for (const double at : {0.0, 0.5, 1.0}) CHECK(std::abs(jump("smooth", at)) < 1e-12);
  CHECK(jump("sine_in_out", 0) == Approx(half_square));
  CHECK(std::abs(jump("sine_in_out", 0.5)) < 1e-12);
  CHECK(jump("sine_in_out", 1) == Approx(half_square));
  CHECK(jump("quadratic_in_out", 0) == Approx(4));
  int p = 2;
  for (const char* name :
       {"quadratic_in_out", "cubic_in_out", "quartic_in_out", "quintic_in_out"}) {
    CHECK(jump(name, 0.5) == Approx(-4 * p * (p - 1)));
    if (p > 2) CHECK(std::abs(jump(name, 0)) + std::abs(jump(name, 1)) < 1e-12);
    ++p;
  }
}

TEST_CASE("a rate that jumps is refused with its reason, other names with those there are") {
  CHECK_THROWS_WITH(eases::named("linear"), ContainsSubstring("infinite force"));
  CHECK_THROWS_WITH(eases::named("bounce"), ContainsSubstring("ease bounce: there is none") &&
                                                ContainsSubstring("smooth, sine_in_out") &&
                                                ContainsSubstring("quintic_in_out"));
  CHECK_THROWS_WITH(eases::named(""), ContainsSubstring("ease ''"));
}
