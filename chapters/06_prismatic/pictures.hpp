#pragma once

#include <vector>

#include "program/options.hpp"
#include "program/pictures.hpp"
#include "scene.hpp"

namespace prismatic {

/// The pictures of the lesson: scene, motion, spin, drift, stabilization, turned_off. Those of the
/// spinning rail take 5 rad/s where the scene does not spin.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The scene at t [s], with the rail's force and the trail of the block.
program::Picture picture_at(const Scene& scene, const program::RunOptions& run, double t);

}  // namespace prismatic
