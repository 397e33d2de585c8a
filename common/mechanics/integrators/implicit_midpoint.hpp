#pragma once

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <type_traits>

#include "mechanics/integrators/no_step.hpp"

namespace integrators {

/// The implicit midpoint rule, order 2: the rates are those of the point halfway, which the step
/// itself has to find. Stable for an oscillation at every step length: the method for stiff forces.
/// Symplectic, so that energy errors stay bounded over long times, where no constraint turns the
/// equations into others.
///
/// With x the velocity halfway, the equation of the step is
///
///     R(x) = x − v − h/2 a(t + h/2, q + h/2 x, x) = 0,     then  q += h x,   v ← 2x − v.
///
/// Newton's method solves it to rounding, that of stiff forces if there are any, with R' ≈ I while
/// that is good enough, which it is for small h. Once corrections shrink too slowly R' is found by
/// finite differences, and kept from step to step for as long as it serves.
///
/// `Vector` is the type of q and of v: double, or a fixed-size or dynamic Eigen vector.
/// The constructor takes one vector of the right size, and what of an acceleration is noise; a step
/// allocates nothing.
template <class Vector>
class ImplicitMidpoint {
 public:
  explicit ImplicitMidpoint(const Vector& like, double rounding = 0.0)
      : x_(like),
        q_(like),
        a_(like),
        s_(like),
        r_(like),
        R_prime_(Matrix::Zero(column(x_).size(), column(x_).size())),
        lu_(room(column(x_).size())),
        rounding_(rounding) {
    restart();
  }

  /// Forgets what the next step would begin with: the last acceleration and R'.
  void restart() {
    column(a_).setZero();
    stiff_ = false;
  }

  /// Moves q and v from t to t + h; `acceleration(t, q, v, a)` writes q̈ into a. Throws NoStep when
  /// the equation of the step cannot be solved.
  template <class Acceleration>
  void step(Acceleration&& acceleration, double t, Vector& q, Vector& v, double h) {
    const auto minus_R = [&](Vector& r) {
      q_ = q + 0.5 * h * x_;
      acceleration(t + 0.5 * h, q_, x_, a_);
      r = v + 0.5 * h * a_ - x_;
    };
    x_ = v;
    if (!stiff_) x_ += 0.5 * h * a_;
    double before = std::numeric_limits<double>::infinity();
    for (int renewals = 0;;) {
      minus_R(s_);
      r_ = s_;
      if (stiff_) column(s_) = lu_.solve(column(r_));
      const double correction = column(s_).norm();
      x_ += s_;
      if (!std::isfinite(correction)) break;  // the caller looks at the state
      const double size = column(x_).norm();
      if (correction <= 2.0 * epsilon * size) break;
      // Forces so stiff that their rounding outweighs that of x end here, and noise about rest.
      const bool slow = correction > 0.1 * before;
      before = correction;
      if (!slow) continue;
      const double noise = 64.0 * (epsilon * column(q).norm() / h + rounding_ * h);
      if (correction <= 1e-10 * size + noise) break;
      if (renewals++ == 20) throw NoStep("the equation of the implicit step was not solved");
      if (renewals == 1) x_ = v;  // where another R' has led must not be trusted
      find_R_prime(minus_R);
      before = std::numeric_limits<double>::infinity();
    }
    q += h * x_;
    v = 2.0 * x_ - v;
  }

 private:
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();

  static auto column(double& x) { return Eigen::Map<Eigen::Vector<double, 1>>(&x); }
  template <class Column>
  static Column& column(Column& x) {
    return x;
  }

  template <class Residual>
  void find_R_prime(Residual& minus_R) {
    minus_R(r_);
    const double delta = std::sqrt(epsilon) * (column(x_).norm() + column(r_).norm());
    for (Eigen::Index j = 0; j < R_prime_.cols(); ++j) {
      const double x_j = column(x_)[j];
      column(x_)[j] += delta;
      minus_R(s_);
      column(x_)[j] = x_j;
      R_prime_.col(j) = (column(r_) - column(s_)) / delta;
    }
    lu_.compute(R_prime_);
    stiff_ = true;
  }

  static constexpr int n() {
    if constexpr (std::is_same_v<Vector, double>)
      return 1;
    else
      return Vector::RowsAtCompileTime;
  }
  using Matrix = Eigen::Matrix<double, n(), n()>;

  using Lu = Eigen::PartialPivLU<Matrix>;

  /// Room for a factorisation, without making one of a large matrix.
  static Lu room(Eigen::Index size) {
    if constexpr (n() == Eigen::Dynamic)
      return Lu(size);
    else
      return Lu(Matrix::Identity(size, size));
  }

  Vector x_, q_, a_, s_, r_;  // s: the correction of x, r: −R(x)
  Matrix R_prime_;
  Lu lu_;
  double rounding_;
  bool stiff_ = false;
};

}  // namespace integrators
