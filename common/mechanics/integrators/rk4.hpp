#pragma once

#include <Eigen/Core>
#include <type_traits>

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
    each_entry(q, [&](const auto& at) {
      at(v_sum_) = at(v);
      at(a_sum_) = at(a_);
      at(q_) = at(q) + 0.5 * h * at(v);
      at(v_) = at(v) + 0.5 * h * at(a_);
    });
    acceleration(t + 0.5 * h, q_, v_, a_);
    each_entry(q, [&](const auto& at) {
      at(v_sum_) += 2.0 * at(v_);
      at(a_sum_) += 2.0 * at(a_);
      at(q_) = at(q) + 0.5 * h * at(v_);
      at(v_) = at(v) + 0.5 * h * at(a_);
    });
    acceleration(t + 0.5 * h, q_, v_, a_);
    each_entry(q, [&](const auto& at) {
      at(v_sum_) += 2.0 * at(v_);
      at(a_sum_) += 2.0 * at(a_);
      at(q_) = at(q) + h * at(v_);
      at(v_) = at(v) + h * at(a_);
    });
    acceleration(t + h, q_, v_, a_);
    each_entry(q, [&](const auto& at) {
      at(q) += h / 6.0 * (at(v_sum_) + at(v_));
      at(v) += h / 6.0 * (at(a_sum_) + at(a_));
    });
  }
  // [step]

 private:
  /// Calls f(at) for each entry, at(x) being that of x: what needs one pass through memory takes
  /// one.
  template <class F>
  static void each_entry(const Vector& like, F&& f) {
    if constexpr (std::is_same_v<Vector, double>)
      f([](auto& x) -> auto& { return x; });
    else
      for (Eigen::Index k = 0; k < like.size(); ++k) f([k](auto& x) -> auto& { return x[k]; });
  }

  Vector q_, v_, a_, v_sum_, a_sum_;
};

}  // namespace integrators
