#pragma once

#include <cmath>

#include "mechanics/dynamics/force.hpp"

namespace forces {

using dynamics::Vector2d;

/// Spring and damper side by side between point u1 of the first thing and point u2 of the second,
/// in each one's own frame. With the way d from the first to the second, l = |d| and e = d / l,
///
///   the first gets the force (k (l - L) + c dl/dt) e,   dl/dt = e . d_dot,   V = k/2 (l - L)^2.
///
/// Both act along the line through the points. Where these meet, l = 0, there is no e: the damper
/// then acts against d_dot, the way on which the points pass through each other; a spring with
/// L > 0, whose force jumps from one side to the other there, gives none. One with L = 0 is
/// linear, k d, and has no such place.
struct SpringDamper {
  double k = 0;  ///< stiffness [N/m]
  double c = 0;  ///< damping [N s/m]
  double L = 0;  ///< length at rest [m]
  Vector2d u1 = Vector2d::Zero();
  Vector2d u2 = Vector2d::Zero();

  const char* fault() const {
    for (const double x : {k, c, L})
      if (!(x >= 0) || !std::isfinite(x))
        return "stiffness, damping and length at rest must be finite and not negative";
    return u1.allFinite() && u2.allFinite() ? nullptr : "its points must be finite";
  }

  template <class First, class Second>
  dynamics::Push push(const First& first, const Second& second) const {
    const Stretch s = stretch(first, second);
    if (s.l == 0) return {c * s.d_dot, s.at};
    return {(k * (s.l - L) + c * s.e.dot(s.d_dot)) * s.e, s.at};
  }

  /// The energy in the spring [J].
  template <class First, class Second>
  double potential(const First& first, const Second& second) const {
    const double stretched = stretch(first, second).l - L;
    return k / 2 * stretched * stretched;
  }

  /// What the damper turns into heat [W]: by this much the energy of a scene falls.
  template <class First, class Second>
  double heat(const First& first, const Second& second) const {
    const Stretch s = stretch(first, second);
    const double l_dot = s.l == 0 ? s.d_dot.norm() : s.e.dot(s.d_dot);
    return c * l_dot * l_dot;
  }

 private:
  struct Stretch {
    Vector2d at, d_dot, e;
    double l;
  };
  template <class First, class Second>
  Stretch stretch(const First& first, const Second& second) const {
    const auto p1 = point(first, u1);
    const auto p2 = point(second, u2);
    const Vector2d d = p2.r - p1.r;
    const double l = d.stableNorm();
    return {p1.r, p2.rdot - p1.rdot, d / l, l};
  }
};

}  // namespace forces
