// What a matrix forgets when it is squared. Rod = crank, δ beside the pose in which J loses rank:
// the same J, the same right side b, and three ways to the acceleration. Those of the slider are
// known: s = 2 R cos θ, and θ̈ from the one equation of the machine.
#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "mechanism.hpp"

int main() {
  using Eigen::MatrixXd, Eigen::VectorXd;
  std::printf("%10s %18s %18s %18s   errors of the acceleration, m/s^2 or rad/s^2\n", "delta",
              "normal equations", "orthogonal", "this solver");
  for (int digits = 1; digits <= 8; ++digits) {
    const double delta = std::pow(10, -digits), R = 0.3, omega = 5;
    const slider_crank::Scene scene{
        .crank = R, .rod = R, .theta0 = std::numbers::pi / 2 + delta, .omega0 = omega};
    const mechanics::Mechanism mechanism = slider_crank::make_mechanism(scene, {});
    const dynamics::System& system = mechanism.system;
    const VectorXd q = mechanism.initial_position(), v = mechanism.initial_velocity();
    dynamics::Evaluation e(system);
    system.evaluate(0, q, v, e);
    const MatrixXd J = e.jacobian();
    const VectorXd W = system.W(), F = system.forces(0, q, v);

    // The rod's centre is at (3, 1) R/2 (cos θ, sin θ), and the rod at −θ.
    const double c = std::cos(scene.theta0), s = std::sin(scene.theta0), m = scene.rod_mass;
    const double M = scene.wheel_inertia() + scene.rod_inertia() +
                     R * R / 4 * m * (9 * s * s + c * c) + 4 * R * R * scene.slider_mass * s * s;
    const double half_M_prime = R * R * s * c * (2 * m + 4 * scene.slider_mass);
    const double Q = scene.torque + m * scene.gravity * R / 2 * c;
    const double alpha = (Q - half_M_prime * omega * omega) / M;
    const double x = -R * (s * alpha + c * omega * omega), y = R * (c * alpha - s * omega * omega);
    const VectorXd a = Eigen::Vector<double, 9>{0, 0, alpha, 1.5 * x, 0.5 * y, -alpha, 2 * x, 0, 0};

    const VectorXd b = J * (a - W.cwiseProduct(F));
    const MatrixXd root = W.cwiseSqrt().asDiagonal() * J.transpose();  // W^½ Jᵀ = Q R
    const Eigen::HouseholderQR<MatrixXd> QR(root);
    const MatrixXd Q_thin = QR.householderQ() * MatrixXd::Identity(9, 8);
    const auto R_T = QR.matrixQR().topRows(8).triangularView<Eigen::Upper>().transpose();
    const VectorXd squared = J.transpose() * (root.transpose() * root).ldlt().solve(b);
    const VectorXd orthogonal = W.cwiseSqrt().cwiseProduct(Q_thin * R_T.solve(b));
    const auto off = [&](const VectorXd& other) { return (other - a).cwiseAbs().maxCoeff(); };
    std::printf("%10.0e %18.1e %18.1e %18.1e\n", delta, off(W.cwiseProduct(F + squared)),
                off(W.cwiseProduct(F) + orthogonal), off(e.a()));
  }
}
