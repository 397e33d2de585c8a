#pragma once

#include <memory>
#include <vector>

#include "program/options.hpp"
#include "program/pictures.hpp"
#include "program/stage.hpp"
#include "scene.hpp"

namespace prismatic {

/// The pictures of the lesson: scene, motion, spin, drift, stabilization, turned_off. Those of the
/// spinning rail take 5 rad/s where the scene does not spin.
std::vector<program::Picture> pictures(const Scene& scene, const program::RunOptions& run);

/// The block in motion, with the rail's force and its trail.
std::unique_ptr<program::Stage> stage(const Scene& scene, const program::RunOptions& run);

}  // namespace prismatic
