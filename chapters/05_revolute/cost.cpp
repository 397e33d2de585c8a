#include "cost.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "full_matrices.hpp"
#include "instruments/files/table.hpp"
#include "instruments/measure/clock.hpp"
#include "instruments/measure/ladder.hpp"
#include "mechanics/integrators/integrator.hpp"
#include "mechanism.hpp"

namespace revolute {
namespace {

/// Of a chain in which every link turns: in one that has just been released the motion dies out
/// along the chain, down to numbers so small that a processor slows down on them.
template <class Acceleration>
double seconds_per_step(int links, Acceleration&& acceleration) {
  mechanics::Mechanism chain = make_mechanism({.links = links});
  VectorXd q = chain.initial_position(), v = chain.initial_velocity();
  for (int i = 0; i < links; ++i) v[3 * i + 2] = std::sin(i + 1.0);
  chain.project(0.0, q, v);
  integrators::Integrator<VectorXd> integrator(integrators::Scheme::rk4, q);
  const auto of_state = [&](double, const VectorXd& q_now, const VectorXd& v_now, VectorXd& a) {
    acceleration(q_now, v_now, a);
  };
  return measure::seconds_of([&] { integrator.step(of_state, 0.0, q, v, 1e-6); });
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
  files::Table table({"links", "full matrices, µs", "blocks, µs", "a link, µs"});
  for (const Cost& cost : costs.rows)
    table.add(cost.links, std::isnan(cost.full) ? "–" : files::digits(1e6 * cost.full, 4),
              files::digits(1e6 * cost.blocks, 4),
              files::digits(1e6 * cost.blocks / cost.links, 3));
  return table.text({8, 20, 14, 14}) +
         fmt::format(
             "the step in blocks grows as N^{:.2f} from 10 links to 1000 and as N^{:.2f} "
             "to 10000, that in full matrices as N^{:.2f} from 30 to 300\n",
             growth(costs, 10, 1000, &Cost::blocks), growth(costs, 10, 10000, &Cost::blocks),
             growth(costs, 30, 300, &Cost::full));
}

std::string csv(const CostTable& costs) {
  files::Table table({"links", "blocks_seconds", "full_seconds"});
  for (const std::string& line : costs.machine) table.note("machine", line);
  for (const Cost& cost : costs.rows)
    table.add(cost.links, files::digits(cost.blocks), files::digits(cost.full));
  return table.csv();
}

CostTable read_costs(const std::filesystem::path& path) {
  CostTable costs;
  files::read_csv(
      path,
      [&](const files::SavedRow& row) {
        costs.rows.push_back({row.number<int>("links"), row.number("blocks_seconds"),
                              row["full_seconds"].empty() ? std::numeric_limits<double>::quiet_NaN()
                                                          : row.number("full_seconds")});
      },
      [&](const std::string&, const std::string& line) { costs.machine.push_back(line); });
  if (costs.rows.size() < 2)
    throw std::runtime_error(fmt::format("{}: not a table of costs", path.string()));
  return costs;
}

}  // namespace revolute
