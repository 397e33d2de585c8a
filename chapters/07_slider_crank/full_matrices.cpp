// [full_matrices]
// The slider-crank of chapter 7 the article's way: full matrices, and Eigen alone. The frame is
// left out; q = (x, y, θ) of wheel, rod and slider. Each evaluation solves
//
//   [J M⁻¹ Jᵀ] λ = −J̇v − J M⁻¹ F,      a = M⁻¹ (F + Jᵀλ).
#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <numbers>

using Eigen::Vector2d;
using Vector = Eigen::Vector<double, 9>;
constexpr double R = 0.3, L = 1.0, g = 9.81, torque = 2.0;  // crank, rod [m], [m/s²], [N·m]

Vector2d along(double angle) { return {std::cos(angle), std::sin(angle)}; }

Vector acceleration(const Vector& q, const Vector& v) {
  const Vector M{2.0, 2.0, 0.16, 1.0, 1.0, L * L / 12, 1.5, 1.5, 0.01625};
  const Vector F{0, M[1] * g, torque, 0, M[4] * g, 0, 0, M[7] * g, 0};
  const Vector2d crank = R * along(q[2]), half = L / 2 * along(q[5]);

  Eigen::Matrix<double, 8, 9> J = Eigen::Matrix<double, 8, 9>::Zero();
  Eigen::Vector<double, 8> Jdot_v = Eigen::Vector<double, 8>::Zero();
  J.block<2, 2>(0, 0).setIdentity();  // x_wheel = 0
  J.block<2, 2>(2, 3).setIdentity();  // x_rod − half − (x_wheel + crank) = 0
  J.block<2, 3>(2, 0) << -1, 0, R * std::sin(q[2]), 0, -1, -R * std::cos(q[2]);
  J.block<2, 1>(2, 5) << half.y(), -half.x();
  Jdot_v.segment<2>(2) = half * v[5] * v[5] + crank * v[2] * v[2];
  J.block<2, 2>(4, 6).setIdentity();  // x_slider − (x_rod + half) = 0
  J.block<2, 3>(4, 3) << -1, 0, half.y(), 0, -1, -half.x();
  Jdot_v.segment<2>(4) = half * v[5] * v[5];
  J(6, 7) = J(7, 8) = 1;  // y_slider = 0, θ_slider = 0

  const Eigen::DiagonalMatrix<double, 9> W(M.cwiseInverse());
  const Eigen::Vector<double, 8> lambda =
      (J * W * J.transpose()).ldlt().solve(-Jdot_v - J * (W * F));
  return W * (F + J.transpose() * lambda);
}

int main() {
  const double theta = std::numbers::pi / 4, phi = -std::asin(R * std::sin(theta) / L), h = 0.001;
  const Vector2d pin = R * along(theta), half = L / 2 * along(phi);
  Vector q{0, 0, theta, pin.x() + half.x(), pin.y() + half.y(), phi, pin.x() + 2 * half.x(), 0, 0};
  Vector v = Vector::Zero();
  for (int step = 0; step < 2000; ++step) {  // the classical Runge–Kutta method
    const Vector v1 = v, a1 = acceleration(q, v1);
    const Vector v2 = v + h / 2 * a1, a2 = acceleration(q + h / 2 * v1, v2);
    const Vector v3 = v + h / 2 * a2, a3 = acceleration(q + h / 2 * v2, v3);
    const Vector v4 = v + h * a3, a4 = acceleration(q + h * v3, v4);
    q += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  std::printf("after 2 s the wheel stands at %.12f rad and turns at %.12f rad/s\n", q[2], v[2]);
}
// [full_matrices]
