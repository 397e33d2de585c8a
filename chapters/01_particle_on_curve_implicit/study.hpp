#pragma once

#include "app/study.hpp"
#include "scene.hpp"

namespace particle_on_curve {

/// What is measured and shown of the bead: the commands run, snapshot, report, stability, live, as
/// the arguments say. Returns the exit status.
int study(int argc, char** argv);

/// Distance to the exact state, for position [m], velocity [m/s] and constraint force [N].
std::vector<double> errors(const parabola::Scene& scene, const mechanics::Row& row);

/// The stiff and extreme cases of the bead, each with the outcome that is expected of it.
measure::Stability stability();

/// The pictures of the lesson: curve, scene, motion, drift, stabilization, erratum, turned_off.
std::vector<pictures::Picture> pictures(const parabola::Scene& scene,
                                        const measure::RunOptions& run);

/// The particle in motion, with its forces and its trail.
std::unique_ptr<pictures::Stage> stage(const parabola::Scene& scene,
                                       const measure::RunOptions& run);

}  // namespace particle_on_curve
