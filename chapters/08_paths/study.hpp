#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>
#include "app/study.hpp"

#include "exact.hpp"
#include "instruments/measure/ladder.hpp"
#include "mechanics/paths/path.hpp"
#include "scene.hpp"

namespace any_wire {

/// What is measured and shown of a bead on any wire: the commands run, snapshot, report, stability,
/// live, as the arguments say. Returns the exit status.
int study(int argc, char** argv);

/// The bead of a scene, by parameter or by length as it says.
measure::Start start(const Scene& scene);
/// What its energy knows of a path.
Wire as_energy_sees(const paths::Path& path);

/// The exact state at t [s]; nothing where none is computed or the bead has left the wire.
std::function<std::optional<State>(double t)> exact_motion(const Scene& scene);

/// Distance to the exact place [m] and from the exact speed [m/s]; empty where there is none.
std::vector<double> errors(const Scene& scene, const mechanics::Row& row);

/// The order of RK4 on splines that are smooth to different degrees.
struct Order {
  std::string wire;
  std::string by;              ///< "parameter", "length", or "length to knots": steps end there
  std::vector<double> errors;  ///< of place [m], mean over start speeds; steps halved each time
  double order;                ///< from the first to the last
  double seconds;              ///< processor time of a step
};
inline constexpr long coarsest_steps = 50;
inline constexpr int start_speeds = 12;
std::vector<Order> orders();

/// The stiff and extreme cases, each with the outcome that is expected of it.
measure::Stability stability();

/// The pictures of the lesson: scene, the wire with its tangents and the bead's speed, for any
/// path; and with the first path those of its chapter: motion, corner, symplectic.
std::vector<pictures::Picture> pictures(const Scene& scene, const measure::RunOptions& run);
/// The plot of orders().
pictures::Picture orders_picture(const std::vector<Order>& orders);

/// The bead in motion, with its force and its trail.
std::unique_ptr<pictures::Stage> stage(const Scene& scene, const measure::RunOptions& run);

}  // namespace any_wire
