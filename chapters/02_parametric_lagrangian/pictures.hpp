#pragma once

#include <memory>
#include <vector>

#include "parabola/scene.hpp"
#include "program/options.hpp"
#include "program/pictures.hpp"
#include "program/stage.hpp"

namespace parametric_lagrangian {

/// The pictures of the lesson: scene, motion (the article's side by side), drift, turned_off.
std::vector<program::Picture> pictures(const parabola::Scene& scene,
                                       const program::RunOptions& run);

/// Both methods in motion, side by side.
std::unique_ptr<program::Stage> stage(const parabola::Scene& scene, const program::RunOptions& run);

}  // namespace parametric_lagrangian
