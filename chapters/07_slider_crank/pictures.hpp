#pragma once

#include <vector>

#include "program/options.hpp"
#include "program/pictures.hpp"
#include "scene.hpp"

namespace slider_crank {

/// The pictures of the lesson: scene, motion, forces, energy, drift, stabilization, turned_off.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The mechanism at t [s], with its joint reactions.
program::Picture picture_at(const Scene& scene, const program::RunOptions& run, double t);

}  // namespace slider_crank
