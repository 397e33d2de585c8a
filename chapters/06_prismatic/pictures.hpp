#pragma once

#include <memory>
#include <vector>

#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/pictures.hpp"
#include "instruments/pictures/stage.hpp"
#include "scene.hpp"

namespace prismatic {

/// The pictures of the lesson: scene, motion, spin, drift, stabilization, turned_off. Those of the
/// spinning rail take 5 rad/s where the scene does not spin.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);

/// The block in motion, with the rail's force and its trail.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace prismatic
