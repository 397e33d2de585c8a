#include "dense.hpp"

#include "07_slider_crank/scene.hpp"
#include "engine.hpp"
#include "integrators/rk4.hpp"
#include "joints/ground.hpp"
#include "joints/prismatic.hpp"
#include "joints/revolute.hpp"

namespace peers {

using dynamics::World;

DenseForm::DenseForm(const Model& model) : model_(model), frame_(model.rail ? 1 : 0) {
  std::vector<Part> parts = model.parts;
  const slider_crank::Scene scene;
  if (frame_ != 0)
    parts.insert(parts.begin(), Part{scene.frame_mass, scene.frame_inertia, Vector2d::Zero(), 0.0});
  const auto n = 3 * static_cast<Eigen::Index>(parts.size());
  const Eigen::Index s = 2 * model.size() + (model.rail ? 2 + 3 : 0);
  q0_ = W_ = F_ = Vector::Zero(n);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto column = 3 * static_cast<Eigen::Index>(i);
    q0_.segment<3>(column) << parts[i].x, parts[i].theta;
    W_.segment<3>(column) << 1 / parts[i].mass, 1 / parts[i].mass, 1 / parts[i].inertia;
    F_[column + 1] = parts[i].mass * model.gravity;
  }
  F_[3 * frame_ + 2] = model.torque;
  bodies_.resize(parts.size());
  Jdot_v_ = lambda_ = Vector::Zero(s);
  J_ = JW_ = Eigen::MatrixXd::Zero(s, n);
  K_ = Eigen::MatrixXd::Zero(s, s);
  ldlt_ = Eigen::LDLT<Eigen::MatrixXd>(s);
}

void DenseForm::find_rows(const Vector& q, const Vector& v) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const auto column = 3 * static_cast<Eigen::Index>(i);
    bodies_[i] = {q.segment<2>(column), v.segment<2>(column), q[column + 2], v[column + 2],
                  dynamics::rotation(q[column + 2])};
  }
  J_.setZero();
  Eigen::Index row = 0;
  // The rows of a joint between two bodies, given by their numbers; −1 is the world.
  const auto put = [&](const auto& rows, int first, int second) {
    constexpr int r = std::decay_t<decltype(rows)>::r;
    if (first >= 0) J_.block(row, 3 * first, r, rows.J1.cols()) = rows.J1;
    if (second >= 0) J_.block(row, 3 * second, r, rows.J2.cols()) = rows.J2;
    Jdot_v_.segment<r>(row) = rows.Jdot_v;
    row += r;
  };
  const auto body = [&](int i) -> const dynamics::Body& {
    return bodies_[static_cast<std::size_t>(i)];
  };
  if (frame_ != 0) put(joints::Ground{}.rows(body(0), World{}), 0, -1);
  for (int i = 0; i < model_.size(); ++i) {
    const Pin& pin = model_.pins[static_cast<std::size_t>(i)];
    const joints::Revolute joint{pin.u1, pin.u2};
    const int first = i + frame_, second = first - 1;
    if (second < 0)
      put(joint.rows(body(first), World{}), first, -1);
    else
      put(joint.rows(body(first), body(second)), first, second);
  }
  if (model_.rail) {
    const int slider = model_.size() - 1 + frame_;
    put(joints::Prismatic{}.rows(body(0), body(slider)), 0, slider);
  }
}

void DenseForm::acceleration(const Vector& q, const Vector& v, Vector& a) {
  find_rows(q, v);
  JW_.noalias() = J_ * W_.asDiagonal();
  K_.noalias() = JW_ * J_.transpose();
  lambda_ = -Jdot_v_;
  lambda_.noalias() -= JW_ * F_;
  lambda_ = ldlt_.compute(K_).solve(lambda_);
  a.noalias() = J_.transpose() * lambda_;
  a = W_.cwiseProduct(a + F_);
}

namespace {

class DenseRun final : public Run {
 public:
  DenseRun(const Model& model, double step)
      : form_(model),
        rk4_(form_.initial_q()),
        q_(form_.initial_q()),
        v_(Eigen::VectorXd::Zero(q_.size())),
        steps_(whole_steps(model, step)),
        step_(model.duration / static_cast<double>(steps_)) {}

  void run(double) override {
    const auto acceleration = [this](double, const auto& q, const auto& v, auto& a) {
      form_.acceleration(q, v, a);
    };
    for (long i = 0; i < steps_; ++i) rk4_.step(acceleration, 0.0, q_, v_, step_);
  }
  long steps() const override { return steps_; }

  State state() override {
    State state;
    for (Eigen::Index i = 3 * form_.frame(); i < q_.size(); i += 3)
      state.push_back({q_.segment<2>(i), v_.segment<2>(i), q_[i + 2], v_[i + 2],
                       dynamics::rotation(q_[i + 2])});
    return state;
  }
  std::vector<std::pair<double, double>> masses() const override {
    std::vector<std::pair<double, double>> masses;
    for (Eigen::Index i = 3 * form_.frame(); i < q_.size(); i += 3)
      masses.emplace_back(1 / form_.W()[i], 1 / form_.W()[i + 2]);
    return masses;
  }

 private:
  DenseForm form_;
  integrators::Rk4<Eigen::VectorXd> rk4_;
  Eigen::VectorXd q_, v_;
  long steps_;
  double step_;
};

}  // namespace

Engine dense() {
  const auto start = [](const Model& model, double step) {
    return std::make_unique<DenseRun>(model, step);
  };
  return {dense_form,
          "Eigen LDLT",
          {{.name = "rk4", .first = 1.0 / 60, .is_default = true, .in_chain = true, .start = start},
           {.name = "rk4", .first = 1.0 / 15, .in_chain = true, .start = start}}};
}

}  // namespace peers
