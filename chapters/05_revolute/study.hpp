#pragma once

#include "app/study.hpp"
#include "cost.hpp"
#include "scene.hpp"

namespace revolute {

/// What is measured and shown of pendulum and chain: the commands run, snapshot, report, stability,
/// live, as the arguments say. Returns the exit status.
int study(int argc, char** argv);

/// Distance to the exact answer: position [m] and velocity [m/s] of the free end, pin force [N] of
/// the world. Empty for long chains, and where a chain's reference does not hold.
std::vector<double> errors(const Scene& scene, const mechanics::Row& row);

/// The stiff and extreme cases of pendulum and chain, each with the outcome that is expected of it.
measure::Stability stability();

/// The pictures of the lesson: scene, frames, motion, chain, chaos, drift, stabilization,
/// turned_off.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The cost of a step against the number of links.
pictures::Picture cost_picture(const CostTable& costs);

/// The rods in motion, with the pin force and the trail of the free end.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace revolute
