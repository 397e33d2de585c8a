#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "peers/model.hpp"

namespace leave_it_out {

/// What the dense form still does of all that a scene does not need.
struct Kept {
  bool ground;      ///< a body for the frame, held by a ground joint, where the model has a rail
  bool feedback;    ///< ks C + kd J v, though both gains are 0
  bool Jdot;        ///< J̇ as a matrix, times v; else J̇v, as the joints return it
  bool new_memory;  ///< W too as a full matrix, and every product in memory asked for anew
};

/// As the article of 2010 writes it.
inline constexpr Kept everything{true, true, true, true};
/// As few as full matrices allow.
inline constexpr Kept least{false, false, false, false};

/// Equation 1 with J and J W Jᵀ as full matrices. The rows are those of the joints.
class DenseForm {
 public:
  using Vector = Eigen::VectorXd;
  using Matrix = Eigen::MatrixXd;

  DenseForm(const peers::Model& model, const Kept& kept);

  void acceleration(const Vector& q, const Vector& v, Vector& a);

  const Vector& initial_q() const { return q0_; }
  const Vector& W() const { return W_; }  ///< its diagonal
  /// Of the last acceleration(); Jdot() only where it is kept, Jdot_v() where it is not.
  const Matrix& J() const { return J_; }
  const Matrix& Jdot() const { return Jdot_; }
  const Vector& Jdot_v() const { return Jdot_v_; }
  int frame() const { return frame_; }  ///< bodies before the model's first part: 1 or 0

 private:
  void load(const Vector& q, const Vector& v);
  void find_rows();

  peers::Model model_;
  Kept kept_;
  int frame_;
  double ks_ = 0, kd_ = 0;
  std::vector<dynamics::Body> bodies_;
  Vector q0_, W_, F_, C_, Jdot_v_, lambda_;
  Matrix full_W_, J_, Jdot_, JW_, K_;
  Eigen::LDLT<Matrix> ldlt_;
};

}  // namespace leave_it_out
