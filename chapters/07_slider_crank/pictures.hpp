#pragma once

#include <memory>
#include <vector>

#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/pictures.hpp"
#include "instruments/pictures/stage.hpp"
#include "scene.hpp"

namespace slider_crank {

/// The pictures of the lesson: scene, motion, forces, energy, drift, stabilization, turned_off.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The mechanism in motion, with its joint reactions and the trail of the rod's middle.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace slider_crank
