#pragma once

#include <functional>
#include <utility>

#include "implicit_bead.hpp"

namespace parabola {

/// A force from outside [N] on a bead at x that moves with v: of the hand that holds it.
using Hand = std::function<Eigen::Vector2d(const Eigen::Vector2d& x, const Eigen::Vector2d& v)>;

/// The bead with a hand's force beside the scene's own.
class HeldBead : public ImplicitBead {
 public:
  HeldBead(const Scene& scene, double ks, double kd, Hand hand)
      : ImplicitBead(scene, ks, kd), scene_(scene), hand_(std::move(hand)) {}

  void acceleration(double, const Vector& x, const Vector& v, Vector& a) const {
    const Vector F = force(x, v);
    a = (F + constraint_force(x, v, F)) / scene_.mass;
  }
  mechanics::Measures measures(double t, const Vector& x, const Vector& v) const {
    mechanics::Measures measures = ImplicitBead::measures(t, x, v);
    measures.drive = force(x, v).norm() / std::sqrt(scene_.mass);
    return measures;
  }
  void observe(double t, const Vector& x, const Vector& v, mechanics::Row& row) const {
    ImplicitBead::observe(t, x, v, row);
    const Vector curve = constraint_force(x, v, force(x, v));
    row.reactions = {curve.x(), curve.y(), 0.0};
  }

 private:
  Vector force(const Vector& x, const Vector& v) const {
    return scene_.applied_force() + hand_(x, v);
  }

  Scene scene_;
  Hand hand_;
};

}  // namespace parabola
