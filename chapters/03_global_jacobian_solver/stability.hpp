#pragma once

#include <memory>

#include "exact.hpp"
#include "instruments/measure/cases.hpp"
#include "scene.hpp"

namespace dumbbell {

/// The stiff and extreme cases of the dumbbell, each with the outcome that is expected of it.
inline measure::Stability stability() {
  using integrators::Scheme;
  using measure::accurate;
  using measure::energy_error;
  using measure::refused;
  using mechanics::Method;
  using mechanics::Stabilization;
  using Motion = mechanics::Motion<mechanics::Mechanism>;

  const auto of = [](const Scene& scene) -> measure::Start {
    return [scene](const Method& method) {
      return std::make_unique<Motion>(make_mechanism(scene, method), method);
    };
  };
  const Method rk4{Scheme::rk4}, projected{Scheme::rk4, Stabilization::projection},
      feedback{Scheme::rk4, Stabilization::feedback, 1.0, 2.0},
      midpoint{Scheme::implicit_midpoint, Stabilization::projection},
      adaptive{Scheme::dop853, Stabilization::projection, 0.0, 0.0, 1e-8};
  const auto place = [=](const Scene& scene, const Method& method, long steps, double h) {
    return measure::final_error(
        of(scene), [=](const mechanics::Row& row) { return errors(scene, row); }, 0, method, steps,
        h);
  };
  // |C| in m²; off the curve by that over |∇C| ≥ 2p, in metres.
  const auto drift = [=](const Scene& scene, const Method& method, long steps, double h) {
    return [=, in_m2 = measure::drift(of(scene), method, steps, h)] {
      return in_m2() / (2.0 * scene.p);
    };
  };
  const auto scene_in = [=](const measure::Units& units) {
    const auto& [L, T, m] = units;
    const Scene here;
    const Scene there{
        here.x1 * L, here.x2 * L, here.m1 * m, here.m2 * m, here.gravity * L / (T * T), here.p * L};
    return of(there);
  };

  measure::Stability stability;
  // [cases]
  stability.cases = {
      {"equal beads level with each other: at rest", "place, m", accurate(1e-9),
       place({.x1 = -60, .x2 = 60, .m1 = 1, .m2 = 1}, projected, 2000, 0.01)},
      {"bead2 of 1e8 kg", "joint drift, m", accurate(1e-9),
       drift({.m2 = 1e8}, projected, 2000, 0.01)},
      {"bead2 of 1e-8 kg", "joint drift, m", accurate(1e-9),
       drift({.m2 = 1e-8}, projected, 2000, 0.01)},
      {"bead2 of 1e8 kg: the motion", "place, m", accurate(1e-6),
       place({.m2 = 1e8}, projected, 2000, 0.01)},
      {"bead2 of 1e-8 kg: the motion", "place, m", accurate(1e-6),
       place({.m2 = 1e-8}, projected, 2000, 0.01)},
      {"beads 1 mm apart at 60 m", "energy error, relative", accurate(1e-6),
       energy_error(of({.x1 = 60.0, .x2 = 60.001}), projected, 2000, 0.01)},
      {"from 1e4 and 2e4 m, slopes of 200 and more", "energy error, relative", accurate(1e-6),
       energy_error(of({.x1 = 1e4, .x2 = 2e4}), projected, 20000, 0.01)},
      {"both beads in one place: no rod", "", refused("x2 60"),
       place({.x1 = 60, .x2 = 60}, rk4, 1, 0.01)},
      {"bead1 on its curve twice", "place, m", accurate(1e-6),
       [=] {
         const Scene scene;
         Parts parts;
         mechanics::Mechanism mechanism = make_mechanism(scene, projected, &parts);
         mechanism.system.add("again", joints::OnCurve<joints::Parabola>{{scene.p}}, parts.bead1);
         Motion motion(std::move(mechanism), projected);
         motion.advance(1000, 0.01);
         const mechanics::Row row = motion.row();
         if (motion.model().evaluation().dependent_rows().size() != 1) return 1.0;
         return errors(scene, row)[0];
       }},
      {"feedback past its limit: h√ks = 3", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::rk4, Stabilization::feedback, 9e4, 600.0}, 20000, 0.01)},
      {"steps of 5 s with explicit_euler", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::explicit_euler, Stabilization::projection}, 1000, 5.0)},
  };
  // [cases]
  stability.add_units(scene_in, {rk4, projected, feedback, midpoint, adaptive}, 500, 0.01);

  stability.add_feedback(of({}), {.step = 1e-3, .nudge = 0.01});
  stability.map_remark = "Rows that push against each other still obey it, each by itself.";
  return stability;
}

}  // namespace dumbbell
