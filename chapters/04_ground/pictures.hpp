#pragma once

#include <memory>
#include <vector>

#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/pictures.hpp"
#include "instruments/pictures/stage.hpp"
#include "scene.hpp"

namespace ground {

/// The pictures of the lesson: scene, reaction, decay, turned_off.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The plate in motion, with its forces.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace ground
