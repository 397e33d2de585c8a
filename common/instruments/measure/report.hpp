#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "instruments/measure/ladder.hpp"

namespace measure {

/// What the names of methods begin with that step a scene in one coordinate, without constraints.
inline const std::string one_coordinate = "one coordinate: ";

/// A measured ladder with the names of what was measured: what `report` prints, saves and draws.
struct Report {
  std::string title;  ///< of the chapter
  double duration;    ///< [s]
  std::string constraint_unit;
  std::vector<measure::Quantity> quantities;
  std::vector<std::string> machine;  ///< "name: value" lines
  std::vector<measure::Rung> rungs;
  std::string remark = {};  ///< on how the curves end, for the plot
};

/// The levels of error whose price the reader asks for.
inline constexpr double error_levels[] = {1e-3, 1e-6, 1e-9};

/// The processor time [s] from which on all of a method's runs, failed ones aside, stay below the
/// level, interpolated between the rungs on both sides of it; infinite if the last is not below.
double time_to_reach(const Report& report, const std::string& method, double level);

/// The methods of the report, in the order of its rungs.
std::vector<std::string> methods(const Report& report);

/// The time to reach each level, each method, fastest first, under a line on the machine.
std::string short_table(const Report& report);

/// The whole table for the eye: machine, all rungs with their orders, then the time to reach each
/// level.
std::string table(const Report& report);

/// The same as comma-separated values: comment lines "# name: value" for all but the rungs, a
/// header row, a row a rung. `read_csv` reads it back; it throws std::runtime_error where the file
/// does not fit.
std::string csv(const Report& report);
Report read_csv(const std::filesystem::path& path);

}  // namespace measure
