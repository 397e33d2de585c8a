#pragma once

#include <functional>
#include <string>
#include <vector>

namespace leave_it_out {

/// A way to take one RK4 step of a scene, and its size.
struct Rung {
  std::string name;
  int coordinates, rows;
  std::function<void()> step;
};

/// The slider-crank, each rung without something that the one before still had. The seventh is the
/// sixth with projection; the last two are written for this machine alone.
std::vector<Rung> slider_crank_ladder();

/// What a step costs: processor time [s], the least of many samples, taken in turns so that all
/// see the same machine, and how often it asks for memory.
struct Cost {
  double seconds;
  long allocations;
};
std::vector<Cost> measure_costs(const std::vector<Rung>& rungs);

}  // namespace leave_it_out
