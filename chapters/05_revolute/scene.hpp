#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace revolute {

using Eigen::Vector2d;
using Eigen::VectorXd;

/// A chain of equal uniform rods, the first pinned to the world at (0, 0), each next one to the end
/// of the one before, at rest in a straight line. One rod is the compound pendulum.
struct Scene {
  int links = 1;
  double length = 1.0;         ///< of all rods together [m]
  double mass = 1.0;           ///< of all rods together [kg]
  double angle0 = 0.0;         ///< of the line, from +x towards +y [rad]
  double gravity = 9.81;       ///< along +y [m/s²]
  bool without_jdotv = false;  ///< the pins give way to rods that turn

  double l() const { return length / links; }  ///< of one rod [m]
  double m() const { return mass / links; }    ///< of one rod [kg]
  /// The rate [rad/s] of the last rod, were all the energy of a fall from level in its turning
  /// about its near end: ½ (m l²/3) ω² = ½ M g L, with m l² = M L²/N³. Longer chains than of
  /// fifty links come through their whips at the rate of fifty.
  double fastest() const {
    return std::pow(std::min(links, 50), 1.5) * std::sqrt(3.0 * gravity / length);
  }
  double I() const { return m() * l() * l() / 12.0; }  ///< of one rod, about its centre [kg·m²]
};

/// The direction from the start of a rod to its end.
inline Vector2d direction(double theta) { return {std::cos(theta), std::sin(theta)}; }

/// The far end of rod i, counted from 0. q holds (x, y, θ) of each rod in turn.
inline Vector2d end_of_rod(const Scene& scene, const VectorXd& q, int i) {
  return q.segment<2>(3 * i) + scene.l() / 2 * direction(q[3 * i + 2]);
}

}  // namespace revolute
