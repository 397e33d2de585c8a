#pragma once

#include <cmath>
#include <string>

#include "07_slider_crank/scene.hpp"

namespace drivers {

/// The machine of chapter 7 with a motor on its wheel, which turns the crank as it is told: from
/// the machine's theta0 by `turn`, along an ease.
struct Scene {
  slider_crank::Scene machine{.torque = 0.0};
  std::string ease = "smooth";
  double turn = 4.0;         ///< [rad]
  double move = 2.0;         ///< time that it takes [s]
  double delay = 0.0;        ///< before it [s]
  bool end_at_jumps = true;  ///< a step ends where the ease's second derivative may jump

  /// A bound of the wheel's rate [rad/s], five times the mean: no ease is faster.
  double fastest() const { return 5.0 * std::abs(turn) / move; }
};

}  // namespace drivers
