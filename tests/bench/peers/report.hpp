#pragma once

#include <string>
#include <vector>

#include "measure.hpp"

namespace peers {

struct Report {
  std::vector<std::string> machine;  ///< "name: value" lines, the engines' versions among them
  std::vector<Row> slider_crank, chain;
};

/// The engines of some rows, in their order.
std::vector<std::string> names(const std::vector<Row>& rows);

/// The largest error of a run and of all finer ones of its setting: of a run that is better than
/// these by luck, where its error passes through zero, nobody can know it.
double lasting_error(const std::vector<Row>& rows, const Row& row);

/// The cheapest run of an engine whose lasting error is no larger than `level`; null if there is
/// none.
const Row* cheapest(const std::vector<Row>& rows, const std::string& engine, double level);

/// The engine's run as it comes; null where it failed or there is none.
const Row* default_run(const std::vector<Row>& rows, const std::string& engine, int parts);

/// The least processor time of a step [s] of an engine in a chain; infinite if no run went well.
double step_seconds(const std::vector<Row>& rows, const std::string& engine, int links);

std::string csv(const std::vector<std::string>& machine, const std::vector<Row>& rows,
                const std::string& error_unit);

/// For the eye.
std::string slider_crank_table(const Report& report);
std::string chain_table(const Report& report);

}  // namespace peers
