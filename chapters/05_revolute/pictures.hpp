#pragma once

#include <memory>
#include <vector>

#include "cost.hpp"
#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/pictures.hpp"
#include "instruments/pictures/stage.hpp"
#include "scene.hpp"

namespace revolute {

/// The pictures of the lesson: scene, motion, chain, chaos, drift, stabilization, turned_off.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The cost of a step against the number of links.
pictures::Picture cost_picture(const CostTable& costs);

/// The rods in motion, with the pin force and the trail of the free end.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace revolute
