#pragma once

#include <vector>

#include "parabola/scene.hpp"
#include "program/options.hpp"
#include "program/pictures.hpp"

namespace parametric_lagrangian {

/// The pictures of the lesson: scene, motion (the article's side by side), drift, turned_off.
std::vector<program::Picture> pictures(const parabola::Scene& scene,
                                       const program::RunOptions& run);

/// Both methods side by side at t [s].
program::Picture picture_at(const parabola::Scene& scene, const program::RunOptions& run, double t);

}  // namespace parametric_lagrangian
