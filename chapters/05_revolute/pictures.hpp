#pragma once

#include <vector>

#include "cost.hpp"
#include "program/options.hpp"
#include "program/pictures.hpp"
#include "scene.hpp"

namespace revolute {

/// The pictures of the lesson: scene, motion, chain, chaos, drift, stabilization, turned_off.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The cost of a step against the number of links.
program::Picture cost_picture(const CostTable& costs);

/// The scene at t [s], with the pin force and the trail of the free end.
program::Picture picture_at(const Scene& scene, const program::RunOptions& run, double t);

}  // namespace revolute
