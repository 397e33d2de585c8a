#pragma once

#include <vector>

#include "parabola/scene.hpp"
#include "program/options.hpp"
#include "program/pictures.hpp"

namespace particle_on_curve {

/// The pictures of the lesson: scene, motion, drift, stabilization, erratum, turned_off.
std::vector<program::Picture> pictures(const parabola::Scene& scene,
                                       const program::RunOptions& run);

/// The scene at t [s], with its forces and the trail of the motion.
program::Picture picture_at(const parabola::Scene& scene, const program::RunOptions& run, double t);

}  // namespace particle_on_curve
