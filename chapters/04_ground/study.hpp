#pragma once

#include "app/study.hpp"
#include "exact.hpp"
#include "scene.hpp"

namespace ground {

/// What is measured and shown of the plate: the commands run, snapshot, report, stability, live, as
/// the arguments say. Returns the exit status.
int study(int argc, char** argv);

/// The exact answer at t [s] under a method: without stabilization the plate stays where it was
/// put; feedback moves it back by the closed form; projection puts it in its place at once.
Exact exact(const Scene& scene, const mechanics::Method& method, double t);

/// Errors of a row: place of the centre [m], angle [rad], reaction force [N], reaction moment
/// [N·m].
std::vector<double> errors(const Scene& scene, const mechanics::Method& method,
                           const mechanics::Row& row);

/// The stiff and extreme cases of the plate, each with the outcome that is expected of it.
measure::Stability stability();

/// The pictures of the lesson: scene, reaction, decay, turned_off.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The plate in motion, with its forces.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace ground
