#pragma once

#include "app/study.hpp"
#include "scene.hpp"

namespace dumbbell {

/// What is measured and shown of the dumbbell: the commands run, snapshot, report, stability, live,
/// as the arguments say. Returns the exit status.
int study(int argc, char** argv);

/// Distance to the exact state, over both beads, for position [m], velocity [m/s] and the forces of
/// both curves and the rod [N].
std::vector<double> errors(const Scene& scene, const mechanics::Row& row);

/// The stiff and extreme cases of the dumbbell, each with the outcome that is expected of it.
measure::Stability stability();

/// The pictures of the lesson: one_bead, scene, jacobian, motion, drift, stabilization, turned_off.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The beads in motion, with their constraint forces and their trails.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace dumbbell
