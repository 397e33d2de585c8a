#pragma once

#include <memory>
#include <vector>

#include "program/options.hpp"
#include "program/pictures.hpp"
#include "program/stage.hpp"
#include "scene.hpp"

namespace slider_crank {

/// The pictures of the lesson: scene, motion, forces, energy, drift, stabilization, turned_off.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The mechanism in motion, with its joint reactions and the trail of the rod's middle.
std::unique_ptr<program::Stage> stage(const Scene& scene, const program::RunOptions& run);

}  // namespace slider_crank
