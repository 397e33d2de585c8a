// On a curve: a point of a thing stays on the curve f(x, y) = 0 that is fixed in the world.
//
//   The point r is on the curve.     C      = f(r)
//   Chain rule.                      Cdot   = grad f . rdot,   rdot = Jp v
//   Collect the velocities.          J      = grad f^T Jp
//   Differentiate again, v held:     Jdot_v = rdot^T H rdot + grad f . (Jdot_v of r)
//
// H is the Hessian of f. Jp = [I, S A u] is the Jacobian of a point; for a particle Jp = I, and
// the rows are those of a single particle on a curve.
#pragma once

#include <array>
#include <cmath>

#include "mechanics/dynamics/things.hpp"

namespace joints {

using dynamics::Matrix2d;
using dynamics::Vector2d;

/// The parabola x^2 + 2 p y = 0, p in m; f in m^2. With y down and p > 0 it is a valley.
struct Parabola {
  static constexpr const char* unit = "m^2";

  double p;

  const char* fault() const {
    return std::isnormal(p * p) ? nullptr
                                : "p must not be 0, and its square neither too large nor too small";
  }
  double f(const Vector2d& r) const { return r.x() * r.x() + 2 * p * r.y(); }
  Vector2d gradient(const Vector2d& r) const { return {2 * r.x(), 2 * p}; }
  Matrix2d hessian(const Vector2d&) const { return Vector2d(2, 0).asDiagonal(); }
};

/// Keeps point u (m) of a particle or body on a curve, which supplies f, gradient, hessian and the
/// unit of f. 1 row.
template <class Curve>
struct OnCurve {
  static constexpr std::array unit{Curve::unit};

  Curve curve;
  Vector2d u = Vector2d::Zero();

  const char* fault() const {
    if constexpr (requires { curve.fault(); })
      return curve.fault();
    else
      return nullptr;
  }

  template <class Thing>
  dynamics::Rows<1, Thing, dynamics::World> rows(const Thing& thing, const dynamics::World&) const {
    using Row = Eigen::Vector<double, 1>;
    const auto p = point(thing, u);
    const Vector2d grad = curve.gradient(p.r);
    return {.C = Row(curve.f(p.r)),
            .J1 = grad.transpose() * p.J,
            .J2 = {},
            .Jdot_v = Row(p.rdot.dot(curve.hessian(p.r) * p.rdot) + grad.dot(p.Jdot_v)),
            .size = Row(grad.lpNorm<1>() * p.size)};
  }
};

}  // namespace joints
