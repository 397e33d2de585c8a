#pragma once

#include "app/study.hpp"
#include "scene.hpp"

namespace drivers {

/// What is measured and shown of the driven machine: the commands run, snapshot, report, stability,
/// live, as the arguments say. Returns the exit status.
int study(int argc, char** argv);

/// Errors of a row: the motor's torque [N·m], wheel angle [rad], its rate [rad/s], and all joint
/// forces together [N].
std::vector<double> errors(const Scene& scene, const mechanics::Columns& columns,
                           const mechanics::Row& row);

/// The largest torque [N·m] of the motor during its move.
double largest_torque(const Scene& scene);

/// The stiff and extreme cases of the driven machine, each with the outcome that is expected of it.
measure::Stability stability();

/// The pictures of the lesson: scene, eases, torque, orders, turned_off.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The machine in motion, with the forces of its joints and the torque of its motor.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace drivers
