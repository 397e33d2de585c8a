#pragma once

#include <memory>
#include <vector>

#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/pictures.hpp"
#include "instruments/pictures/stage.hpp"
#include "scene.hpp"

namespace particle_on_curve {

/// The pictures of the lesson: scene, motion, drift, stabilization, erratum, turned_off.
std::vector<pictures::Picture> pictures(const parabola::Scene& scene,
                                        const measure::RunOptions& run);

/// The particle in motion, with its forces and its trail.
std::unique_ptr<pictures::Stage> stage(const parabola::Scene& scene,
                                       const measure::RunOptions& run);

}  // namespace particle_on_curve
