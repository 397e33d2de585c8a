#pragma once

#include <cmath>
#include <memory>

#include "exact.hpp"
#include "instruments/measure/cases.hpp"
#include "scene.hpp"

namespace ground {

/// The stiff and extreme cases of the plate, each with the outcome that is expected of it.
inline measure::Stability stability() {
  using integrators::Scheme;
  using measure::accurate;
  using measure::degraded;
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
  enum { place, angle, force, moment };  // what errors() returns
  const auto error = [=](std::size_t quantity, const Scene& scene, const Method& method, long steps,
                         double h) {
    return measure::final_error(
        of(scene), [=](const mechanics::Row& row) { return errors(scene, method, row); }, quantity,
        method, steps, h);
  };
  const auto feedback = [](Scheme name, double ks, double kd) {
    return Method{name, Stabilization::feedback, ks, kd};
  };
  const Method rk4{Scheme::rk4};
  const Scene off{.offset_x = 0.05, .offset_y = -0.03, .offset_theta = 0.2};
  const auto scene_in = [=](const measure::Units& units) {
    const auto& [L, T, m] = units;
    Scene there = off;
    for (double* length : {&there.offset_x, &there.offset_y, &there.width, &there.height})
      *length *= L;
    there.load *= m * L / (T * T);
    there.mass *= m;
    there.gravity *= L / (T * T);
    there.load_rate /= T;
    return of(there);
  };

  measure::Stability stability;
  // [cases]
  stability.cases = {
      {"held in its place for 1e5 steps", "place, m", accurate(1e-12),
       error(place, {}, rk4, 100000, 0.01)},
      {"a load of 1e12 N", "reaction, N", accurate(1e-2),
       error(force, {.load = 1e12}, rk4, 500, 0.01)},
      {"put back from 1e6 m away", "place, m", accurate(1e-6),
       error(place, {.offset_x = 1e6}, feedback(Scheme::rk4, 25, 10), 500, 0.01)},
      {"turned by 1e6 rad", "angle, rad", accurate(1e-3),
       error(angle, {.offset_theta = 1e6}, feedback(Scheme::rk4, 25, 10), 500, 0.01)},
      {"without damping, kd = 0, 1e5 steps", "place, m", accurate(1e-3),
       error(place, off, feedback(Scheme::rk4, 25, 0), 100000, 0.002)},
      {"overdamped, kd = 1e3 1/s, ks = 1 1/s²", "place, m", accurate(1e-9),
       error(place, off, feedback(Scheme::rk4, 1, 1000), 2500, 0.002)},
      {"ks = 1e10 1/s², implicit_midpoint", "place, m", degraded(1e-9, 1e-6),
       error(place, off, feedback(Scheme::implicit_midpoint, 1e10, 2e5), 4000, 0.01)},
      {"ks = 1e10 1/s², rk4", "", refused("the constraint error"),
       error(place, off, feedback(Scheme::rk4, 1e10, 2e5), 500, 0.01)},
      {"critical, h√ks = 2.78, below the limit", "place, m", accurate(1e-6),
       error(place, off, feedback(Scheme::rk4, 2.78 * 2.78, 2 * 2.78), 20000, 1.0)},
      {"critical, h√ks = 2.79, above the limit", "", refused("the constraint error"),
       error(place, off, feedback(Scheme::rk4, 2.79 * 2.79, 2 * 2.79), 20000, 1.0)},
      {"held twice: the second joint adds nothing", "place, m", accurate(1e-12),
       [=] {
         mechanics::Mechanism mechanism = make_mechanism({}, rk4);
         mechanism.system.add("again", joints::Ground{},
                              mechanism.system.thing<dynamics::Body>("plate"));
         Motion motion(std::move(mechanism), rk4);
         motion.advance(1000, 0.01);
         motion.row();
         if (motion.model().evaluation().dependent_rows().size() != 3) return 1.0;
         return motion.measures().constraint_error;
       }},
  };
  // [cases]
  stability.add_units(scene_in,
                      {feedback(Scheme::rk4, 25, 10),
                       feedback(Scheme::implicit_midpoint, 25, 10),
                       {Scheme::dop853, Stabilization::feedback, 25, 10, 1e-8}},
                      100, 0.01);

  stability.add_feedback(of({}), {.step = 1e-3, .nudge = 1e-3});
  stability.map_remark = "With J = I each coordinate obeys the test equation exactly.";
  return stability;
}

}  // namespace ground
