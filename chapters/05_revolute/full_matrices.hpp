#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "mechanics/joints/revolute.hpp"
#include "scene.hpp"

namespace revolute {

/// A chain by equation 1 as it stands: J and J W Jᵀ as full matrices, with all their zeros. The
/// rows are those of the joint; nothing is allocated after the first evaluation.
class FullMatrices {
 public:
  explicit FullMatrices(const Scene& scene)
      : pin_{Vector2d(-scene.l() / 2, 0.0), Vector2d(scene.l() / 2, 0.0)},
        rods_(static_cast<std::size_t>(scene.links)) {
    const Eigen::Index N = scene.links;
    const Eigen::Vector3d W_rod(1 / scene.m(), 1 / scene.m(), 1 / scene.I());
    W_ = W_rod.replicate(N, 1);
    F_ = Eigen::Vector3d(0.0, scene.m() * scene.gravity, 0.0).replicate(N, 1);
    J_ = JW_ = Eigen::MatrixXd::Zero(2 * N, 3 * N);
    K_ = Eigen::MatrixXd::Zero(2 * N, 2 * N);
    Jdot_v_ = lambda_ = VectorXd::Zero(2 * N);
  }

  void acceleration(const VectorXd& q, const VectorXd& v, VectorXd& a) {
    for (std::size_t i = 0; i < rods_.size(); ++i) {
      const auto row = 2 * Eigen::Index(i), column = 3 * Eigen::Index(i);
      rods_[i] = {q.segment<2>(column), v.segment<2>(column), q[column + 2], v[column + 2],
                  dynamics::rotation(q[column + 2])};
      const auto put = [&](const auto& rows) {
        J_.block<2, 3>(row, column) = rows.J1;
        if (i > 0) J_.block(row, column - 3, 2, rows.J2.cols()) = rows.J2;
        Jdot_v_.segment<2>(row) = rows.Jdot_v;
      };
      if (i == 0)
        put(joints::Revolute{pin_.u1, Vector2d::Zero()}.rows(rods_[0], dynamics::World{}));
      else
        put(pin_.rows(rods_[i], rods_[i - 1]));
    }
    JW_.noalias() = J_ * W_.asDiagonal();
    K_.noalias() = JW_ * J_.transpose();
    lambda_ = -Jdot_v_;
    lambda_.noalias() -= JW_ * F_;
    lambda_ = ldlt_.compute(K_).solve(lambda_);
    a = F_;
    a.noalias() += J_.transpose() * lambda_;
    a = W_.cwiseProduct(a);
  }

 private:
  joints::Revolute pin_;
  std::vector<dynamics::Body> rods_;
  VectorXd W_, F_, Jdot_v_, lambda_;
  Eigen::MatrixXd J_, JW_, K_;
  Eigen::LDLT<Eigen::MatrixXd> ldlt_;
};

}  // namespace revolute
