#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace revolute {

/// What one RK4 step of a chain costs: processor time [s].
struct Cost {
  int links;
  double blocks;  ///< this tutorial's solver
  double full;    ///< full matrices; NaN where they were not tried
};

struct CostTable {
  std::vector<std::string> machine;  ///< "name: value" lines
  std::vector<Cost> rows;
};

/// Full matrices are tried up to 300 links: a step of 1000 takes ten seconds.
CostTable measure_costs();

/// The exponent p of cost ∝ Nᵖ between two chains of the table; NaN where it lacks one.
double growth(const CostTable& costs, int from, int to, double Cost::*seconds);

/// For the eye.
std::string table(const CostTable& costs);

/// As comma-separated values under comment lines, and back. read_costs throws std::runtime_error
/// where the file does not fit.
std::string csv(const CostTable& costs);

CostTable read_costs(const std::filesystem::path& path);

}  // namespace revolute
