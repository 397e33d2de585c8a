// Applied forces: constant ones, laws of one thing, and what two things do to each other.
#pragma once

#include <functional>

#include "mechanics/dynamics/joint.hpp"

namespace dynamics {

/// An applied force: (fx, fy) in N at the centre of mass and, on a body, the moment in N m.
template <class Thing>
using Force = Eigen::Vector<double, Thing::dof>;
template <class Thing>
using ForceLaw = std::function<Force<Thing>(double t, const Thing&)>;
/// The potential energy (J) that belongs to a force law.
template <class Thing>
using Potential = std::function<double(const Thing&)>;

/// What the second of two things does to the first. The second gets the opposite at the same place,
/// so that no law can break the conservation of momentum and angular momentum. (But a particle does
/// not turn: what has a moment about its place is lost on it.)
struct Push {
  Vector2d force;     ///< N
  Vector2d at;        ///< where it acts: a place of the world (m)
  double moment = 0;  ///< of a couple besides (N m)
};
template <class First, class Second>
using MutualLaw = std::function<Push(double t, const First&, const Second&)>;
template <class First, class Second>
using MutualPotential = std::function<double(const First&, const Second&)>;

/// Of something that was applied, to take it back.
struct ForceHandle {
  int number = -1, system = 0;
};

/// A constant force on the thing at a column.
struct Load {
  int column;
  VectorXd F;
  int number;
};

/// A force law on one thing.
template <class Thing>
struct Law {
  Handle<Thing> thing;
  ForceLaw<Thing> F;
  Potential<Thing> V;
  int number;
};

/// A law of two things whose types are forgotten: adds what both get to F, an entry a coordinate.
struct AnyMutualLaw {
  std::function<void(double t, const Things&, VectorXd& F)> add;
  std::function<double(const Things&)> V;
  int number;
};

/// F += sign J^T push, with J that of the point of the thing that is at push.at.
template <class Thing>
void add_push(double sign, const Push& push, const Thing& thing, int column, VectorXd& F) {
  if constexpr (Thing::dof > 0) F.segment<2>(column) += sign * push.force;
  if constexpr (Thing::dof > 2)
    F[column + 2] += sign * (S(push.at - thing.x).dot(push.force) + push.moment);
}

}  // namespace dynamics
