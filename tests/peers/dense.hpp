#pragma once

#include <Eigen/Cholesky>

#include "model.hpp"

namespace peers {

/// Equation 1 with J and J W Jᵀ as full matrices, as the article writes it: the frame of the
/// slider-crank is a body too, held by a ground joint. W alone is kept as its diagonal, which costs
/// the dense form nothing that it has to spend.
class DenseForm {
 public:
  using Vector = Eigen::VectorXd;

  explicit DenseForm(const Model& model);

  void acceleration(const Vector& q, const Vector& v, Vector& a);

  Vector initial_q() const { return q0_; }
  const Vector& W() const { return W_; }
  const Eigen::MatrixXd& J() const { return J_; }
  int frame() const { return frame_; }  ///< bodies before the model's first part: 1 or 0

 private:
  void find_rows(const Vector& q, const Vector& v);

  Model model_;
  int frame_;
  std::vector<dynamics::Body> bodies_;
  Vector q0_, W_, F_, Jdot_v_, lambda_;
  Eigen::MatrixXd J_, JW_, K_;
  Eigen::LDLT<Eigen::MatrixXd> ldlt_;
};

}  // namespace peers
