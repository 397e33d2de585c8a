#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace prismatic {

using Eigen::Vector2d;

/// A block on a rail. Without spin the rail is fixed in the world and inclined; the block starts at
/// rest at (0, 0), or elsewhere along the rail, and a spring to (0, 0) and a damper may act on it.
/// With spin the rail is a body, pinned to the world at its centre (0, 0) and free to turn, and
/// nothing weighs anything; the block starts on it at (0.3 m, 0).
struct Scene {
  double incline = 30.0;  ///< of the fixed rail; positive: it descends to the right [°]
  double mass = 1.0;      ///< of the block [kg]
  double gravity = 9.81;  ///< along +y; on the fixed rail only [m/s²]
  double spin = 0.0;      ///< of the rail at the start; 0: it is fixed [rad/s]
  // Along the fixed rail only.
  double stiffness = 0.0;         ///< of the spring that pulls the block to (0, 0); 0: none [N/m]
  double damping = 0.0;           ///< of the damper between block and rail; 0: none [N·s/m]
  bool without_coriolis = false;  ///< of the turning rail's J̇v
  double s0 = 0.0, v0 = 0.0;  ///< of the block at the start: its way from (0, 0) and its velocity
                              ///< [m], [m/s]

  // No options, but other units change them too.
  double width = 0.2, height = 0.1;            ///< of the block [m]
  double rail_mass = 1.0, rail_inertia = 1.0;  ///< [kg], [kg·m²]
  double r0 = 0.3;  ///< of the block on the spinning rail, at the start [m]

  bool spins() const { return spin != 0.0; }
  bool sprung() const { return stiffness != 0.0 || damping != 0.0; }
  double angle() const { return incline * std::numbers::pi / 180.0; }                 ///< [rad]
  double inertia() const { return mass * (width * width + height * height) / 12.0; }  ///< [kg·m²]
};

/// The fastest rate [1/s] at which spring and damper change the motion: of the larger root of
/// x² + c/m x + k/m, to within a factor of two.
inline double fastest(const Scene& scene) {
  return std::max(std::sqrt(scene.stiffness / scene.mass), scene.damping / scene.mass);
}

/// Along the rail at angle θ, and across it.
inline Vector2d along(double theta) { return {std::cos(theta), std::sin(theta)}; }
inline Vector2d across(double theta) { return {-std::sin(theta), std::cos(theta)}; }

/// The angular momentum [kg·m²/s] of the spinning scene about the pin.
inline double angular_momentum(const Scene& scene, const Eigen::VectorXd& q,
                               const Eigen::VectorXd& v) {
  return scene.rail_inertia * v[2] + scene.inertia() * v[5] +
         scene.mass * (q[3] * v[4] - q[4] * v[3]);
}

}  // namespace prismatic
