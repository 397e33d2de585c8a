#pragma once

#include "mechanics/dynamics/system.hpp"

/// A System with an evaluation of its own, for tests that ask one thing at a time.
struct Evaluated : dynamics::System {
  using VectorXd = Eigen::VectorXd;
  dynamics::Evaluation e{*this};

  const dynamics::Evaluation& at(const VectorXd& q, const VectorXd& v, double t = 0) {
    evaluate(t, q, v, e);
    return e;
  }
  const dynamics::Evaluation& at(const VectorXd& q) { return at(q, initial_v()); }

  void acceleration(double t, const VectorXd& q, const VectorXd& v, VectorXd& a) {
    a = at(q, v, t).a();
  }
  dynamics::Projection project(VectorXd& q, VectorXd& v) { return System::project(0, q, v, e); }
  dynamics::Assembly assemble(VectorXd& q, VectorXd& v) const { return System::assemble(0, q, v); }
  double constraint_error(const VectorXd& q) { return at(q).constraint_error(); }
  double velocity_error(const VectorXd& q, const VectorXd& v) { return at(q, v).velocity_error(v); }
  double distance(const VectorXd& q) { return at(q).distance(); }
  double opening(const VectorXd& q) { return at(q).opening(); }
  Eigen::MatrixXd jacobian(const VectorXd& q) { return at(q).jacobian(); }

  // Of the last.
  VectorXd lambda(dynamics::JointHandle joint) const { return e.lambda(joint); }
  template <class Thing>
  Eigen::Vector3d reaction(dynamics::JointHandle joint, dynamics::Handle<Thing> thing) const {
    return e.reaction(joint, thing);
  }
  dynamics::Counts counts() const { return e.counts(); }
  std::vector<dynamics::JointRow> dependent_rows() const { return e.dependent_rows(); }
  dynamics::RowState worst_row() const { return e.worst_row(); }
  dynamics::RowState weakest_row() const { return e.weakest_row(); }
};
