#include "leave_it_out/dense_form.hpp"

#include "07_slider_crank/mechanism.hpp"
#include "mechanics/joints/ground.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"

namespace leave_it_out {
namespace {

using dynamics::Body;
using dynamics::S;
using dynamics::Vector2d;
using dynamics::World;
using Block = Eigen::Matrix<double, 2, 3>;

/// J̇ of the point u of a body: J = [I, S A u] and Ȧ = ω S A.
Block point_Jdot(const Body& body, const Vector2d& u) {
  Block Jdot = Block::Zero();
  Jdot.col(2) = -body.omega * (body.A * u);
  return Jdot;
}

/// J̇ of a rail through the first thing's origin, along its x axis, and the second's origin on it:
/// J = [−nᵀ, (S n)·d | nᵀ, 0] in its first row, n the rail's normal, ṅ = ω₁ S n, and d = x₂ − x₁.
Block rail_Jdot_first(const Body& rail, const Body& slider) {
  const Vector2d n = rail.A.col(1), Sn = S(n);
  Block Jdot = Block::Zero();
  Jdot.row(0) << -rail.omega * Sn.transpose(),
      -rail.omega * n.dot(slider.x - rail.x) + Sn.dot(slider.v - rail.v);
  return Jdot;
}
Block rail_Jdot_second(const Body& rail) {
  Block Jdot = Block::Zero();
  Jdot.row(0).head<2>() = rail.omega * S(rail.A.col(1)).transpose();
  return Jdot;
}

}  // namespace

DenseForm::DenseForm(const peers::Model& model, const Kept& kept)
    : model_(model), kept_(kept), frame_(model.rail && kept.ground ? 1 : 0) {
  std::vector<peers::Part> parts = model.parts;
  const slider_crank::Scene scene;
  if (frame_ != 0)
    parts.insert(parts.begin(), {scene.frame_mass, scene.frame_inertia, Vector2d::Zero(), 0.0});
  const auto n = 3 * static_cast<Eigen::Index>(parts.size());
  const Eigen::Index s = 2 * model.size() + (model.rail ? 2 : 0) + 3 * frame_;
  q0_ = W_ = F_ = Vector::Zero(n);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto column = 3 * static_cast<Eigen::Index>(i);
    q0_.segment<3>(column) << parts[i].x, parts[i].theta;
    W_.segment<3>(column) << 1 / parts[i].mass, 1 / parts[i].mass, 1 / parts[i].inertia;
    F_[column + 1] = parts[i].mass * model.gravity;
  }
  F_[3 * frame_ + 2] = model.torque;
  bodies_.resize(parts.size());
  J_ = JW_ = Matrix::Zero(s, n);
  K_ = Matrix::Zero(s, s);
  C_ = Jdot_v_ = lambda_ = Vector::Zero(s);
  if (kept.Jdot) Jdot_ = J_;
  if (kept.new_memory) full_W_ = W_.asDiagonal();
}

void DenseForm::load(const Vector& q, const Vector& v) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const auto column = 3 * static_cast<Eigen::Index>(i);
    bodies_[i] = {q.segment<2>(column), v.segment<2>(column), q[column + 2], v[column + 2],
                  dynamics::rotation(q[column + 2])};
  }
}

void DenseForm::find_rows() {
  J_.setZero();
  if (kept_.Jdot) Jdot_.setZero();
  Eigen::Index row = 0;
  const auto body = [&](int i) -> const Body& { return bodies_[static_cast<std::size_t>(i)]; };
  // The rows of a joint between two bodies, given by their numbers; −1 is the world.
  const auto put = [&](const auto& rows, int first, int second) {
    constexpr int r = std::decay_t<decltype(rows)>::r;
    if (first >= 0) J_.block(row, 3 * first, r, rows.J1.cols()) = rows.J1;
    if (second >= 0) J_.block(row, 3 * second, r, rows.J2.cols()) = rows.J2;
    if (kept_.feedback) C_.segment<r>(row) = rows.C;
    if (!kept_.Jdot) Jdot_v_.segment<r>(row) = rows.Jdot_v;
    row += r;
  };
  if (frame_ != 0) put(joints::Ground{}.rows(body(0), World{}), 0, -1);  // its J is constant
  for (int i = 0; i < model_.size(); ++i) {
    const peers::Pin& pin = model_.pins[static_cast<std::size_t>(i)];
    const joints::Revolute joint{pin.u1, pin.u2};
    const int first = i + frame_, second = first - 1;
    if (kept_.Jdot) {
      Jdot_.block<2, 3>(row, 3 * first) = point_Jdot(body(first), pin.u1);
      if (second >= 0) Jdot_.block<2, 3>(row, 3 * second) = -point_Jdot(body(second), pin.u2);
    }
    if (second < 0)
      put(joint.rows(body(first), World{}), first, -1);
    else
      put(joint.rows(body(first), body(second)), first, second);
  }
  if (!model_.rail) return;
  const int slider = model_.size() - 1 + frame_;
  if (frame_ == 0) return put(joints::Prismatic{}.rows(World{}, body(slider)), -1, slider);
  if (kept_.Jdot) {
    Jdot_.block<2, 3>(row, 0) = rail_Jdot_first(body(0), body(slider));
    Jdot_.block<2, 3>(row, 3 * slider) = rail_Jdot_second(body(0));
  }
  put(joints::Prismatic{}.rows(body(0), body(slider)), 0, slider);
}

void DenseForm::acceleration(const Vector& q, const Vector& v, Vector& a) {
  load(q, v);
  find_rows();
  if (kept_.new_memory) {  // as one would write it down
    Vector b = -J_ * full_W_ * F_;
    b -= kept_.Jdot ? Vector(Jdot_ * v) : Jdot_v_;
    if (kept_.feedback) b -= ks_ * C_ + kd_ * (J_ * v);
    const Matrix K = J_ * full_W_ * J_.transpose();
    const Vector lambda = K.ldlt().solve(b);
    a = full_W_ * (F_ + J_.transpose() * lambda);
  } else {
    JW_.noalias() = J_ * W_.asDiagonal();
    K_.noalias() = JW_ * J_.transpose();
    if (kept_.Jdot) Jdot_v_.noalias() = Jdot_ * v;
    lambda_ = -Jdot_v_;
    lambda_.noalias() -= JW_ * F_;
    if (kept_.feedback) {
      lambda_ -= ks_ * C_;
      lambda_.noalias() -= kd_ * (J_ * v);
    }
    lambda_ = ldlt_.compute(K_).solve(lambda_);
    a.noalias() = J_.transpose() * lambda_;
    a = W_.cwiseProduct(a + F_);
  }
}

}  // namespace leave_it_out
