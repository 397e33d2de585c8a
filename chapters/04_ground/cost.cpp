#include "cost.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>

#include "instruments/measure/clock.hpp"
#include "mechanism.hpp"

namespace ground {
namespace {

/// Processor time of one RK4 step [s], the least of several samples.
double seconds_per_step(bool simulate_ground) {
  mechanics::Motion<mechanics::Mechanism> rod(make_pendulum(simulate_ground), {});
  double best = 1e300;
  for (int sample = 0; sample < 20; ++sample) {
    const double before = measure::cpu_seconds();
    rod.advance(2000, 1e-3);
    best = std::min(best, (measure::cpu_seconds() - before) / 2000.0);
  }
  return best;
}

}  // namespace

std::string left_out_table() {
  const auto counts = [](bool simulate_ground) {
    mechanics::Mechanism mechanism = make_pendulum(simulate_ground);
    Eigen::VectorXd a = mechanism.initial_position();
    mechanism.acceleration(0.0, mechanism.initial_position(), mechanism.initial_velocity(), a);
    return mechanism.system.counts();
  };
  const dynamics::Counts with = counts(true), without = counts(false);
  const double seconds_with = seconds_per_step(true), seconds_without = seconds_per_step(false);
  std::string text =
      fmt::format("{:<34}{:>12}{:>12}\n", "a rod on a grounded plate", "simulated", "left out");
  const auto line = [&](const char* name, auto a, auto b) {
    text += fmt::format("  {:<32}{:>12}{:>12}\n", name, a, b);
  };
  line("coordinates", with.coordinates, without.coordinates);
  line("rows", with.rows, without.rows);
  line("degrees of freedom", with.degrees_of_freedom, without.degrees_of_freedom);
  line("blocks of J", with.jacobian_blocks, without.jacobian_blocks);
  line("blocks of the factor", with.factor_blocks, without.factor_blocks);
  line("RK4 step, µs", fmt::format("{:.2f}", 1e6 * seconds_with),
       fmt::format("{:.2f}", 1e6 * seconds_without));
  return text + fmt::format("leaving it out saves {:.0f} % of the time\n",
                            100.0 * (1.0 - seconds_without / seconds_with));
}

}  // namespace ground
