#pragma once

#include <memory>
#include <vector>

#include "01_particle_on_curve_implicit/scene.hpp"
#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/pictures.hpp"
#include "instruments/pictures/stage.hpp"

namespace parametric_lagrangian {

/// The pictures of the lesson: scene, motion (the article's side by side), drift, turned_off.
std::vector<pictures::Picture> pictures(const parabola::Scene& scene,
                                        const measure::RunOptions& run);

/// Both methods in motion, side by side.
std::unique_ptr<pictures::Stage> stage(const parabola::Scene& scene,
                                       const measure::RunOptions& run);

}  // namespace parametric_lagrangian
