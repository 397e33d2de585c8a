#include "study.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "07_slider_crank/study.hpp"
#include "app/chapter.hpp"
#include "exact.hpp"
#include "mechanism.hpp"
#include "turned_off.hpp"

namespace drivers {
namespace {

using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<mechanics::Mechanism>;

enum Quantity : std::size_t { motor, angle, rate };

measure::Start of(const Scene& scene) {
  return measure::start_of([=](const Method& method) { return make_mechanism(scene, method); });
}

/// The error of a quantity at the end of so many steps, of the scene or of what a driver makes of
/// its function.
std::function<double()> error(Quantity quantity, const Scene& scene, const Method& method,
                              long steps, double h, const measure::Start& start = {}) {
  const auto columns = make_mechanism(scene, {}).columns();
  return measure::final_error(
      start ? start : of(scene),
      [=](const mechanics::Row& row) { return errors(scene, columns, row); }, quantity, method,
      steps, h);
}

/// The machine under a motor that is no constraint: a spring and a damper between where the wheel
/// is and where it is told to be. The error of its angle [rad] at the end of so many steps.
std::function<double()> soft_motor(double k, double c, const Method& method, long steps, double h) {
  return [=] {
    const Scene scene;
    const eases::Move f = move(scene);
    slider_crank::Bodies bodies;
    mechanics::Mechanism mechanism = slider_crank::make_mechanism(scene.machine, method, &bodies);
    mechanism.system.apply(bodies.wheel, [=](double t, const dynamics::Body& wheel) {
      const joints::Given told = f(t);
      return Eigen::Vector3d(0, 0, k * (told.f - wheel.theta) + c * (told.f_dot - wheel.omega));
    });
    mechanism.work = [](const Eigen::VectorXd&) { return 0.0; };
    const auto column = bodies.wheel.column + 2;
    Motion motion(std::move(mechanism), method);
    mechanics::Watch watch(motion);
    measure::run(motion, {steps, h}, watch);
    return std::abs(motion.q()[column] - f(motion.time()).f);
  };
}

measure::Start scene_in(const measure::Units& units) {
  Scene there{.turn = 20.0};
  there.machine = slider_crank::in_units(there.machine, units);
  there.move *= units.time;
  return of(there);
}

}  // namespace

std::vector<double> errors(const Scene& scene, const mechanics::Columns& columns,
                           const mechanics::Row& row) {
  const joints::Given told = move(scene)(row.t);
  const Crank crank{told.f, told.f_dot, told.f_ddot};
  const auto value = [](const auto& names, const auto& values, const std::string& name) {
    return values[static_cast<std::size_t>(std::find(names.begin(), names.end(), name) -
                                           names.begin())];
  };
  const double found = value(columns.reactions, row.reactions, "wheel_driver.moment");
  return {static_cast<double>(std::abs(found - torque(scene.machine, crank))),
          std::abs(value(columns.state, row.state, "wheel.theta") - told.f),
          std::abs(value(columns.state, row.state, "wheel.omega") - told.f_dot),
          slider_crank::force_error(columns, row, reactions(scene.machine, crank))};
}

double largest_torque(const Scene& scene) {
  const eases::Move f = move(scene);
  double most = 0.0;
  constexpr int looks = 1000;
  for (int k = 0; k <= looks; ++k) {
    const joints::Given told = f(scene.delay + k * scene.move / looks);
    most = std::max(most, static_cast<double>(
                              std::abs(torque(scene.machine, {told.f, told.f_dot, told.f_ddot}))));
  }
  return most;
}

measure::Stability stability() {
  using namespace measure;
  using namespace measure::usual;

  const Scene cubic{.ease = "cubic_in_out"};
  Scene through = cubic;
  through.end_at_jumps = false;
  Scene folding{.turn = 40.0};
  folding.machine.rod = folding.machine.crank;
  const auto with = [](const char* ease, double turn, double move) {
    Scene scene;
    scene.ease = ease;
    scene.turn = turn;
    scene.move = move;
    return scene;
  };
  const auto heavy = [](double slider, double rod, double wheel) {
    Scene scene;
    scene.machine.slider_mass *= slider;
    scene.machine.rod_mass *= rod;
    scene.machine.wheel_mass *= wheel;
    return scene;
  };
  const auto lie = [](Function (*what)(Function)) {
    return start_of([=](const Method& method) {
      return make_mechanism(Scene().machine, what(move({})), method);
    });
  };
  const Method euler{Scheme::explicit_euler, Stabilization::projection};

  Stability stability;
  stability.cases = {
      {"smooth: rk4, steps of 1 ms", "motor torque, N·m", accurate(1e-9),
       error(motor, {}, rk4, 500, 1e-3)},
      {"cubic_in_out: through the jump of f''", "wheel angle, rad", degraded(1e-4, 1e-2),
       error(angle, through, rk4, 1536, 1.0 / 1024)},
      {"cubic_in_out: a step ends at the jump", "wheel angle, rad", accurate(1e-10),
       error(angle, cubic, rk4, 1400, 1e-3)},
      {"cubic_in_out: the jump between two steps", "wheel angle, rad", accurate(1e-10),
       error(angle, cubic, rk4, 1700, 8.3e-4)},
      {"cubic_in_out: dop853 chooses its steps", "motor torque, N·m", accurate(1e-6),
       error(motor, cubic, {Scheme::dop853, Stabilization::none, 0, 0, 1e-10}, 14, 0.1)},
      {"explicit_euler and projection, steps of 0.1 s", "motor torque, N·m", accurate(1e-9),
       error(motor, {}, euler, 14, 0.1)},
      {"4 rad in 1 ms, steps of 1 us", "wheel angle, rad", accurate(1e-9),
       error(angle, with("smooth", 4, 1e-3), rk4, 2000, 1e-6)},
      {"4 rad in 1 ms, steps of 10 ms, projection", "wheel angle, rad", accurate(1e-9),
       error(angle, with("smooth", 4, 1e-3), projected, 20, 0.01)},
      {"4 rad in 1 ms, steps of 10 ms, rk4 alone", "", refused("kinetic energy"),
       error(angle, with("smooth", 4, 1e-3), rk4, 20, 0.01)},
      {"1e6 rad in 2 s, steps of 10 us for 0.1 s", "wheel angle, rad", accurate(1e-8),
       error(angle, with("smooth", 1e6, 2.0), projected, 10000, 1e-5)},
      {"rod = crank: driven through 13 dead centres", "wheel angle, rad", accurate(1e-9),
       error(angle, folding, projected, 2000, 1e-3)},
      {"rod = crank: what the motor did", "energy error, relative", degraded(1e-5, 1e-2),
       energy_error(of(folding), projected, 2000, 1e-3)},
      {"slider of 1e8 kg", "wheel angle, rad", accurate(1e-9),
       error(angle, heavy(1e8, 1, 1), projected, 1400, 1e-3)},
      {"slider of 1e-8 kg", "wheel angle, rad", accurate(1e-9),
       error(angle, heavy(1e-8, 1, 1), projected, 1400, 1e-3)},
      {"rod of 1e8 kg", "wheel angle, rad", accurate(1e-9),
       error(angle, heavy(1, 1e8, 1), projected, 1400, 1e-3)},
      {"rod of 1e-8 kg", "wheel angle, rad", accurate(1e-9),
       error(angle, heavy(1, 1e-8, 1), projected, 1400, 1e-3)},
      {"wheel of 1e8 kg", "wheel angle, rad", accurate(1e-9),
       error(angle, heavy(1, 1, 1e8), projected, 1400, 1e-3)},
      {"wheel of 1e-8 kg", "wheel angle, rad", accurate(1e-9),
       error(angle, heavy(1, 1, 1e-8), projected, 1400, 1e-3)},
      {"without C_t, projection", "rate of the wheel, rad/s", degraded(1.0, 10.0),
       error(rate, {}, projected, 1000, 1e-3, lie(without_C_t))},
      {"without C_tt, rk4 alone", "wheel angle, rad", degraded(1.0, 3.0),
       error(angle, {}, rk4, 1000, 1e-3, lie(without_C_tt))},
      {"a soft motor, 1e6 N·m/rad: h√(k/μ) = 2", "wheel angle, rad", accurate(1e-4),
       soft_motor(1e6, 0, rk4, 1000, 1e-3)},
      {"a soft motor, 1e7 N·m/rad: h√(k/μ) = 6", "", refused("kinetic energy"),
       soft_motor(1e7, 0, rk4, 1000, 1e-3)},
      {"a rate that jumps", "", refused("ease linear"),
       [] { return error(angle, {.ease = "linear"}, rk4, 1, 1e-3)(); }},
      {"rod = crank: at rest in the dead centre", "", refused("theta0 1.5708"),
       [] {
         Scene scene;
         scene.machine.rod = scene.machine.crank;
         scene.machine.theta0 = std::numbers::pi / 2;
         return error(angle, scene, rk4, 1, 1e-3)();
       }},
      {"rod shorter than the crank", "", refused("rod 0.2"),
       [] {
         Scene scene;
         scene.machine.rod = 0.2;
         return error(angle, scene, rk4, 1, 1e-3)();
       }},
      {"feedback past its limit: h√ks = 10", "", refused("kinetic energy"),
       energy_error(of({}), feedback(1e8, 2e4), 2000, 1e-3)},
  };
  stability.add_units(scene_in, {rk4, projected, feedback(625, 50), midpoint, adaptive}, 100, 1e-3);

  stability.add_feedback(of({}), {.step = 1e-4, .nudge = 1e-3});
  stability.map_remark =
      "A driven joint obeys the same test equation: C_t and C_tt drop out of it.";
  return stability;
}

int study(int argc, char** argv) {
  Scene scene;
  app::Chapter chapter;
  chapter.directory = "09_drivers";
  chapter.title = "Driver";

  std::string names;
  for (const eases::Ease& ease : eases::all)
    names.append(names.empty() ? "" : ", ").append(ease.name);
  chapter.texts = {{"--ease", "NAME", names + ": how the crank moves (default " + scene.ease + ")",
                    &scene.ease}};
  chapter.parameters = {
      {"--turn", "rad", "by which the crank is turned", &scene.turn, {-1e6, 1e6}},
      {"--move", "s", "time that it takes", &scene.move, app::positive},
      {"--delay", "s", "time before it", &scene.delay, app::not_negative},
      {"--end-at-jumps",
       "",
       "1: a step ends where the second derivative may jump; 0: none does",
       &scene.end_at_jumps,
       {0.0, 1.0}},
  };
  for (const app::Parameter& parameter : slider_crank::machine_parameters(scene.machine))
    chapter.parameters.push_back(parameter);
  chapter.defaults = {.duration = 2.0, .step = 0.001};
  chapter.constraint_unit = "m or rad";
  chapter.fastest = [&] { return scene.fastest(); };

  chapter.start =
      measure::start_of([&scene](const Method& method) { return make_mechanism(scene, method); });

  chapter.quantities = {{"motor torque", "N·m", [&scene] { return largest_torque(scene); }},
                        {"wheel angle", "rad"},
                        {"angular velocity", "rad/s"},
                        {"joint forces", "N"}};
  chapter.errors = [&scene](const mechanics::Row& row) {
    return errors(scene, make_mechanism(scene, {}).columns(), row);
  };

  chapter.ladder = {.methods = measure::methods_to_compare(625.0, 50.0),
                    .duration = 1.4,
                    .coarsest = 0.1,
                    .rungs = 14};

  chapter.stability = drivers::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return drivers::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) { return drivers::stage(scene, run); };
  return app::run_chapter(argc, argv, chapter);
}

}  // namespace drivers
