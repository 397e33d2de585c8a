#pragma once

namespace integrators {

/// The classical Runge–Kutta method, order 4: four evaluations a step, the article's own choice.
///
/// For q̈ = a(t, q, v) the two halves of the state are advanced together. The stages are
///
///     q2 = q + h/2 v      v2 = v + h/2 a1
///     q3 = q + h/2 v2     v3 = v + h/2 a2
///     q4 = q + h   v3     v4 = v + h   a3
///
/// and the step is q += h/6 (v + 2 v2 + 2 v3 + v4), v += h/6 (a1 + 2 a2 + 2 a3 + a4).
///
/// `Vector` is the type of q and of v: double, or a fixed-size or dynamic Eigen vector.
/// The constructor takes one vector of the right size; a step allocates nothing.
template <class Vector>
class Rk4 {
 public:
  explicit Rk4(const Vector& like) : q_(like), v_(like), a_(like), v_sum_(like), a_sum_(like) {}

  // [step]
  /// Moves q and v from t to t + h; `acceleration(t, q, v, a)` writes q̈ into a.
  template <class Acceleration>
  void step(Acceleration&& acceleration, double t, Vector& q, Vector& v, double h) {
    acceleration(t, q, v, a_);
    v_sum_ = v;
    a_sum_ = a_;

    q_ = q + 0.5 * h * v;
    v_ = v + 0.5 * h * a_;
    acceleration(t + 0.5 * h, q_, v_, a_);
    v_sum_ += 2.0 * v_;
    a_sum_ += 2.0 * a_;

    q_ = q + 0.5 * h * v_;
    v_ = v + 0.5 * h * a_;
    acceleration(t + 0.5 * h, q_, v_, a_);
    v_sum_ += 2.0 * v_;
    a_sum_ += 2.0 * a_;

    q_ = q + h * v_;
    v_ = v + h * a_;
    acceleration(t + h, q_, v_, a_);
    v_sum_ += v_;
    a_sum_ += a_;

    q += h / 6.0 * v_sum_;
    v += h / 6.0 * a_sum_;
  }
  // [step]

 private:
  Vector q_, v_, a_, v_sum_, a_sum_;
};

}  // namespace integrators
