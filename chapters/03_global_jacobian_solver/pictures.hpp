#pragma once

#include <memory>
#include <vector>

#include "program/options.hpp"
#include "program/pictures.hpp"
#include "program/stage.hpp"
#include "scene.hpp"

namespace dumbbell {

/// The pictures of the lesson: one_bead, scene, jacobian, motion, drift, stabilization, turned_off.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The beads in motion, with their constraint forces and their trails.
std::unique_ptr<program::Stage> stage(const Scene& scene, const program::RunOptions& run);

}  // namespace dumbbell
