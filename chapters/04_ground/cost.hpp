#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <string>

#include "instruments/files/table.hpp"
#include "instruments/measure/clock.hpp"
#include "mechanics/motion/motion.hpp"
#include "scene.hpp"

namespace ground {

/// Processor time of one RK4 step [s].
inline double seconds_per_step(bool simulate_ground) {
  mechanics::Motion<mechanics::Mechanism> rod(make_pendulum(simulate_ground), {});
  return measure::seconds_of([&] { rod.advance(100, 1e-3); }) / 100.0;
}

/// What leaving the ground out saves, as a table.
inline std::string left_out_table() {
  const auto counts = [](bool simulate_ground) {
    mechanics::Mechanism mechanism = make_pendulum(simulate_ground);
    Eigen::VectorXd a = mechanism.initial_position();
    mechanism.acceleration(0.0, mechanism.initial_position(), mechanism.initial_velocity(), a);
    return mechanism.system.counts();
  };
  const dynamics::Counts with = counts(true), without = counts(false);
  const double seconds_with = seconds_per_step(true), seconds_without = seconds_per_step(false);
  files::Table table({"a rod on a grounded plate", "simulated", "left out"});
  table.add("  coordinates", with.coordinates, without.coordinates);
  table.add("  rows", with.rows, without.rows);
  table.add("  degrees of freedom", with.degrees_of_freedom, without.degrees_of_freedom);
  table.add("  blocks of J", with.jacobian_blocks, without.jacobian_blocks);
  table.add("  blocks of the factor", with.factor_blocks, without.factor_blocks);
  table.add("  RK4 step, µs", fmt::format("{:.2f}", 1e6 * seconds_with),
            fmt::format("{:.2f}", 1e6 * seconds_without));
  return table.text({-34, 12, 12}) + fmt::format("leaving it out saves {:.0f} % of the time\n",
                                                 100.0 * (1.0 - seconds_without / seconds_with));
}

}  // namespace ground
