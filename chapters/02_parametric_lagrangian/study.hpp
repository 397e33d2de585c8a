#pragma once

#include "01_particle_on_curve_implicit/scene.hpp"
#include "app/study.hpp"

namespace parametric_lagrangian {

/// What is measured and shown of the parametric bead: the commands run, snapshot, report,
/// stability, live, as the arguments say. Returns the exit status.
int study(int argc, char** argv);

/// Errors of q [m] and q̇ [m/s] against the exact motion, which this chapter's lesson derives from
/// its own energy: that of chapter 1.
std::vector<double> errors(const parabola::Scene& scene, const mechanics::Row& row);

/// The stiff and extreme cases of the parametric bead, each with the outcome that is expected of
/// it.
measure::Stability stability();

/// The pictures of the lesson: scene, motion (the article's side by side), drift, turned_off.
std::vector<pictures::Picture> pictures(const parabola::Scene& scene,
                                        const measure::RunOptions& run);

/// Both methods in motion, side by side.
std::unique_ptr<pictures::Stage> stage(const parabola::Scene& scene,
                                       const measure::RunOptions& run);

}  // namespace parametric_lagrangian
