#pragma once

#include <memory>
#include <vector>

#include "parabola/scene.hpp"
#include "program/options.hpp"
#include "program/pictures.hpp"
#include "program/stage.hpp"

namespace particle_on_curve {

/// The pictures of the lesson: scene, motion, drift, stabilization, erratum, turned_off.
std::vector<program::Picture> pictures(const parabola::Scene& scene,
                                       const program::RunOptions& run);

/// The particle in motion, with its forces and its trail.
std::unique_ptr<program::Stage> stage(const parabola::Scene& scene, const program::RunOptions& run);

}  // namespace particle_on_curve
