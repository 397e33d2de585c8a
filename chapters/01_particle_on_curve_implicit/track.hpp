#pragma once

#include <Eigen/Core>
#include <vector>

#include "instruments/pictures/lesson.hpp"
#include "scene.hpp"

namespace parabola {

/// The part of the track that the bead visits in `duration` seconds.
struct Extent {
  double left, right;  ///< [m]

  Extent(const Scene& scene, double duration);
};

/// What must be visible to show that part, with `above` and `below` as room for arrows, in parts of
/// the larger side.
draw::View view(const Scene& scene, const Extent& extent, double above, double below);

/// The curve itself, over the whole width of the view.
void draw_track(draw::Canvas& canvas, const Scene& scene, const draw::View& view);

/// The bead, 7 points in radius, and the gap where it is off the curve; `presence` below 1 makes it
/// a ghost.
void draw_bead(draw::Canvas& canvas, const Scene& scene, const Eigen::Vector2d& x,
               double presence = 1.0);

using pictures::lesson::point;

}  // namespace parabola
