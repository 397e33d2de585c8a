#pragma once

#include <memory>
#include <vector>

#include "cost.hpp"
#include "program/options.hpp"
#include "program/pictures.hpp"
#include "program/stage.hpp"
#include "scene.hpp"

namespace revolute {

/// The pictures of the lesson: scene, motion, chain, chaos, drift, stabilization, turned_off.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The cost of a step against the number of links.
program::Picture cost_picture(const CostTable& costs);

/// The rods in motion, with the pin force and the trail of the free end.
std::unique_ptr<program::Stage> stage(const Scene& scene, const program::RunOptions& run);

}  // namespace revolute
