#pragma once

#include <Eigen/Core>
#include <cmath>

#include "07_slider_crank/scene.hpp"
#include "mechanics/dynamics/things.hpp"

namespace leave_it_out {

/// Equation 1 of chapter 7's machine and of no other: its eight rows and what is eliminated of them
/// on paper. The wheel's pin leaves the rows of the crank pin, B, and of the slider's, C,
///
///     [ K_BB   K_BC ] [ λ_B ]   [ b_B ]     K_BB = 1/m2 + s sᵀ/I1 + r rᵀ/I2
///     [ K_BCᵀ  K_CC ] [ λ_C ] = [ b_C ],    K_BC = −1/m2 − r dᵀ/I2,   K_CC = 1/m2 + d dᵀ/I2 +
///     X/m3,
///
/// with s, r, d the quarter turns S A u of the crank pin on the wheel and of the rod's two ends,
/// and X = [1 0; 0 0], since the rail holds the slider across.
class EightRows {
 public:
  explicit EightRows(const slider_crank::Scene& scene) : scene_(scene) {}

  /// q, v, a: x, y, θ of wheel, rod and slider.
  void acceleration(const Eigen::VectorXd& q, const Eigen::VectorXd& v, Eigen::VectorXd& a) const {
    using dynamics::S;
    using Eigen::Matrix2d;
    using Eigen::Vector2d;
    const double I1 = 1 / scene_.wheel_inertia(), I2 = 1 / scene_.rod_inertia();
    const double m2 = 1 / scene_.rod_mass, m3 = 1 / scene_.slider_mass, g = scene_.gravity;
    const double half = scene_.rod / 2;
    const Vector2d pin = scene_.crank * Vector2d(std::cos(q[2]), std::sin(q[2]));
    const Vector2d end = half * Vector2d(std::cos(q[5]), std::sin(q[5]));
    const Vector2d s = S(pin), r = -S(end), d = S(end);
    const double w1 = v[2] * v[2], w2 = v[5] * v[5], alpha = scene_.torque * I1;

    // b = −J̇v − J W F. The weight of the wheel is its pin's, that of the slider the rail's.
    const Vector2d b_B = -w2 * end - w1 * pin + alpha * s - Vector2d(0, g);
    const Vector2d b_C = -w2 * end + Vector2d(0, g);

    Matrix2d K_BB = I1 * s * s.transpose() + I2 * r * r.transpose();
    Matrix2d K_BC = -I2 * r * d.transpose(), K_CC = I2 * d * d.transpose();
    K_BB.diagonal().array() += m2;
    K_BC.diagonal().array() -= m2;
    K_CC.diagonal() += Vector2d(m2 + m3, m2);

    const auto inverse = [](const Matrix2d& K) {
      Matrix2d other;
      other << K(1, 1), -K(0, 1), -K(1, 0), K(0, 0);
      return Matrix2d(other / (K(0, 0) * K(1, 1) - K(0, 1) * K(1, 0)));
    };
    const Matrix2d K_CB_inverse = K_BC.transpose() * inverse(K_BB);
    const Vector2d C = inverse(K_CC - K_CB_inverse * K_BC) * (b_C - K_CB_inverse * b_B);  // λ_C
    const Vector2d B = inverse(K_BB) * (b_B - K_BC * C);                                  // λ_B

    a[0] = a[1] = a[7] = a[8] = 0;
    a[2] = alpha - I1 * s.dot(B);
    a.segment<2>(3) = m2 * (B - C) + Vector2d(0, g);
    a[5] = I2 * (r.dot(B) - d.dot(C));
    a[6] = m3 * C.x();
  }

 private:
  slider_crank::Scene scene_;
};

}  // namespace leave_it_out
