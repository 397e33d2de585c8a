#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine.hpp"

namespace peers {

/// One run of one setting, or the words why there is none.
struct Row {
  std::string engine, version, setting;
  bool is_default;
  int parts;  ///< of the model
  Rung rung;
  double value;                      ///< the step [s] or the accuracy
  long steps = 0;                    ///< that were timed; 0: the run failed
  double seconds = 0;                ///< processor time of the run, smallest of several
  std::optional<double> error = {};  ///< see peers::error; none for a long chain
  double energy_error = 0;           ///< change of the balance over the kinetic energy at the end
  double joint_gap = 0;              ///< at the end [m]
  std::string failure = {};          ///< in words; empty when all went well

  double seconds_a_step() const { return seconds / static_cast<double>(steps); }
};

/// What the ladders may spend.
struct Limits {
  double run_seconds;    ///< on one run: a ladder ends before a rung that would take longer
  double first_seconds;  ///< the same while no run of the ladder went well
  int most_rungs = 24;   ///< of one ladder
};

using Progress = std::function<void(double done, const std::string& what)>;

/// Climbs the ladder of each setting on a model; those of `in_chain` only, unless it is the
/// slider-crank. `before` holds the rows of a shorter chain, by which is foreseen what one step
/// costs: a run that cannot fit becomes a row that says so.
std::vector<Row> climb(const Model& model, const std::vector<Engine>& engines, const Limits& limits,
                       const std::vector<Row>& before, const Progress& progress);

}  // namespace peers
