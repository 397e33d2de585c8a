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

  /// Moves q and v from t to t + h; `acceleration(t, q, v, a)` writes q̈ into a.
  template <class Acceleration>
  void step(Acceleration&& acceleration, double t, Vector& q, Vector& v, double h) {
    acceleration(t, q, v, a_);
    each_entry(q, v, [h](auto e) {
      e.v_sum = e.v;
      e.a_sum = e.a_i;
      e.q_i = e.q + 0.5 * h * e.v;
      e.v_i = e.v + 0.5 * h * e.a_i;
    });
    acceleration(t + 0.5 * h, q_, v_, a_);
    each_entry(q, v, [h](auto e) {
      e.v_sum += 2.0 * e.v_i;
      e.a_sum += 2.0 * e.a_i;
      e.q_i = e.q + 0.5 * h * e.v_i;
      e.v_i = e.v + 0.5 * h * e.a_i;
    });
    acceleration(t + 0.5 * h, q_, v_, a_);
    each_entry(q, v, [h](auto e) {
      e.v_sum += 2.0 * e.v_i;
      e.a_sum += 2.0 * e.a_i;
      e.q_i = e.q + h * e.v_i;
      e.v_i = e.v + h * e.a_i;
    });
    acceleration(t + h, q_, v_, a_);
    each_entry(q, v, [h](auto e) {
      e.q += h / 6.0 * (e.v_sum + e.v_i);
      e.v += h / 6.0 * (e.a_sum + e.a_i);
    });
  }

 private:
  /// The same entries of the state, of a stage, and of the sums.
  template <class Entry>
  struct Entries {
    Entry q, v, q_i, v_i, a_i, v_sum, a_sum;
  };

  /// Calls f for all entries, two at a time: what needs one pass through memory takes one.
  template <class F>
  void each_entry(Vector& q, Vector& v, F&& f) {
    if constexpr (std::is_same_v<Vector, double>) {
      f(Entries<double&>{q, v, q_, v_, a_, v_sum_, a_sum_});
    } else {
      using Two = Eigen::Map<Eigen::Vector2d>;
      const auto pass = [&f](Eigen::Index n, auto*... x) {
        Eigen::Index k = 0;
        for (; k + 1 < n; k += 2) f(Entries<Two>{Two(x + k)...});
        if (k < n) f(Entries<double&>{x[k]...});
      };
      pass(q.size(), q.data(), v.data(), q_.data(), v_.data(), a_.data(), v_sum_.data(),
           a_sum_.data());
    }
  }

  Vector q_, v_, a_, v_sum_, a_sum_;
};

}  // namespace integrators
