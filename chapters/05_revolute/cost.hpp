#pragma once

#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "integrators/integrator.hpp"
#include "measure/clock.hpp"
#include "measure/ladder.hpp"
#include "scene.hpp"

namespace revolute {

/// What one RK4 step of a chain costs.
struct Cost {
  int links;
  double seconds;  ///< processor time of a step, smallest of several repeats
};

struct CostTable {
  std::vector<std::string> machine;  ///< "name: value" lines
  std::vector<Cost> rows;
};

/// Of a chain in which every link turns: in one that has just been released the motion dies out
/// along the chain, down to numbers so small that a processor slows down on them.
inline double seconds_per_step(int links) {
  program::Mechanism chain = make_mechanism({.links = double(links)});
  VectorXd q = chain.initial_position(), v = chain.initial_velocity();
  for (int i = 0; i < links; ++i) v[3 * i + 2] = std::sin(i + 1.0);
  chain.project(q, v);
  integrators::Integrator<VectorXd> integrator(integrators::Name::rk4, q);
  const auto acceleration = [&](double t, const VectorXd& q_now, const VectorXd& v_now,
                                VectorXd& a) { chain.acceleration(t, q_now, v_now, a); };
  const long steps = std::max(1L, 2000L / links);
  double best = std::numeric_limits<double>::infinity(), total = 0.0;
  for (int repeat = 0; repeat < 20 || total < 0.05; ++repeat) {
    const double before = measure::cpu_seconds();
    for (long i = 0; i < steps; ++i) integrator.step(acceleration, 0.0, q, v, 1e-6);
    const double seconds = measure::cpu_seconds() - before;
    best = std::min(best, seconds / static_cast<double>(steps));
    total += seconds;
  }
  return best;
}

inline CostTable measure_costs() {
  CostTable costs{measure::machine(), {}};
  for (const int links : {1, 2, 3, 5, 10, 20, 30, 50, 100, 200, 300, 500, 1000})
    costs.rows.push_back({links, seconds_per_step(links)});
  return costs;
}

/// The exponent p of cost ∝ Nᵖ between the first chain of `from` links or more and the last.
inline double growth(const CostTable& costs, int from) {
  const Cost& last = costs.rows.back();
  for (const Cost& cost : costs.rows)
    if (cost.links >= from && cost.links < last.links)
      return std::log(last.seconds / cost.seconds) /
             std::log(static_cast<double>(last.links) / cost.links);
  return std::numeric_limits<double>::quiet_NaN();
}

/// For the eye.
inline std::string table(const CostTable& costs) {
  std::string text =
      fmt::format("{:>8}{:>16}{:>20}\n", "links", "a step, µs", "a step and link, µs");
  for (const Cost& cost : costs.rows)
    text += fmt::format("{:>8}{:>15.3g}{:>20.3g}\n", cost.links, 1e6 * cost.seconds,
                        1e6 * cost.seconds / cost.links);
  return text;
}

/// As comma-separated values under comment lines, and back. read_costs throws std::runtime_error
/// where the file does not fit.
inline std::string csv(const CostTable& costs) {
  std::string text;
  for (const std::string& line : costs.machine) text += fmt::format("# machine: {}\n", line);
  text += "links,seconds\n";
  for (const Cost& cost : costs.rows) text += fmt::format("{},{:.6g}\n", cost.links, cost.seconds);
  return text;
}

inline CostTable read_costs(const std::filesystem::path& path) {
  std::ifstream stream(path);
  CostTable costs;
  const std::string machine = "# machine: ";
  for (std::string line; std::getline(stream, line);) {
    Cost cost{};
    if (line.starts_with(machine))
      costs.machine.push_back(line.substr(machine.size()));
    else if (std::sscanf(line.c_str(), "%d,%lf", &cost.links, &cost.seconds) == 2)
      costs.rows.push_back(cost);
  }
  if (costs.rows.size() < 2)
    throw std::runtime_error(fmt::format("{}: not a table of costs", path.string()));
  return costs;
}

}  // namespace revolute
