#pragma once

#include <memory>
#include <vector>

#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/pictures.hpp"
#include "instruments/pictures/stage.hpp"
#include "scene.hpp"

namespace dumbbell {

/// The pictures of the lesson: one_bead, scene, jacobian, motion, drift, stabilization, turned_off.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The beads in motion, with their constraint forces and their trails.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace dumbbell
