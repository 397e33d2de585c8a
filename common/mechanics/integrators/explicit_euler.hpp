#pragma once

namespace integrators {

/// Explicit Euler, order 1: position and velocity both move on by the old rates.
/// It feeds energy into every oscillation; it is here to be seen failing.
///
/// `Vector` is the type of q and of v: double, or a fixed-size or dynamic Eigen vector.
/// The constructor takes one vector of the right size; a step allocates nothing.
template <class Vector>
class ExplicitEuler {
 public:
  explicit ExplicitEuler(const Vector& like) : a_(like) {}

  /// Moves q and v from t to t + h; `acceleration(t, q, v, a)` writes q̈ into a.
  template <class Acceleration>
  void step(Acceleration&& acceleration, double t, Vector& q, Vector& v, double h) {
    acceleration(t, q, v, a_);
    q += h * v;
    v += h * a_;
  }

 private:
  Vector a_;
};

}  // namespace integrators
