#pragma once

#include <memory>
#include <vector>

#include "program/options.hpp"
#include "program/pictures.hpp"
#include "program/stage.hpp"
#include "scene.hpp"

namespace ground {

/// The pictures of the lesson: scene, reaction, decay, turned_off.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The plate in motion, with its forces.
std::unique_ptr<program::Stage> stage(const Scene& scene, const program::RunOptions& run);

}  // namespace ground
