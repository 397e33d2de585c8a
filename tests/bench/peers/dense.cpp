#include "engine.hpp"
#include "leave_it_out/dense_form.hpp"
#include "mechanics/integrators/rk4.hpp"

namespace peers {
namespace {

class DenseRun final : public Run {
 public:
  DenseRun(const Model& model, double step)
      : form_(model, {.ground = true, .feedback = false, .Jdot = false, .new_memory = false}),
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
  leave_it_out::DenseForm form_;
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
