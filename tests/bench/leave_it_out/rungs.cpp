#include "leave_it_out/rungs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "07_slider_crank/one_coordinate.hpp"
#include "allocations.hpp"
#include "instruments/measure/clock.hpp"
#include "leave_it_out/by_hand.hpp"
#include "leave_it_out/dense_form.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "peers/mechanism.hpp"

namespace leave_it_out {
namespace {

using Vector = Eigen::VectorXd;
constexpr double step = 1e-4;  // [s]

/// Whatever has an acceleration(q, v, a), from a state on, of which q and v may be one number each.
/// `after` is called with the new state.
template <class Form, class State, class After>
Rung make_rung(std::string name, std::shared_ptr<Form> form, const State& q0, const State& v0,
               int coordinates, int rows, After after) {
  struct Moving {
    State q, v;
    integrators::Rk4<State> rk4;
  };
  auto now = std::make_shared<Moving>(Moving{q0, v0, integrators::Rk4<State>(q0)});
  return {std::move(name), coordinates, rows, [=] {
            now->rk4.step([&](double, const State& q, const State& v,
                              State& a) { form->acceleration(q, v, a); },
                          0.0, now->q, now->v, step);
            after(*form, now->q, now->v);
          }};
}

/// A state in which every body turns: in a chain at rest the motion dies out along it, down to
/// numbers so small that a processor slows down on them.
std::pair<Vector, Vector> start(mechanics::Mechanism& mechanism) {
  Vector q = mechanism.initial_position(), v = mechanism.initial_velocity();
  for (Eigen::Index i = 0; 3 * i < q.size(); ++i) v[3 * i + 2] = std::sin(double(i) + 1.0);
  mechanism.project(0.0, q, v);
  return {q, v};
}

struct Blocks {
  mechanics::Mechanism mechanism;
  void acceleration(const Vector& q, const Vector& v, Vector& a) {
    mechanism.acceleration(0.0, q, v, a);
  }
};

struct Angle {
  slider_crank::OneCoordinate machine{slider_crank::Scene{}};
  void acceleration(double theta, double omega, double& a) const {
    machine.acceleration(0.0, theta, omega, a);
  }
};

enum class Projected { no, yes };

Rung blocks(std::string name, mechanics::Mechanism mechanism, Projected projected = Projected::no) {
  auto form = std::make_shared<Blocks>(Blocks{std::move(mechanism)});
  const auto [q, v] = start(form->mechanism);
  const int rows = form->mechanism.system.rows();
  return make_rung(std::move(name), form, q, v, static_cast<int>(q.size()), rows,
                   [=](Blocks& f, Vector& q_now, Vector& v_now) {
                     if (projected == Projected::yes) f.mechanism.project(0.0, q_now, v_now);
                   });
}

Rung dense(std::string name, const peers::Model& model, const Kept& kept) {
  auto form = std::make_shared<DenseForm>(model, kept);
  mechanics::Mechanism mechanism = peers::make_mechanism(model);
  const auto [q, v] = start(mechanism);  // as the blocks do
  Vector q0 = form->initial_q(), v0 = Vector::Zero(q0.size());
  q0.tail(q.size()) = q;
  v0.tail(v.size()) = v;
  return make_rung(std::move(name), form, q0, v0, static_cast<int>(q0.size()),
                   static_cast<int>(form->J().rows()), [](DenseForm&, Vector&, Vector&) {});
}

/// From where the blocks start.
std::vector<Rung> by_hand() {
  mechanics::Mechanism mechanism = peers::make_mechanism(peers::slider_crank());
  const auto [q, v] = start(mechanism);
  const auto nothing = [](auto&...) {};
  return {
      make_rung("the eight rows by hand", std::make_shared<EightRows>(slider_crank::Scene{}), q, v,
                9, 8, nothing),
      make_rung("one coordinate, by hand", std::make_shared<Angle>(), q[2], v[2], 1, 0, nothing)};
}

}  // namespace

std::vector<Rung> slider_crank_ladder() {
  const peers::Model model = peers::slider_crank();
  std::vector<Rung> ladder = {
      dense("full matrices, as the article has them", model, everything),
      dense("the ground left out", model, {false, true, true, true}),
      dense("no feedback of gain 0", model, {false, false, true, true}),
      dense("Jdot v in place of Jdot", model, {false, false, false, true}),
      dense("nothing allocated, W as its diagonal", model, least),
      blocks("only the blocks that are not zero", peers::make_mechanism(model)),
      blocks("the same with projection", peers::make_mechanism(model), Projected::yes)};
  for (Rung& rung : by_hand()) ladder.push_back(std::move(rung));
  return ladder;
}

std::vector<Cost> measure_costs(const std::vector<Rung>& rungs) {
  std::vector<Cost> costs;
  for (const Rung& rung : rungs) {
    rung.step();  // the first fixes the storage
    const long before = allocations();
    rung.step();
    costs.push_back({std::numeric_limits<double>::infinity(), allocations() - before});
  }
  for (int sample = 0; sample < 40; ++sample)
    for (std::size_t i = 0; i < rungs.size(); ++i)
      costs[i].seconds =
          std::min(costs[i].seconds, measure::seconds_of(rungs[i].step, {.samples = 1}));
  return costs;
}

}  // namespace leave_it_out
