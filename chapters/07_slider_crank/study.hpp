#pragma once

#include <vector>

#include "app/study.hpp"
#include "scene.hpp"

namespace app {
struct Parameter;
}
namespace measure {
struct Units;
}

namespace slider_crank {

struct Reactions;

/// What is measured and shown of the slider-crank: the commands run, snapshot, report, stability,
/// live, as the arguments say. Returns the exit status.
int study(int argc, char** argv);

/// The options of the machine, whatever turns its wheel.
std::vector<app::Parameter> machine_parameters(Scene& scene);
/// The same machine in other units.
Scene in_units(Scene scene, const measure::Units& units);

/// How far all joint forces of a row together [N] are from the exact ones.
double force_error(const mechanics::Columns& columns, const mechanics::Row& row,
                   const Reactions& truth);

/// Errors of a row: wheel angle [rad], its rate [rad/s], and all joint forces together [N]. Empty
/// where no exact answer is computed.
std::vector<double> errors(const Scene& scene, const mechanics::Columns& columns,
                           const mechanics::Row& row);

/// The stiff and extreme cases of the slider-crank, each with the outcome that is expected of it.
measure::Stability stability();

/// The pictures of the lesson: scene, motion, forces, energy, drift, stabilization, turned_off.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The mechanism in motion, with its joint reactions and the trail of the rod's middle.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace slider_crank
