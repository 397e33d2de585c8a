#include "cost.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "full_matrices.hpp"
#include "instruments/measure/clock.hpp"
#include "instruments/measure/ladder.hpp"
#include "mechanics/integrators/integrator.hpp"
#include "mechanism.hpp"

namespace revolute {
namespace {

/// The smallest of several repeats, of a chain in which every link turns: in one that has just
/// been released the motion dies out along the chain, down to numbers so small that a processor
/// slows down on them.
template <class Acceleration>
double seconds_per_step(int links, Acceleration&& acceleration) {
  mechanics::Mechanism chain = make_mechanism({.links = links});
  VectorXd q = chain.initial_position(), v = chain.initial_velocity();
  for (int i = 0; i < links; ++i) v[3 * i + 2] = std::sin(i + 1.0);
  chain.project(q, v);
  integrators::Integrator<VectorXd> integrator(integrators::Scheme::rk4, q);
  const auto of_state = [&](double, const VectorXd& q_now, const VectorXd& v_now, VectorXd& a) {
    acceleration(q_now, v_now, a);
  };
  double best = std::numeric_limits<double>::infinity(), total = 0.0;
  const long steps = std::max(2L, 2000L / links);
  for (int repeat = 0; (repeat < 20 && total < 1.0) || total < 0.05; ++repeat) {
    const double before = measure::cpu_seconds();
    for (long i = 0; i < steps; ++i) integrator.step(of_state, 0.0, q, v, 1e-6);
    const double seconds = measure::cpu_seconds() - before;
    best = std::min(best, seconds / static_cast<double>(steps));
    total += seconds;
  }
  return best;
}

double seconds_in_blocks(int links) {
  mechanics::Mechanism chain = make_mechanism({.links = links});
  return seconds_per_step(links, [&](const VectorXd& q, const VectorXd& v, VectorXd& a) {
    chain.acceleration(0.0, q, v, a);
  });
}

double seconds_in_full_matrices(int links) {
  FullMatrices chain({.links = links});
  return seconds_per_step(links, [&](const VectorXd& q, const VectorXd& v, VectorXd& a) {
    chain.acceleration(q, v, a);
  });
}

}  // namespace

CostTable measure_costs() {
  constexpr int longest_full = 300;
  CostTable costs{measure::machine(), {}};
  for (const int links : {1, 2, 3, 5, 10, 20, 30, 50, 100, 200, 300, 500, 1000, 3000, 10000})
    costs.rows.push_back({links, seconds_in_blocks(links),
                          links <= longest_full ? seconds_in_full_matrices(links)
                                                : std::numeric_limits<double>::quiet_NaN()});
  return costs;
}

double growth(const CostTable& costs, int from, int to, double Cost::*seconds) {
  const Cost *first = nullptr, *last = nullptr;
  for (const Cost& cost : costs.rows) {
    if (cost.links == from) first = &cost;
    if (cost.links == to) last = &cost;
  }
  if (first == nullptr || last == nullptr) return std::numeric_limits<double>::quiet_NaN();
  return std::log(last->*seconds / first->*seconds) / std::log(static_cast<double>(to) / from);
}

std::string table(const CostTable& costs) {
  std::string text = fmt::format("{:>8}{:>20}{:>14}{:>14}\n", "links", "full matrices, µs",
                                 "blocks, µs", "a link, µs");
  for (const Cost& cost : costs.rows)
    text += fmt::format("{:>8}{:>20}{:>14.4g}{:>14.3g}\n", cost.links,
                        std::isnan(cost.full) ? "–" : fmt::format("{:.4g}", 1e6 * cost.full),
                        1e6 * cost.blocks, 1e6 * cost.blocks / cost.links);
  return text + fmt::format(
                    "the step in blocks grows as N^{:.2f} from 10 links to 1000 and as N^{:.2f} "
                    "to 10000, that in full matrices as N^{:.2f} from 30 to 300\n",
                    growth(costs, 10, 1000, &Cost::blocks), growth(costs, 10, 10000, &Cost::blocks),
                    growth(costs, 30, 300, &Cost::full));
}

std::string csv(const CostTable& costs) {
  std::string text;
  for (const std::string& line : costs.machine) text += fmt::format("# machine: {}\n", line);
  text += "links,blocks_seconds,full_seconds\n";
  for (const Cost& cost : costs.rows) {
    text += fmt::format("{},{:.6g},", cost.links, cost.blocks);
    text += std::isnan(cost.full) ? "\n" : fmt::format("{:.6g}\n", cost.full);
  }
  return text;
}

CostTable read_costs(const std::filesystem::path& path) {
  std::ifstream stream(path);
  CostTable costs;
  const std::string machine = "# machine: ";
  for (std::string line; std::getline(stream, line);) {
    Cost cost{0, 0.0, std::numeric_limits<double>::quiet_NaN()};
    if (line.starts_with(machine))
      costs.machine.push_back(line.substr(machine.size()));
    else if (std::sscanf(line.c_str(), "%d,%lf,%lf", &cost.links, &cost.blocks, &cost.full) >= 2)
      costs.rows.push_back(cost);
  }
  if (costs.rows.size() < 2)
    throw std::runtime_error(fmt::format("{}: not a table of costs", path.string()));
  return costs;
}

}  // namespace revolute
