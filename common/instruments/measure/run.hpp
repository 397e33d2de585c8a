#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "mechanics/motion/motion.hpp"

namespace measure {

/// The spaces of time by which a simulation is advanced.
struct Steps {
  long number;
  double length;      ///< [s]
  long stride = 1;    ///< so many between two looks
  double rest = 0.0;  ///< a last, shorter one [s]
};

/// The largest errors of a run and its largest kinetic energy, from its start on.
struct Largest {
  explicit Largest(const mechanics::Measures& at_start)
      : start(at_start.balance()), kinetic(at_start.kinetic) {}

  void look(const mechanics::Measures& now) {
    constraint_error = std::max(constraint_error, now.constraint_error);
    velocity_error = std::max(velocity_error, now.velocity_error);
    energy_error = std::max(std::abs(now.balance() - start), energy_error);  // NaN stays NaN
    kinetic = std::max(kinetic, now.kinetic);
  }
  /// The energy error as a part of the kinetic energy.
  double energy_part() const { return energy_error == 0.0 ? 0.0 : energy_error / kinetic; }

  double start;                   ///< the balance [J]
  double constraint_error = 0.0;  ///< |C|, in its unit
  double velocity_error = 0.0;
  double energy_error = 0.0;  ///< change of the balance [J]; not a number where there is none
  double kinetic;             ///< [J]
};

/// Whether a sink is called with rows; else it is called with, or looks at, the measures.
template <class Sink>
inline constexpr bool takes_rows = std::is_invocable_v<Sink&, const mechanics::Row&>;

/// False where the sink has seen enough.
template <class Sink, class Sight>
bool show(Sink& sink, const Sight& now) {
  if constexpr (std::is_same_v<Sight, mechanics::Row> && !takes_rows<Sink>) {
    return show(sink, now.measures);
  } else if constexpr (requires { sink.look(now); }) {
    sink.look(now);
    return true;
  } else if constexpr (std::is_same_v<std::invoke_result_t<Sink&, const Sight&>, bool>) {
    return sink(now);
  } else {
    sink(now);
    return true;
  }
}

/// The loop of every run that is looked at: moves on, and shows the sinks, in their order, what the
/// simulation is then. A sink looks and does not step: it has a look(measures), as Watch has, or is
/// called with the measures or with the row. One that returns false ends the run, which
/// is then not whole. Throws Diverged as the simulation and the sinks do.
template <class... Sinks>
bool run(mechanics::Simulation& simulation, const Steps& steps, Sinks&&... sinks) {
  const auto look = [&] {
    if constexpr ((takes_rows<Sinks> || ...)) {
      const mechanics::Row now = simulation.row();
      return (show(sinks, now) && ...);
    } else {
      const mechanics::Measures now = simulation.measures();
      return (show(sinks, now) && ...);
    }
  };
  for (long done = 0; done < steps.number;) {
    const long more = std::min(steps.stride, steps.number - done);
    simulation.advance(more, steps.length);
    done += more;
    if (!look()) return false;
  }
  if (steps.rest <= 0.0) return true;
  simulation.advance(1, steps.rest);
  return look();
}

}  // namespace measure
