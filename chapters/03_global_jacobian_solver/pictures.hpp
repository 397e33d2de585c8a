#pragma once

#include <vector>

#include "program/options.hpp"
#include "program/pictures.hpp"
#include "scene.hpp"

namespace dumbbell {

/// The pictures of the lesson: one_bead, scene, jacobian, motion, drift, stabilization, turned_off.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The scene at t [s], with its constraint forces and the trails of both beads.
program::Picture picture_at(const Scene& scene, const program::RunOptions& run, double t);

}  // namespace dumbbell
