#pragma once

#include <memory>

#include "exact.hpp"
#include "implicit_bead.hpp"
#include "instruments/measure/cases.hpp"

namespace particle_on_curve {

/// The stiff and extreme cases of the bead, each with the outcome that is expected of it.
inline measure::Stability stability() {
  using integrators::Scheme;
  using measure::accurate;
  using measure::degraded;
  using measure::drift;
  using measure::energy_error;
  using measure::refused;
  using mechanics::Stabilization;
  using parabola::Scene;

  const auto of = [](const Scene& scene) -> measure::Start {
    return [scene](const mechanics::Method& method) {
      return std::make_unique<mechanics::Motion<parabola::ImplicitBead>>(
          parabola::ImplicitBead(scene, method.ks, method.kd), method);
    };
  };
  const mechanics::Method rk4{Scheme::rk4}, projected{Scheme::rk4, Stabilization::projection},
      feedback{Scheme::rk4, Stabilization::feedback, 4.0, 4.0},
      midpoint{Scheme::implicit_midpoint, Stabilization::projection},
      adaptive{Scheme::dop853, Stabilization::projection, 0.0, 0.0, 1e-8};
  const auto place = [=](const Scene& scene, const mechanics::Method& method, long steps,
                         double h) {
    return measure::final_error(
        of(scene), [=](const mechanics::Row& row) { return errors(scene, row); }, 0, method, steps,
        h);
  };
  const auto scene_in = [=](const measure::Units& units) {
    return of(Scene{.force_x = 2.0}.scaled(units.length, units.time, units.mass));
  };

  measure::Stability stability;
  // [cases]
  stability.cases = {
      // λ∇C balances gravity to some roundings of g: three of them over 10 s are 1.6e-13 m.
      {"at rest at the bottom", "place, m", accurate(2e-13), place({.x0 = 0.0}, rk4, 1000, 0.01)},
      {"a swing of 1e-6 m", "place, m", accurate(1e-13), place({.x0 = 1e-6}, rk4, 2000, 0.01)},
      {"from 1e4 m, where the slope is 200", "energy error, relative", accurate(1e-6),
       energy_error(of({.x0 = 1e4}), projected, 20000, 0.01)},
      {"p = 0.05 m: radius 0.05 m, start at 1 m", "place, m", accurate(1e-6),
       place({.x0 = 1.0, .p = 0.05}, projected, 40000, 5e-5)},
      {"the same with steps of 1e-2 s", "place, m", degraded(1e-4, 2.0),
       place({.x0 = 1.0, .p = 0.05}, projected, 200, 1e-2)},
      {"mass 1e8 kg", "place, m", accurate(1e-6), place({.mass = 1e8}, projected, 2000, 0.01)},
      {"mass 1e-8 kg", "place, m", accurate(1e-6), place({.mass = 1e-8}, projected, 2000, 0.01)},
      {"gravity 1e6 m/s², steps of 1e-5 s", "place, m", accurate(1e-6),
       place({.gravity = 1e6}, projected, 20000, 1e-5)},
      {"force of 1e6 N across, steps of 1e-5 s", "place, m", accurate(1e-6),
       place({.force_x = 1e6}, projected, 2000, 1e-5)},
      {"feedback past its limit: h√ks = 3", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::rk4, Stabilization::feedback, 9e4, 600.0}, 20000, 0.01)},
      {"steps of 5 s with explicit_euler", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::explicit_euler}, 1000, 5.0)},
      {"1e6 steps, rk4 + projection", "energy error, relative", accurate(1e-8),
       energy_error(of({}), projected, 1000000, 0.01)},
      {"1e6 steps, rk4 alone: off the curve", "|C|, m²", degraded(1e-3, 1e3),
       drift(of({}), rk4, 1000000, 0.01)},
      {"1e6 steps, rk4 + feedback", "|C|, m²", accurate(1e-4),
       drift(of({}), feedback, 1000000, 0.01)},
  };
  // [cases]
  stability.add_units(scene_in, {rk4, projected, feedback, midpoint, adaptive}, 1000, 0.01);

  stability.add_feedback(of({}), {.step = 1e-3, .nudge = 0.01});
  stability.map_remark = "Curved or not, the constraint obeys the test equation.";
  return stability;
}

}  // namespace particle_on_curve
