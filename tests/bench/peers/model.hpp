#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mechanics/dynamics/things.hpp"

// What is simulated, told once for all engines. Conventions and units are the tutorial's.
namespace peers {

using Eigen::Vector2d;

/// A rigid body at rest at x [m], theta [rad]; inertia about its centre of mass [kg·m²].
struct Part {
  double mass, inertia;
  Vector2d x;
  double theta;
};

/// Point u1 [m] of a part stays on point u2 of the part before it, or of the world.
struct Pin {
  Vector2d u1, u2;
};

/// Parts in a row, each pinned to the one before, the first to the world: pin i is part i's.
struct Model {
  std::vector<Part> parts = {};
  std::vector<Pin> pins = {};
  bool rail = false;    ///< the last part slides along y = 0 without turning
  double torque = 0;    ///< on the first part, from outside [N·m]
  double gravity = 0;   ///< along +y [m/s²]
  double duration = 0;  ///< [s]

  int size() const { return static_cast<int>(parts.size()); }
};

Model slider_crank();
Model chain(int links);

/// The parts as an engine left them, in the world's axes: x [m], theta [rad], v [m/s], omega
/// [rad/s]. A Body, since the joints' rows read one.
using State = std::vector<dynamics::Body>;

State start(const Model& model);

/// The largest distance between the two points of a pin, or of the slider from its rail [m].
double joint_gap(const Model& model, const State& state);
double kinetic_energy(const Model& model, const State& state);  ///< [J]
/// Kinetic and potential energy, less the work of the torque: constant in an exact motion [J].
double energy_balance(const Model& model, const State& state);

/// How far the end of a run is from the exact answer: the wheel's angle [rad] or the chain's free
/// end [m]. Nothing for a chain of more than 10 links, which has no exact answer.
std::optional<double> error(const Model& model, const State& state);

}  // namespace peers
