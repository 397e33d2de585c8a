#include "study.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/chapter.hpp"
#include "exact.hpp"
#include "mechanism.hpp"
#include "one_coordinate.hpp"

namespace slider_crank {
namespace {

using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<mechanics::Mechanism>;

measure::Start of(const Scene& scene) {
  return measure::start_of([=](const Method& method) { return make_mechanism(scene, method); });
}

/// The error of the wheel's angle [rad] at the end of so many steps.
std::function<double()> angle(const Scene& scene, const Method& method, long steps, double h) {
  const auto columns = make_mechanism(scene, {}).columns();
  return measure::final_error(
      of(scene), [=](const mechanics::Row& row) { return errors(scene, columns, row); }, 0, method,
      steps, h);
}

std::size_t find(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

}  // namespace

Scene in_units(Scene scene, const measure::Units& units) {
  measure::scale(
      {&scene.crank, &scene.rod, &scene.wheel_radius, &scene.slider_width, &scene.slider_height},
      units.length);
  measure::scale({&scene.wheel_mass, &scene.rod_mass, &scene.slider_mass, &scene.frame_mass},
                 units.mass);
  scene.frame_inertia *= units.inertia();
  scene.torque *= units.moment();
  scene.gravity *= units.acceleration();
  scene.omega0 /= units.time;
  return scene;
}

double force_error(const mechanics::Columns& columns, const mechanics::Row& row,
                   const Reactions& truth) {
  const auto off = [&](const std::string& joint, const auto& exact) {
    const std::size_t i = find(columns.reactions, joint + ".fx");
    return (Eigen::Vector2d(row.reactions[i], row.reactions[i + 1]) - exact).squaredNorm();
  };
  return std::sqrt(off("wheel_frame", truth.wheel_frame) + off("rod_wheel", truth.rod_wheel) +
                   off("slider_rod", truth.slider_rod) + off("slider_frame", truth.slider_frame));
}

std::vector<double> errors(const Scene& scene, const mechanics::Columns& columns,
                           const mechanics::Row& row) {
  const auto state = Exact(scene).at(row.t);
  if (!state) return {};
  const Real theta = row.state[find(columns.state, "wheel.theta")];
  const Real omega = row.state[find(columns.state, "wheel.omega")];
  return {static_cast<double>(std::abs(theta - state->theta)),
          static_cast<double>(std::abs(omega - state->omega)),
          force_error(columns, row, reactions(scene, *state))};
}

measure::Stability stability() {
  using namespace measure;
  using namespace measure::usual;

  // A dead centre every half turn: free wheeling, no load.
  Scene free{.torque = 0.0, .theta0 = 0.2, .omega0 = 9.0, .gravity = 0.0};
  Scene folding = free;
  folding.rod = folding.crank;
  Scene close = free;
  close.rod = 0.31;
  const Scene loaded{.crank = 0.3, .rod = 0.3, .omega0 = 5.0};
  Scene in_the_pose = loaded;
  in_the_pose.theta0 = std::numbers::pi / 2.0;
  const Method dop853{integrators::Scheme::dop853, Stabilization::projection};

  Stability stability;
  stability.cases = {
      {"rod 0.31 m, crank 0.30 m: 13 half turns", "wheel angle, rad", accurate(1e-6),
       angle(close, projected, 7000, 1e-3)},
      {"rod = crank: 13 singular poses, projection", "energy error, relative", accurate(1e-6),
       energy_error(of(folding), projected, 7000, 1e-3)},
      {"rod = crank: 4 s without projection", "energy error, relative", degraded(0.01, 10.0),
       energy_error(of(folding), rk4, 4000, 1e-3)},
      {"rod = crank: on the branch of its momentum", "slider's place, m", accurate(1e-6),
       [=] {
         Motion motion(make_mechanism(folding, projected), projected);
         motion.advance(7000, 1e-3);
         // wheel.theta and slider.x: the slider swings through the centre, s = 2 r cos θ.
         const Eigen::VectorXd& q = motion.q();
         return std::abs(q[6] - 2.0 * folding.crank * std::cos(q[2]));
       }},
      {"rod = crank: the poses without full rank", "their times off theory's, s", accurate(1e-4),
       [=] {
         Motion motion(make_mechanism(folding, projected), projected);
         for (int step = 0; step <= 7000; ++step, motion.advance(1, 1e-3)) motion.row();
         const auto& poses = motion.model().singular_poses();
         double worst = poses.size() < 10 ? 1.0 : 0.0;
         for (std::size_t k = 0; k < poses.size(); ++k) {
           const double quarter =
               (static_cast<double>(k) + 0.5) * std::numbers::pi;  // θ of the k-th dead centre
           // Where θ is a quarter turn, by the exact motion: θ there against the quarter, over ω.
           const Exact::State at = Exact(folding).at(poses[k].t).value();
           worst = std::max(worst, static_cast<double>(std::abs((at.theta - quarter) / at.omega)));
         }
         return worst;
       }},
      {"rod = crank, loaded: dop853, steps of 0.25 ms", "wheel angle, rad", accurate(1e-10),
       angle(loaded, dop853, 12000, 2.5e-4)},
      {"rod = crank: set off in the pose, steps of 4 ms", "wheel angle, rad", accurate(1e-10),
       angle(in_the_pose, dop853, 125, 4e-3)},
      {"rod shorter than the crank", "", refused("rod 0.2"),
       energy_error(of({.rod = 0.2}), projected, 1, 1e-3)},
      {"crank at 1e4 rad/s, steps of 1e-6 s", "wheel angle, rad", accurate(1e-6),
       angle({.omega0 = 1e4}, projected, 5000, 1e-6)},
      {"crank at 1e4 rad/s, steps of 1e-3 s", "", refused("kinetic energy"),
       energy_error(of({.omega0 = 1e4}), rk4, 2000, 1e-3)},
      {"start at an angle of 1e6 rad", "wheel angle, rad", accurate(1e-8),
       angle({.theta0 = 1e6}, projected, 2000, 1e-3)},
      {"slider of 1e8 kg", "joint drift, m or rad", accurate(1e-9),
       drift(of({.slider_mass = 1.5e8}), projected, 2000, 1e-3)},
      {"slider of 1e-8 kg", "joint drift, m or rad", accurate(1e-9),
       drift(of({.slider_mass = 1.5e-8}), projected, 2000, 1e-3)},
      {"rod of 1e8 kg", "joint drift, m or rad", accurate(1e-9),
       drift(of({.rod_mass = 1e8}), projected, 2000, 1e-3)},
      {"rod of 1e-8 kg", "joint drift, m or rad", accurate(1e-9),
       drift(of({.rod_mass = 1e-8}), projected, 2000, 1e-3)},
      {"rod of 1e-8 kg: the motion", "wheel angle, rad", accurate(1e-6),
       angle({.rod_mass = 1e-8}, projected, 2000, 1e-3)},
      {"wheel of 1e8 kg", "joint drift, m or rad", accurate(1e-9),
       drift(of({.wheel_mass = 2e8}), projected, 2000, 1e-3)},
      {"wheel of 1e-8 kg", "joint drift, m or rad", accurate(1e-9),
       drift(of({.wheel_mass = 2e-8}), projected, 2000, 1e-3)},
      {"wheel of 1e-8 kg: the motion", "wheel angle, rad", degraded(1e-6, 1e-3),
       angle({.wheel_mass = 2e-8}, projected, 2000, 1e-3)},
      {"feedback past its limit: h√ks = 10", "", refused("kinetic energy"),
       energy_error(of({}), feedback(1e8, 2e4), 2000, 1e-3)},
      {"steps of 0.2 s with explicit_euler", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::explicit_euler, Stabilization::projection}, 200, 0.2)},
  };
  const auto scene_in = [](const Units& units) {
    return of(in_units({.theta0 = 1.0, .omega0 = 3.0}, units));
  };
  stability.add_units(scene_in, {rk4, projected, feedback(625, 50), midpoint, adaptive}, 100, 1e-3);

