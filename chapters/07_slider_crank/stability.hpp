#pragma once

#include <cmath>
#include <memory>
#include <numbers>

#include "exact.hpp"
#include "instruments/measure/cases.hpp"
#include "scene.hpp"

namespace slider_crank {

/// The stiff and extreme cases of the slider-crank, each with the outcome that is expected of it.
inline measure::Stability stability() {
  using integrators::Scheme;
  using measure::accurate;
  using measure::degraded;
  using measure::drift;
  using measure::energy_error;
  using measure::refused;
  using mechanics::Stabilization;
  using Motion = mechanics::Motion<mechanics::Mechanism>;
  constexpr double pi = std::numbers::pi;

  const auto of = [](const Scene& scene) -> measure::Start {
    return [scene](const mechanics::Method& method) {
      return std::make_unique<Motion>(make_mechanism(scene, method), method);
    };
  };
  const mechanics::Method rk4{Scheme::rk4}, projected{Scheme::rk4, Stabilization::projection},
      feedback{Scheme::rk4, Stabilization::feedback, 625.0, 50.0},
      midpoint{Scheme::implicit_midpoint, Stabilization::projection},
      adaptive{Scheme::dop853, Stabilization::projection, 0.0, 0.0, 1e-8},
      dop853{Scheme::dop853, Stabilization::projection};
  const auto angle = [=](const Scene& scene, const mechanics::Method& method, long steps,
                         double h) {
    const auto columns = make_mechanism(scene, {}).columns();
    return measure::final_error(
        of(scene), [=](const mechanics::Row& row) { return errors(scene, columns, row); }, 0,
        method, steps, h);
  };
  const auto scene_in = [=](const measure::Units& units) {
    const Scene here{.theta0 = 1.0, .omega0 = 3.0};
    Scene there = here;
    const double L = units.length, T = units.time, m = units.mass;
    for (double* length :
         {&there.crank, &there.rod, &there.wheel_radius, &there.slider_width, &there.slider_height})
      *length *= L;
    for (double* mass : {&there.wheel_mass, &there.rod_mass, &there.slider_mass, &there.frame_mass})
      *mass *= m;
    there.frame_inertia *= m * L * L;
    there.torque *= m * L * L / (T * T);
    there.gravity *= L / (T * T);
    there.omega0 /= T;
    return of(there);
  };

  // A dead centre every half turn: free wheeling, no load.
  Scene free{.torque = 0.0, .theta0 = 0.2, .omega0 = 9.0, .gravity = 0.0};
  Scene folding = free;
  folding.rod = folding.crank;
  Scene close = free;
  close.rod = 0.31;

  measure::Stability stability;
  // [cases]
  stability.cases = {
      {"rod 0.31 m, crank 0.30 m: 13 half turns", "wheel angle, rad", accurate(1e-6),
       angle(close, projected, 7000, 1e-3)},
      {"rod = crank: 13 singular poses, projection", "energy error, relative", accurate(1e-6),
       energy_error(of(folding), projected, 7000, 1e-3)},
      {"rod = crank: the same without projection", "", refused("kinetic energy"),
       energy_error(of(folding), rk4, 7000, 1e-3)},
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
           const double quarter = (static_cast<double>(k) + 0.5) * pi;  // θ of the k-th dead centre
           // Where θ is a quarter turn, by the exact motion: θ there against the quarter, over ω.
           const Exact::State at = Exact(folding).at(poses[k].t).value();
           worst = std::max(worst, static_cast<double>(std::abs((at.theta - quarter) / at.omega)));
         }
         return worst;
       }},
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
       energy_error(of({}), {Scheme::rk4, Stabilization::feedback, 1e8, 2e4}, 2000, 1e-3)},
      {"steps of 0.2 s with explicit_euler", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::explicit_euler, Stabilization::projection}, 200, 0.2)},
  };
  // [cases]
  stability.add_units(scene_in, {rk4, projected, feedback, midpoint, adaptive}, 100, 1e-3);

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

}  // namespace slider_crank
