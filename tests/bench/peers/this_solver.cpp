#include "engine.hpp"
#include "mechanism.hpp"

namespace peers {
namespace {

class ThisSolver final : public Run {
 public:
  /// `rung` is the step, or, where the method has a tolerance, that.
  ThisSolver(const Model& model, const mechanics::Method& method, double rung)
      : motion_(make_mechanism(model, method), method),
        parts_(method.tolerance > 0 ? 1 : whole_steps(model, rung)),
        part_(model.duration / static_cast<double>(parts_)) {
    motion_.measures();  // the first evaluation fixes the storage
  }

  void run(double) override { motion_.advance(parts_, part_); }
  long steps() const override { return motion_.steps(); }

  State state() override {
    State state;
    const auto &q = motion_.q(), &v = motion_.v();
    for (Eigen::Index i = 0; i < q.size(); i += 3)
      state.push_back(
          {q.segment<2>(i), v.segment<2>(i), q[i + 2], v[i + 2], dynamics::rotation(q[i + 2])});
    return state;
  }
  std::vector<std::pair<double, double>> masses() const override {
    std::vector<std::pair<double, double>> masses;
    const auto& W = motion_.model().system.W();
    for (Eigen::Index i = 0; i < W.size(); i += 3) masses.emplace_back(1 / W[i], 1 / W[i + 2]);
    return masses;
  }

 private:
  mechanics::Motion<mechanics::Mechanism> motion_;
  long parts_;   ///< of the run, each a step unless the method chooses its steps
  double part_;  ///< [s]
};

}  // namespace

Engine this_solver() {
  using enum integrators::Scheme;
  using enum mechanics::Stabilization;
  Engine engine{ours, "", {}};
  const auto add = [&](const mechanics::Method& method, double first, bool is_default = false) {
    const bool adaptive = method.tolerance > 0;
    engine.settings.push_back({.name = method.label(),
                               .rung = adaptive ? Rung::accuracy : Rung::step,
                               .first = first,
                               .is_default = is_default,
                               .in_chain = true,
                               .start = [=](const Model& model, double rung) {
                                 mechanics::Method chosen = method;
                                 if (adaptive) chosen.tolerance = rung;
                                 return std::make_unique<ThisSolver>(model, chosen, rung);
                               }});
  };
  add({.integrator = rk4}, 1.0 / 60, true);
  for (const auto stabilization : {none, projection}) {
    add({.integrator = rk4, .stabilization = stabilization}, 1.0 / 15);
    add({.integrator = dop853, .stabilization = stabilization}, 0.25);
    add({.integrator = dop853,
         .stabilization = stabilization,
         .tolerance = mechanics::coarsest_tolerance},
        mechanics::coarsest_tolerance);
  }
  return engine;
}

}  // namespace peers
