#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"

namespace four_bar {

using Eigen::Vector2d;

/// Crank, coupler and rocker, pinned in a row between two pivots of the ground; the crank is
/// driven.
struct Scene {
  double ground = 1.0, crank = 0.3, coupler = 0.9, rocker = 0.6;  ///< lengths [m]
  double torque = 3.0;                                            ///< on the crank [N·m]
  double theta0 = 0.0;                                            ///< of the crank, at rest [rad]
  double gravity = 9.81;                                          ///< along +y [m/s²]

  /// Grashof's rule: the crank goes all the way round where it is the shortest bar, and no longer
  /// together with the longest than the other two. std::invalid_argument where that is not so.
  void check() const {
    const double sum = ground + crank + coupler + rocker;
    if (crank > std::min({ground, coupler, rocker}) ||
        2 * (crank + std::max({ground, coupler, rocker})) > sum)
      throw std::invalid_argument("crank " + mechanics::in_digits(crank, 6) +
                                  ": with these bars it cannot go all the way round");
  }

  /// The end of the crank.
  Vector2d A(double theta) const { return crank * Vector2d(std::cos(theta), std::sin(theta)); }
  /// The rocker's angle at a crank angle, by Freudenstein's equation.
  double rocker_angle(double theta) const {
    const double P = ground / crank - std::cos(theta), Q = -std::sin(theta);
    const double R = ground / rocker * std::cos(theta) -
                     (ground * ground + crank * crank + rocker * rocker - coupler * coupler) /
                         (2 * crank * rocker);
    return std::atan2(Q, P) - std::acos(R / std::hypot(P, Q));
  }
  /// The end of the rocker.
  Vector2d B(double theta) const {
    const double psi = rocker_angle(theta);
    return Vector2d(ground, 0) + rocker * Vector2d(std::cos(psi), std::sin(psi));
  }
};

/// The scene as a system, each bar of 1 kg/m with its x axis along it: crank, coupler and rocker
/// stand in this order in q, three coordinates each.
inline mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method) {
  scene.check();
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  const auto add_bar = [&](const char* name, double length, const Vector2d& from,
                           const Vector2d& to) {
    const Vector2d way = to - from;
    return system.add_body(name, length, length * length * length / 12, (from + to) / 2,
                           std::atan2(way.y(), way.x()));
  };
  const Vector2d pivot(scene.ground, 0), A = scene.A(scene.theta0), B = scene.B(scene.theta0);
  const auto crank = add_bar("crank", scene.crank, {0, 0}, A);
  const auto coupler = add_bar("coupler", scene.coupler, A, B);
  const auto rocker = add_bar("rocker", scene.rocker, pivot, B);

  // Half a bar, from its middle along its x axis.
  const auto half = [](double length) { return Vector2d(length / 2, 0); };
  using joints::Revolute;
  const auto crank_ground = system.add("crank_ground", Revolute{.u1 = -half(scene.crank)}, crank);
  const auto coupler_crank =
      system.add("coupler_crank", Revolute{.u1 = -half(scene.coupler), .u2 = half(scene.crank)},
                 coupler, crank);
  const auto rocker_coupler =
      system.add("rocker_coupler", Revolute{.u1 = half(scene.rocker), .u2 = half(scene.coupler)},
                 rocker, coupler);
  const auto rocker_ground =
      system.add("rocker_ground", Revolute{.u1 = -half(scene.rocker), .u2 = pivot}, rocker);
  system.apply(crank, {0, 0, scene.torque});
  system.set_gravity({0, scene.gravity});

  mechanism.report("crank_ground", crank_ground, crank);
  mechanism.report("coupler_crank", coupler_crank, coupler);
  mechanism.report("rocker_coupler", rocker_coupler, rocker);
  mechanism.report("rocker_ground", rocker_ground, rocker);
  mechanism.assemble();
  const double theta0 = mechanism.initial_position()[crank.column + 2];
  mechanism.work = [=, torque = scene.torque](const Eigen::VectorXd& q) {
    return torque * (q[crank.column + 2] - theta0);
  };
  return mechanism;
}

}  // namespace four_bar
