#pragma once

#include "app/study.hpp"
#include "scene.hpp"

namespace prismatic {

/// What is measured and shown of block and rail: the commands run, snapshot, report, stability,
/// live, as the arguments say. Returns the exit status.
int study(int argc, char** argv);

/// Distance to the exact answer, of the block: position [m], velocity [m/s], and the rail's force
/// [N] and moment [N·m] on it.
std::vector<double> errors(const Scene& scene, const mechanics::Row& row);

/// The stiff and extreme cases of block and rail, each with the outcome that is expected of it.
measure::Stability stability();

/// The pictures of the lesson: scene, symbols, motion, spin, drift, stabilization, turned_off.
/// Those of the spinning rail take 5 rad/s where the scene does not spin, and none has spring or
/// damper.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The block in motion, with the rail's force and its trail.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace prismatic
