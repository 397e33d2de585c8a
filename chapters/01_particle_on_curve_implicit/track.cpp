#include "track.hpp"

#include <algorithm>
#include <cmath>

#include "exact.hpp"
#include "implicit_bead.hpp"

namespace parabola {

Extent::Extent(const Scene& scene, double duration) : left(scene.x0), right(scene.x0) {
  const ExactMotion motion(scene);
  const double end = std::min(duration, motion.period());
  for (int i = 0; i <= 64; ++i) {
    const double q = motion.at(end * i / 64.0).q;
    left = std::min(left, q);
    right = std::max(right, q);
  }
  // A bead at rest still needs some of the track around it.
  const double room = std::max({0.02 * scene.p, 0.05 * (right - left), 0.02 * std::abs(left)});
  left -= room;
  right += room;
}

draw::View view(const Scene& scene, const Extent& extent, double above, double below) {
  const double low = extent.left < 0.0 && extent.right > 0.0
                         ? 0.0
                         : std::max(scene.height(extent.left), scene.height(extent.right));
  const double high = std::min(scene.height(extent.left), scene.height(extent.right));
  const double side = std::max(extent.right - extent.left, low - high);
  return {extent.left - 0.02 * side, high - above * side, extent.right + 0.02 * side,
          low + below * side};
}

void draw_track(draw::Canvas& canvas, const Scene& scene, const draw::View& view) {
  const double margin = view.right - view.left;  // the canvas may be wider than the view
  std::vector<draw::Point> points;
  for (int i = 0; i <= 600; ++i) {
    const double x = view.left - margin + 3.0 * margin * i / 600.0;
    const double y = scene.height(x);
    if (y > view.top - 0.05 * (view.bottom - view.top)) points.push_back({x, y});
  }
  canvas.curve(points, canvas.theme().track, 2.4);
}

void draw_bead(draw::Canvas& canvas, const Scene& scene, const Eigen::Vector2d& x,
               double presence) {
  canvas.bead(point(x), 7.0, canvas.theme().body.faded(presence),
              canvas.theme().body_edge.faded(presence));
  Eigen::Vector2d foot = x, v = Eigen::Vector2d::Zero();
  ImplicitBead(scene).project(0.0, foot, v);
  canvas.gap(point(foot), point(x));
}

}  // namespace parabola