  stability.add_feedback(of({}), {.step = 1e-4, .nudge = 1e-3});
  stability.map_remark =
      "The joints of a moving mechanism obey the same test equation as a plate at rest.";
  stability.long_run = {
      .steps = 1000000,
      .step = 2e-3,
      .methods = {{{Scheme::semi_implicit_euler, Stabilization::projection}, false},
                  {midpoint, false},
                  {rk4, false},
                  {projected, false},
                  {dop853, false}},
      .start = of({.torque = 0.0, .omega0 = 6.0})};
  return stability;
}

std::vector<app::Parameter> machine_parameters(Scene& scene) {
  return {
      {"--crank", "m", "from the wheel's centre to the crank pin", &scene.crank, app::positive},
      {"--rod", "m", "length of the rod, at least the crank", &scene.rod, app::positive},
      {"--theta0", "rad", "angle of the crank at the start", &scene.theta0, {-1e6, 1e6}},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
      {"--wheel-mass", "kg", "mass of the wheel", &scene.wheel_mass, app::positive, app::acts},
      {"--rod-mass", "kg", "mass of the rod", &scene.rod_mass, app::positive, app::acts},
      {"--slider-mass", "kg", "mass of the slider", &scene.slider_mass, app::positive, app::acts},
  };
}

int study(int argc, char** argv) {
  Scene scene;
  app::Chapter chapter;
  chapter.directory = "07_slider_crank";
  chapter.title = "Slider-crank";

  chapter.parameters = machine_parameters(scene);
  const auto add = [&](std::ptrdiff_t at, const app::Parameter& parameter) {
    chapter.parameters.insert(chapter.parameters.begin() + at, parameter);
  };
  add(2, {"--torque", "N·m", "on the wheel, from outside; 0 switches it off", &scene.torque,
          app::any, app::acts | app::switchable});
  add(4, {"--omega0", "rad/s", "its rate at the start", &scene.omega0, app::any});
  add(9, {"--without=jdotv", "", "what the joints of turning bodies need beside J a",
          &scene.without_jdotv, app::on_or_off, app::acts});
  add(10, {"--simulate-frame",
           "",
           "1: the frame is a body held by a ground joint; 0: left out",
           &scene.simulate_frame,
           {0.0, 1.0}});
  chapter.defaults = {.duration = 2.0, .step = 0.001};
  chapter.constraint_unit = "m or rad";
  chapter.fastest = [&] { return scene.fastest(chapter.defaults.duration); };

  chapter.start =
      measure::start_of([&scene](const Method& method) { return make_mechanism(scene, method); });

  chapter.quantities = {
      {"wheel angle", "rad"}, {"angular velocity", "rad/s"}, {"joint forces", "N"}};
  chapter.errors = [&scene](const mechanics::Row& row) {
    return errors(scene, make_mechanism(scene, {}).columns(), row);
  };

  chapter.ladder = {.methods = measure::methods_to_compare(625.0, 50.0),
                    .duration = 2.0,
                    .coarsest = 0.02,
                    .rungs = 14};
  chapter.one_coordinate = {
      measure::start_of([&scene](const Method&) { return OneCoordinate(scene); }),
      [&scene](const mechanics::Row& row) {
        return errors(scene, OneCoordinate(scene).columns(), row);
      },
      {{},
       {.integrator = integrators::Scheme::dop853, .tolerance = mechanics::coarsest_tolerance}}};

  chapter.stability = slider_crank::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return slider_crank::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) {
    return slider_crank::stage(scene, run);
  };
  return app::run_chapter(argc, argv, chapter);
}

}  // namespace slider_crank
