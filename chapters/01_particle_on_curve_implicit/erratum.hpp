#pragma once

#include "implicit_bead.hpp"

namespace particle_on_curve {

/// The particle as the article prints it: in Fc.y it has 100·x·Fx where 50·x·Fx is right (p = 50
/// m). Kept to show what the misprint does; without a horizontal force it does nothing.
class AsPrinted : public parabola::ImplicitBead {
 public:
  explicit AsPrinted(const parabola::Scene& scene) : ImplicitBead(scene), scene_(scene) {}

  // [printed]
  Vector constraint_force(const Vector& x, const Vector& v, const Vector& F) const {
    const auto& [x0, m, g, p, Fx, without] = scene_;
    const double y = -(p * m * v.x() * v.x() + 2.0 * p * x.x() * F.x() + p * p * F.y()) /
                     (x.x() * x.x() + p * p);
    return {y * x.x() / p, y};
  }
  // [printed]

  void acceleration(double, const Vector& x, const Vector& v, Vector& a) const {
    const Vector F = scene_.applied_force();
    a = (F + constraint_force(x, v, F)) / scene_.mass;
  }

 private:
  parabola::Scene scene_;
};

}  // namespace particle_on_curve
