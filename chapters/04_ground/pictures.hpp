#pragma once

#include <vector>

#include "program/options.hpp"
#include "program/pictures.hpp"
#include "scene.hpp"

namespace ground {

/// The pictures of the lesson: scene, reaction, decay, turned_off.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The plate at t [s], with its forces.
program::Picture picture_at(const Scene& scene, const program::RunOptions& run, double t);

}  // namespace ground
