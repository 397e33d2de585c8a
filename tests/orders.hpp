// The order of convergence, as the chapters' tests ask for it.
#pragma once

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "instruments/measure/ladder.hpp"

/// Runs every method of the ladder on every rung, without the timing of measure::climb, and
/// compares the observed order of each quantity with theory, wherever `theory_holds(rung, k)` says
/// that the step is short enough and the error of quantity k still above rounding. Returns how many
/// were compared.
template <class TheoryHolds>
int check_orders(const measure::Ladder& ladder, const measure::Start& start,
                 const measure::Errors& errors, TheoryHolds theory_holds) {
  int compared = 0;
  for (const mechanics::Method& method : ladder.methods) {
    measure::Rung rung{.method = method.label(),
                       .order = integrators::info(method.integrator).order};
    for (int i = 0; i < ladder.rungs; ++i) {
      const measure::Rung coarse = rung;
      rung.steps = std::lround(ladder.duration / ladder.coarsest) << i;
      rung.step = ladder.duration / static_cast<double>(rung.steps);
      const auto simulation = start(method);
      simulation->advance(rung.steps, rung.step);
      rung.errors = errors(simulation->row());
      REQUIRE(rung.errors.size() > 0);
      for (std::size_t k = 0; i > 0 && k < rung.errors.size(); ++k) {
        if (!theory_holds(rung, k)) continue;
        INFO(rung.method << ", step " << rung.step << ", quantity " << k << ", error "
                         << rung.errors[k]);
        CHECK(measure::observed_order(coarse, rung, k) == Approx(rung.order).margin(0.15));
        ++compared;
      }
    }
  }
  return compared;
}

/// The same between two runs only, of `steps` steps and of twice as many: an order of 8 falls from
/// where theory begins to hold down to rounding within two or three halvings of the step. In
/// between the terms of higher order and the rounding, which a fused multiply-add changes, leave up
/// to 0.27; 0.4 still tells it from the orders beside it.
inline void check_order(const mechanics::Method& method, double duration, long steps,
                        const measure::Start& start, const measure::Errors& errors) {
  const auto run = [&](long n) {
    const auto simulation = start(method);
    simulation->advance(n, duration / static_cast<double>(n));
    return errors(simulation->row());
  };
  const std::vector<double> coarse = run(steps), fine = run(2 * steps);
  for (std::size_t k = 0; k < fine.size(); ++k) {
    INFO(method.label() << ", " << 2 * steps << " steps, quantity " << k << ", error " << fine[k]);
    CHECK(std::log2(coarse[k] / fine[k]) ==
          Approx(integrators::info(method.integrator).order).margin(0.4));
  }
}
