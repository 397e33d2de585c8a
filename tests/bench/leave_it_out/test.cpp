#include <cmath>
#include <random>

#include "07_slider_crank/one_coordinate.hpp"
#include "catch.hpp"
#include "leave_it_out/by_hand.hpp"
#include "leave_it_out/dense_form.hpp"
#include "leave_it_out/rungs.hpp"
#include "peers/mechanism.hpp"

using namespace leave_it_out;
using Vector = Eigen::VectorXd;

TEST_CASE("every rung has the same equation: the solver's, to rounding") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const peers::Model& model : {peers::slider_crank(), peers::chain(1), peers::chain(10)}) {
    mechanics::Mechanism mechanism = peers::make_mechanism(model);
    Vector q = mechanism.initial_position(), v = mechanism.initial_velocity();
    const Eigen::Index n = q.size();
    for (Eigen::Index i = 0; i < n; ++i) v[i] = uniform(random);
    mechanism.project(0.0, q, v);
    Vector a = v;
    mechanism.acceleration(0.0, q, v, a);
    for (const bool ground : {true, false})
      for (const bool Jdot : {true, false})
        for (const bool new_memory : {true, false}) {
          INFO(model.size() << " parts, " << ground << Jdot << new_memory);
          DenseForm form(model, {ground, new_memory, Jdot, new_memory});
          const Eigen::Index frame = 3 * form.frame();
          CHECK(frame == (model.rail && ground ? 3 : 0));
          CHECK((form.initial_q().tail(n) - mechanism.initial_position()).norm() < 1e-14);
          CHECK((form.W().tail(n) - mechanism.system.W()).norm() <
                1e-12 * mechanism.system.W().norm());
          Vector all_q = Vector::Zero(n + frame), all_v = all_q, all_a = all_q;
          all_q.tail(n) = q;
          all_v.tail(n) = v;
          form.acceleration(all_q, all_v, all_a);
          CHECK((all_a.tail(n) - a).norm() < 1e-11 * a.norm());
          CHECK(all_a.head(frame).norm() < 1e-11 * a.norm());
        }
  }
}

TEST_CASE("what is written by hand for this machine has the acceleration of its joints") {
  const slider_crank::Scene scene;
  const EightRows rows(scene);
  const slider_crank::OneCoordinate one(scene);
  for (const double theta : {0.3, 1.0, 2.5, -0.7, 4.0})
    for (const double omega : {-3.0, 0.0, 7.0}) {
      mechanics::Mechanism mechanism =
          ::slider_crank::make_mechanism({.theta0 = theta, .omega0 = omega}, {});
      const Vector q = mechanism.initial_position(), v = mechanism.initial_velocity();
      Vector a = v, by_rows = v;
      mechanism.acceleration(0.0, q, v, a);
      rows.acceleration(q, v, by_rows);
      double by_one = 0;
      one.acceleration(0.0, q[2], v[2], by_one);
      INFO("theta " << theta << " omega " << omega);
      CHECK((by_rows - a).norm() < 1e-12 * a.norm());
      CHECK(std::abs(by_one - a[2]) < 1e-12 * a.norm());
    }
}

TEST_CASE("the matrix Jdot times v is what the joints return, in any state") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  for (const peers::Model& model : {peers::slider_crank(), peers::chain(4)}) {
    DenseForm matrix(model, {true, false, true, false}), vector(model, {true, false, false, false});
    Vector q = matrix.initial_q(), v = q, a = q;
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = uniform(random), v[i] = uniform(random);
    matrix.acceleration(q, v, a);
    vector.acceleration(q, v, a);
    CHECK((matrix.J() - vector.J()).norm() == 0);
    CHECK((matrix.Jdot() * v - vector.Jdot_v()).norm() < 1e-13 * vector.Jdot_v().norm());
    CHECK(matrix.Jdot().norm() > 0.1);

    // and it is the rate of J
    const double h = 1e-6;
    DenseForm before(model, {true, false, false, false}), after(model, {true, false, false, false});
    before.acceleration(q - h * v, v, a);
    after.acceleration(q + h * v, v, a);
    CHECK(((after.J() - before.J()) / (2 * h) - matrix.Jdot()).norm() < 1e-8);
  }
}

TEST_CASE("what is left out is left out, and nothing is allocated where it says so") {
  const std::vector<Rung> rungs = slider_crank_ladder();
  const std::vector<Cost> costs = measure_costs(rungs);
  REQUIRE(rungs.size() == 9);
  CHECK(rungs[0].coordinates == 12);  // frame, wheel, rod, slider
  CHECK(rungs[0].rows == 11);         // 3 of the ground, 2 of each of 4 joints
  CHECK(rungs[8].coordinates == 1);
  CHECK(rungs[8].rows == 0);
  for (std::size_t i = 1; i < 8; ++i) {
    CHECK(rungs[i].coordinates == 9);
    CHECK(rungs[i].rows == 8);
  }
  for (std::size_t i = 4; i < rungs.size(); ++i) CHECK(costs[i].allocations == 0);
#if !defined(__SANITIZE_ADDRESS__) && defined(NDEBUG)
  CHECK(costs[0].allocations > 20);
  CHECK(costs[5].seconds < 0.15 * costs[0].seconds);  // half of it was measured
  CHECK(costs[6].seconds < 4 * costs[5].seconds);     // 1.4 on an idle machine
#endif
}
