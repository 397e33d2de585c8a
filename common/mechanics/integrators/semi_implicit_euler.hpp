#pragma once

namespace integrators {

/// Semi-implicit (symplectic) Euler, order 1: the velocity first, then the position by the *new*
/// velocity. One line in another order than explicit Euler, and an oscillation keeps its energy on
/// average as long as h ω < 2.
///
/// `Vector` is the type of q and of v: double, or a fixed-size or dynamic Eigen vector.
/// The constructor takes one vector of the right size; a step allocates nothing.
template <class Vector>
class SemiImplicitEuler {
 public:
  explicit SemiImplicitEuler(const Vector& like) : a_(like) {}

  /// Moves q and v from t to t + h; `acceleration(t, q, v, a)` writes q̈ into a.
  template <class Acceleration>
  void step(Acceleration&& acceleration, double t, Vector& q, Vector& v, double h) {
    acceleration(t, q, v, a_);
    v += h * a_;
    q += h * v;
  }

 private:
  Vector a_;
};

}  // namespace integrators
