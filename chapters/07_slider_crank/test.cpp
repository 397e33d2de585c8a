#include <Eigen/Dense>
#include <array>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <sstream>

#include "allocations.hpp"
#include "catch.hpp"
#include "exact.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/pictures/stage.hpp"
#include "main_check.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanism.hpp"
#include "one_coordinate.hpp"
#include "orders.hpp"
#include "picture_check.hpp"
#include "stability_check.hpp"
#include "study.hpp"

using mechanics::Method;
using mechanics::Stabilization;
using slider_crank::Bodies;
using slider_crank::Exact;
using slider_crank::make_mechanism;
using slider_crank::Reduced;
using slider_crank::Scene;

namespace {

using Motion = mechanics::Motion<mechanics::Mechanism>;

Motion motion(const Scene& scene, const Method& method = {}) {
  return {make_mechanism(scene, method), method};
}

std::size_t column(const std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  REQUIRE(found != names.end());
  return static_cast<std::size_t>(found - names.begin());
}

double value(Motion& motion, const std::string& name) {
  const mechanics::Columns columns = motion.columns();
  const mechanics::Row row = motion.row();
  if (std::count(columns.state.begin(), columns.state.end(), name))
    return row.state[column(columns.state, name)];
  return row.reactions[column(columns.reactions, name)];
}

const Scene scenes[] = {
    {},
    {.torque = 0.0},
    {.crank = 0.2, .rod = 0.45, .torque = -3.0, .theta0 = 2.0},
    {.torque = 0.5, .theta0 = -1.0, .omega0 = -20.0, .wheel_mass = 0.3, .rod_mass = 2.0},
    {.crank = 0.3, .rod = 0.31, .theta0 = 0.3, .omega0 = 12.0}};

/// The state at time t by the reduced equation of motion: a second derivation of the exact one.
Exact::State by_integration(const Scene& scene, double t) {
  using Real = slider_crank::Real;
  using Pair = std::array<Real, 2>;
  const Reduced reduced(scene);
  boost::numeric::odeint::bulirsch_stoer<Pair, Real> stepper(1e-17L, 1e-17L);
  Pair state{scene.theta0, scene.omega0};
  const auto equation = [&](const Pair& now, Pair& rate, Real) {
    rate = {now[1], reduced.angular_acceleration(reduced.pose(now[0]), now[1])};
  };
  boost::numeric::odeint::integrate_adaptive(stepper, equation, state, Real(0), Real(t),
                                             Real(1e-3));
  return {state[0], state[1]};
}

}  // namespace

TEST_CASE("the reduced mechanism: derivatives of its places against finite differences") {
  for (const Scene& scene : scenes) {
    const Reduced reduced(scene);
    const long double h = 1e-4L;
    for (const long double theta : {-2.0L, 0.3L, 1.2L, 4.0L}) {
      const auto at = reduced.pose(theta), plus = reduced.pose(theta + h),
                 minus = reduced.pose(theta - h);
      const auto check = [&](auto member) {
        const auto &f = at.*member, &p = plus.*member, &m = minus.*member;
        CHECK(static_cast<double>(f.first) ==
              Approx(static_cast<double>((p.value - m.value) / (2 * h))).margin(1e-6));
        CHECK(static_cast<double>(f.second) ==
              Approx(static_cast<double>((p.first - m.first) / (2 * h))).margin(1e-5));
      };
      check(&Reduced::Pose::xs);
      check(&Reduced::Pose::x);
      check(&Reduced::Pose::y);
      check(&Reduced::Pose::phi);
    }
  }
}

TEST_CASE("the exact motion is that of the reduced equation of motion") {
  const Scene more[] = {
      {.torque = 1.0, .theta0 = 0.5},                                    // to and fro
      {.torque = -1.0, .theta0 = 0.5, .omega0 = 3.0},                    // turns back, to and fro
      {.torque = -4.0, .theta0 = 0.5, .omega0 = 9.0},                    // turns back, runs away
      {.torque = 4.0, .theta0 = 0.5, .omega0 = -25.0},                   // the same, after more
      {.torque = 4.0, .theta0 = 0.5, .omega0 = 1e-3},                    // all but from rest
      {.torque = 0.0, .theta0 = 0.5, .omega0 = 12.0},                    // round and round
      {.torque = 0.0, .theta0 = 0.5, .omega0 = -7.5},                    // and the other way
      {.torque = 0.0, .omega0 = 5.0, .gravity = 0.0},                    // without a force
      {.torque = 0.0, .theta0 = std::numbers::pi / 2, .omega0 = 1e-9},   // all but at rest
      {.crank = 0.3, .rod = 0.3, .torque = 0.5, .theta0 = 1.0},          // through dead centres
      {.crank = 0.3, .rod = 0.300001, .torque = 0.5, .omega0 = -12.0}};  // close by them
  const auto check = [](const Scene& scene, double slack) {
    for (const double t : {1e-6, 0.01, 0.7, 2.0, 3.1}) {
      INFO("t " << t << ", torque " << scene.torque << ", theta0 " << scene.theta0 << ", omega0 "
                << scene.omega0 << ", rod " << scene.rod);
      const auto exact = Exact(scene).at(t);
      REQUIRE(exact.has_value());
      const Exact::State integrated = by_integration(scene, t);
      const double scale = slack * (1.0 + static_cast<double>(std::abs(integrated.theta)));
      CHECK(static_cast<double>(std::abs(exact->theta - integrated.theta)) < 2e-15 * scale);
      CHECK(static_cast<double>(std::abs(exact->omega - integrated.omega)) < 5e-14 * scale);
    }
  };
  for (const Scene& scene : scenes) check(scene, 1.0);
  // Fast, or close by a dead centre, it is the integration that loses digits: of energy, too.
  for (const Scene& scene : more) check(scene, 100.0);
}

TEST_CASE("small swings have the period of the linearized equation, at rest it stays at rest") {
  // M θ̈ = −½ mr g r sin θ0 (θ − θ0) close to θ0 = π/2, where V is least; amplitude 1e-10 rad.
  const Scene scene{.torque = 0.0, .theta0 = std::numbers::pi / 2 - 1e-10};
  const Reduced reduced(scene);
  const long double stiffness = 1.0L * 9.81L * 0.3L / 2;
  const auto w =
      std::sqrt(stiffness / reduced.mu(reduced.pose(std::numbers::pi_v<long double> / 2)));
  for (const double t : {0.1, 1.0, 10.0}) {
    const auto state = Exact(scene).at(t);
    REQUIRE(state.has_value());
    const auto swing = std::numbers::pi_v<long double> / 2 - scene.theta0;
    CHECK(static_cast<double>(state->omega) ==
          Approx(static_cast<double>(swing * w * std::sin(w * t))).epsilon(1e-9));
  }
  const auto balanced =
      Exact({.torque = -1.0 * 9.81 * 0.3 * std::cos(0.7) / 2, .theta0 = 0.7}).at(1);
  REQUIRE(balanced.has_value());
  CHECK(static_cast<double>(std::abs(balanced->theta - 0.7)) < 1e-14);
}

TEST_CASE("after hours of revolutions energy is kept, and periods are") {
  const Scene free{.torque = 0.0, .theta0 = 0.5, .omega0 = 12.0};
  const Reduced reduced(free);
  const auto energy = [&](const Exact::State& state) {
    return reduced.mu(reduced.pose(state.theta)) * state.omega * state.omega / 2 -
           reduced.pull * std::sin(state.theta);
  };
  const Exact exact(free);
  const auto start = energy({free.theta0, free.omega0});
  const auto late = exact.at(1e5), later = exact.at(2e5);
  REQUIRE((late.has_value() && later.has_value()));
  CHECK(late->theta > 1e6);
  CHECK(static_cast<double>(energy(*late) / start) == Approx(1.0).epsilon(1e-11));
  // Without gravity the mean rate is the same for all times; the rest is less than one revolution.
  const Exact floating({.torque = 0.0, .theta0 = 0.5, .omega0 = 12.0, .gravity = 0.0});
  const auto one = floating.at(1e4)->theta, two = floating.at(2e4)->theta;
  CHECK(static_cast<double>(std::abs(two - 2 * one)) < 2 * std::numbers::pi);
  // Under a torque, what it has put in: ½ M ω² = τ (θ − θ0) + ½ mr g r (sin θ − sin θ0).
  const Scene pushed{.torque = 2.0};
  const auto fast = Exact(pushed).at(100.0);
  REQUIRE(fast.has_value());
  CHECK(fast->theta > 1e4);
  CHECK(static_cast<double>(energy(*fast) + reduced.pull * std::sin(pushed.theta0)) ==
        Approx(2.0 * static_cast<double>(fast->theta - pushed.theta0)).epsilon(1e-13));
}

TEST_CASE("where an exact answer would take too long there is none, and no error") {
  const Scene wild{.torque = 1e9, .omega0 = 1e9};
  CHECK_FALSE(Exact(wild).at(1e3).has_value());
  CHECK_FALSE(Exact({.torque = 0.0, .omega0 = 1e12}).at(1e3).has_value());
  Motion crank = motion(wild);
  mechanics::Row row = crank.row();
  CHECK(slider_crank::errors(wild, crank.columns(), row).size() == 3);
  row.t = 1e3;
  CHECK(slider_crank::errors(wild, crank.columns(), row).empty());
}

TEST_CASE("without torque the crank swings between θ0 and π − θ0 and comes back") {
  const Scene scene{.torque = 0.0};
  const Exact exact(scene);
  double least = 10, most = -10, speed_at_turn = 10;
  for (double t = 0; t < 4; t += 1e-2) {
    const Exact::State state = exact.at(t).value();
    least = std::min(least, static_cast<double>(state.theta));
    if (static_cast<double>(state.theta) > most) {
      most = static_cast<double>(state.theta);
      speed_at_turn = static_cast<double>(std::abs(state.omega));
    }
  }
  CHECK(least >= scene.theta0 - 1e-12);
  CHECK(most == Approx(std::numbers::pi - scene.theta0).margin(1e-3));
  CHECK(speed_at_turn < 0.05);
}

TEST_CASE("the wheel angle after 2 s is 14.08990344146206 rad") {
  // A figure from another derivation of the same scene.
  CHECK(static_cast<double>(Exact(Scene{}).at(2.0)->theta) ==
        Approx(14.08990344146206).epsilon(1e-15));
  Motion crank = motion({});
  double drift = 0;
  for (int i = 0; i < 2000; ++i) {
    crank.advance(1, 1e-3);
    drift = std::max(drift, crank.measures().constraint_error);
  }
  CHECK(std::abs(value(crank, "wheel.theta") - 14.08990344146206) < 2e-9);
  CHECK(drift < 3e-9);

  Motion projected = motion({}, {integrators::Scheme::rk4, Stabilization::projection});
  drift = 0;
  for (int i = 0; i < 2000; ++i) {
    projected.advance(1, 1e-3);
    drift = std::max(drift, projected.measures().constraint_error);
  }
  CHECK(drift < 1e-14);
  CHECK(std::abs(value(projected, "wheel.theta") - 14.08990344146206) < 2e-9);
}

TEST_CASE("the loop in main and the full matrices end where the exact motion does") {
  const Exact::State exact = Exact({}).at(2.0).value();
  const auto angle = static_cast<double>(exact.theta), rate = static_cast<double>(exact.omega);
  const std::string main = printed_by("07_slider_crank");
  CHECK(std::abs(number_after(main, "wheel stands at") - angle) < 2e-9);
  CHECK(std::abs(number_after(main, "error")) < 2e-9);
  CHECK(number_after(main, "largest |C|") < 1e-14);
  const std::string full = printed_by("07_slider_crank_full_matrices");
  CHECK(std::abs(number_after(full, "wheel stands at") - angle) < 2e-9);
  CHECK(std::abs(number_after(full, "turns at") - rate) < 1e-7);
}

TEST_CASE(
    "rows and columns equal the hand count, with the frame and without, and both move alike") {
  Scene with{.simulate_frame = true}, without;
  Motion big = motion(with), small = motion(without);
  big.advance(1000, 1e-3);
  small.advance(1000, 1e-3);
  const dynamics::Counts of_big = big.model().evaluation().counts(),
                         of_small = small.model().evaluation().counts();
  CHECK(of_big.rows == 3 + 2 + 2 + 2 + 2);
  CHECK(of_big.coordinates == 4 * 3);
  CHECK(of_big.rank == 11);
  CHECK(of_big.degrees_of_freedom == 1);
  CHECK(of_big.jacobian_blocks == 1 + 4 * 2);
  CHECK(of_small.rows == 8);
  CHECK(of_small.coordinates == 9);
  CHECK(of_small.degrees_of_freedom == 1);
  CHECK(of_small.jacobian_blocks == 1 + 2 + 2 + 1);
  REQUIRE(big.columns().state == small.columns().state);
  for (const std::string& name : big.columns().state)
    CHECK(value(big, name) == Approx(value(small, name)).margin(1e-9));
  for (const std::string& name : small.columns().reactions)
    CHECK(value(big, name) == Approx(value(small, name)).margin(1e-7));
}

TEST_CASE("at rest and in motion every joint force is that of Newton's and Euler's laws") {
  for (const Scene& scene : scenes)
    for (const bool frame : {false, true}) {
      Scene one = scene;
      one.simulate_frame = frame;
      Motion crank = motion(one, {integrators::Scheme::rk4, Stabilization::projection});
      for (int i = 0; i < 4; ++i) {
        const Exact::State state{value(crank, "wheel.theta"), value(crank, "wheel.omega")};
        const slider_crank::Reactions truth = slider_crank::reactions(one, state);
        const auto check = [&](const char* joint, const Eigen::Vector2d& force) {
          INFO(joint << ", step " << i << ", rod " << scene.rod << ", frame " << frame);
          const Eigen::Vector2d found(value(crank, std::string(joint) + ".fx"),
                                      value(crank, std::string(joint) + ".fy"));
          CHECK((found - force).norm() <= 1e-8 * (1 + force.norm()));
        };
        check("wheel_frame", truth.wheel_frame);
        check("rod_wheel", truth.rod_wheel);
        check("slider_rod", truth.slider_rod);
        check("slider_frame", truth.slider_frame);
        check("frame_ground", truth.frame_ground);
        CHECK(value(crank, "frame_ground.moment") ==
              Approx(truth.frame_ground_moment).epsilon(1e-8).margin(1e-8));
        CHECK(std::abs(value(crank, "slider_frame.moment")) < 1e-8);
        crank.advance(50, 1e-3);
      }
    }
}

TEST_CASE("the energy is what the torque has put in, and constant when it is off") {
  for (const Scene& scene : scenes) {
    Motion crank = motion(scene, {integrators::Scheme::rk4, Stabilization::projection});
    const double start = crank.measures().energy, theta0 = value(crank, "wheel.theta");
    crank.advance(4000, 2.5e-4);
    const double gained = crank.measures().energy - start;
    const double scale = 1.0 + std::abs(start) + std::abs(gained);
    CHECK(std::abs(gained - scene.torque * (value(crank, "wheel.theta") - theta0)) < 1e-7 * scale);
  }
}

TEST_CASE("wheel angle, its rate and the joint forces converge with the order of the integrator") {
  using enum integrators::Scheme;
  const Scene scene;
  const auto columns = make_mechanism(scene, {}).columns();
  const measure::Start start = [&](const Method& method) {
    return std::make_unique<Motion>(motion(scene, method));
  };
  const measure::Errors errors = [&](const mechanics::Row& row) {
    return slider_crank::errors(scene, columns, row);
  };
  CHECK(check_orders({.methods = {{explicit_euler},
                                  {semi_implicit_euler},
                                  {implicit_midpoint},
                                  {rk4},
                                  {rk4, Stabilization::projection}},
                      .duration = 0.5,
                      .coarsest = 1.0 / 128,
                      .rungs = 8},
                     start, errors, [](const measure::Rung& rung, std::size_t k) {
                       return rung.errors[k] > 2e-12 * (k == 2 ? 100 : 1) && rung.step < 1.0 / 400;
                     }) > 45);
  check_order({dop853}, 0.62, 13, start, errors);
  check_order({dop853, Stabilization::projection}, 0.6, 14, start, errors);
}

TEST_CASE("in one coordinate the machine moves and carries the same, and has the same energy") {
  const Method dop853{.integrator = integrators::Scheme::dop853};
  for (const Scene& scene : scenes) {
    mechanics::Motion one(slider_crank::OneCoordinate(scene), dop853);
    Motion all = motion(scene, dop853);
    const mechanics::Measures start = one.measures(), start_of_all = all.measures();
    for (int i = 0; i < 5; ++i) {
      one.advance(200, 1e-3);
      all.advance(200, 1e-3);
      const mechanics::Row row = one.row();
      const double turned = std::max(1.0, std::abs(row.state[1]));
      const std::vector<double> errors = slider_crank::errors(scene, one.columns(), row);
      INFO("torque " << scene.torque << ", t = " << row.t);
      REQUIRE(errors.size() == 3);
      CHECK(errors[0] < 1e-11 * turned);
      CHECK(errors[1] < 1e-10 * turned);
      CHECK(errors[2] < 1e-8 * turned * turned);
      const mechanics::Measures now = one.measures(), now_of_all = all.measures();
      CHECK(now.kinetic == Approx(now_of_all.kinetic).epsilon(1e-9));
      CHECK(now.energy - start.energy ==
            Approx(now_of_all.energy - start_of_all.energy).margin(1e-9 * now.kinetic));
      CHECK(now.balance() == Approx(start.balance()).margin(1e-10 * now.kinetic));
      CHECK(now.drive == Approx(now_of_all.drive));
    }
  }
}

TEST_CASE("rod = crank: through the dead centre on the branch of its momentum, energy kept") {
  const Scene scene{
      .crank = 0.3, .rod = 0.3, .torque = 0.0, .theta0 = 0.2, .omega0 = 9.0, .gravity = 0.0};
  Motion crank = motion(scene, {integrators::Scheme::rk4, Stabilization::projection});
  const double start = crank.measures().energy;
  crank.advance(7000, 1e-3);
  CHECK(value(crank, "wheel.theta") > 0.2 + 11 * std::numbers::pi);  // more than ten passages
  CHECK(std::abs(crank.measures().energy - start) < 1e-6 * start);
  // On this branch the slider swings through the wheel's centre: s = 2 r cos θ.
  CHECK(value(crank, "slider.x") ==
        Approx(0.6 * std::cos(value(crank, "wheel.theta"))).margin(1e-6));
}

TEST_CASE(
    "in the pose where rod and crank fold, the rank falls and the rows that depend are named") {
  // rod = crank, θ = π/2: the slider stands on the wheel's centre and could leave it two ways.
  const Scene scene{.crank = 0.3, .rod = 0.3, .theta0 = std::numbers::pi / 2};
  mechanics::Mechanism mechanism = make_mechanism(scene, {});
  Eigen::VectorXd q = mechanism.initial_position(), v = mechanism.initial_velocity(), a = q;
  mechanism.acceleration(0, q, v, a);
  CHECK(a.allFinite());
  CHECK(mechanism.evaluation().counts().rank == 7);
  CHECK(mechanism.evaluation().dependent_rows().size() == 1);
}

TEST_CASE("rod = crank, loaded: the error falls with the step and stays down") {
  const Scene passing{.crank = 0.3, .rod = 0.3, .omega0 = 5.0};
  // Set off exactly in the pose, or close beside it.
  const Scene in_it{
      .crank = 0.3, .rod = 0.3, .theta0 = std::numbers::pi / 2, .omega0 = 3.88714421007120726};
  Scene beside = in_it;
  beside.theta0 -= 1e-3;
  const auto error = [](const Scene& scene, const Method& method, double duration, double step) {
    Motion crank = motion(scene, method);
    crank.advance(std::lround(duration / step), step);
    return slider_crank::errors(scene, crank.columns(), crank.row())[0];
  };
  const Method dop853{integrators::Scheme::dop853, Stabilization::projection};
  for (const double step : {2e-3, 1e-3, 5e-4, 2.5e-4}) {
    CHECK(error(passing, dop853, 3.0, step) < 1e-10);
    CHECK(error(in_it, dop853, 0.5, step) < 1e-11);
    CHECK(error(beside, dop853, 0.5, step) < 1e-11);
  }
  const Method rk4{integrators::Scheme::rk4, Stabilization::projection};
  for (const double step : {4e-3, 2e-3, 1e-3})
    CHECK(error(passing, rk4, 3.0, step) / error(passing, rk4, 3.0, step / 2) > 12.0);
  // No worse than machines whose rods are long enough to keep the rank.
  for (const double rod : {0.35, 0.4}) {
    Scene never = passing;
    never.rod = rod;
    CHECK(error(passing, rk4, 3.0, 1e-3) < 2.0 * error(never, rk4, 3.0, 1e-3));
  }
}

TEST_CASE(
    "rod = crank, adaptive: with projection the tolerance is kept, without it that is the advice") {
  for (const double omega : {0.0, 2.0, 5.0})
    for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
      INFO("omega " << omega << ", tolerance " << tolerance);
      Motion crank =
          motion({.crank = 0.3, .rod = 0.3, .omega0 = omega},
                 {integrators::Scheme::dop853, Stabilization::projection, 0, 0, tolerance});
      crank.advance(1, 3.0);
      CHECK(slider_crank::errors({.crank = 0.3, .rod = 0.3, .omega0 = omega}, crank.columns(),
                                 crank.row())[0] < 100 * tolerance);
    }
  for (const std::string omega : {"2", "5"}) {
    const std::string said = printed_by(
        "07_slider_crank run --rod 0.3 --duration 3 --integrator dop853 "
        "--tolerance 1e-8 --omega0 " +
        omega + " 2>&1 >/dev/null");
    CHECK_THAT(said, ContainsSubstring("the tolerance of 1e-08 was not kept") &&
                         ContainsSubstring("; try --stabilization projection\n"));
  }
}

TEST_CASE(
    "normal equations lose twice the digits, an orthogonal factor as many as the pose costs") {
  std::istringstream table(printed_by("07_slider_crank_squared"));
  std::string header;
  std::getline(table, header);
  const double epsilon = std::numeric_limits<double>::epsilon();
  double delta, normal, orthogonal, solver;
  int rows = 0;
  for (; table >> delta >> normal >> orthogonal >> solver; ++rows) {
    INFO("delta " << delta);
    CHECK(orthogonal < 1e3 * epsilon / delta);
    if (delta < 1e-3) CHECK(normal > 0.1 * epsilon / (delta * delta));
    CHECK(solver < 1e-6);
  }
  CHECK(rows == 8);
}

TEST_CASE("rod = crank, in the pose: forces are the limits along the motion, or not determined") {
  // Under no load, by Newton's and Euler's laws for the rod and l'Hôpital's rule: 4.3835 N. The
  // limit from both sides is that of the exact answer.
  Scene scene{.crank = 0.3,
              .rod = 0.3,
              .torque = 0.0,
              .theta0 = std::numbers::pi / 2,
              .omega0 = 3.88714421007120726,
              .gravity = 0.0};
  Motion crank = motion(scene);
  CHECK(value(crank, "slider_rod.fy") == Approx(4.3835286).epsilon(1e-7));
  const Exact::State beside{.theta = scene.theta0 + 1e-7, .omega = scene.omega0};
  CHECK(value(crank, "rod_wheel.fy") ==
        Approx(reactions(scene, beside).rod_wheel.y()).epsilon(1e-5));

  // A torque, across which no joint pushes in this pose, is held by forces that grow as 1 / δ.
  scene.torque = 2.0;
  Motion loaded = motion(scene);
  CHECK(std::isnan(value(loaded, "slider_rod.fy")));
  CHECK(std::isfinite(value(loaded, "slider_rod.fx")));
  scene.theta0 += 1e-4;
  const double truth =
      reactions(scene, {.theta = scene.theta0, .omega = scene.omega0}).slider_rod.y();
  Motion near_by = motion(scene);
  CHECK(std::abs(truth) > 2e4);
  CHECK(value(near_by, "slider_rod.fy") == Approx(truth).epsilon(1e-4));

  Motion still = motion({.crank = 0.3, .rod = 0.3, .theta0 = std::numbers::pi / 2});
  CHECK(std::isnan(value(still, "slider_rod.fy")));
  CHECK(std::isfinite(value(still, "slider.vx")));
}

TEST_CASE("without J̇v the joints give way by exactly C̈ = J̇v") {
  // Linear independence of the two accelerations: J (a_with − a_without) = −J̇v, so J a_without = 0.
  mechanics::Mechanism off = make_mechanism({.omega0 = 8.0, .without_jdotv = true}, {}),
                       on = make_mechanism({.omega0 = 8.0}, {});
  const Eigen::VectorXd q = off.initial_position(), v = off.initial_velocity();
  Eigen::VectorXd a = q;
  off.acceleration(0, q, v, a);
  CHECK((off.evaluation().jacobian() * a).lpNorm<Eigen::Infinity>() < 1e-11);
  on.acceleration(0, q, v, a);
  CHECK((on.evaluation().jacobian() * a).lpNorm<Eigen::Infinity>() > 1.0);
}

TEST_CASE("a step allocates nothing") {
  for (const auto stabilization :
       {Stabilization::none, Stabilization::feedback, Stabilization::projection}) {
    Motion crank = motion({}, {integrators::Scheme::rk4, stabilization, 100.0, 20.0});
    crank.advance(1, 1e-3);
    const long before = allocations();
    crank.advance(100, 1e-3);
    CHECK(allocations() == before);
  }
}

TEST_CASE("solution 1: the torque that holds the crank at rest balances the rod's weight") {
  // By virtual work: τ δθ + mr g δy = 0 with y = r sin θ/2.
  const Scene scene{.torque = -1.0 * 9.81 * 0.3 * std::cos(0.7) / 2, .theta0 = 0.7};
  Motion crank = motion(scene);
  crank.advance(1000, 1e-3);
  CHECK(value(crank, "wheel.theta") == Approx(0.7).epsilon(1e-12));
}

TEST_CASE("solution 2: a second rail changes nothing but the rank") {
  Bodies bodies;
  mechanics::Mechanism twice = make_mechanism({}, {}, &bodies), once = make_mechanism({}, {});
  twice.system.add("second_rail", joints::Prismatic{.u1 = {0.0, 0.1}, .u2 = {0.0, 0.1}},
                   dynamics::System::world, bodies.slider);
  const Eigen::VectorXd q = once.initial_position(), v = once.initial_velocity();
  Eigen::VectorXd a = q, b = q;
  once.acceleration(0, q, v, a);
  twice.acceleration(0, q, v, b);
  CHECK((a - b).lpNorm<Eigen::Infinity>() < 1e-10 * a.lpNorm<Eigen::Infinity>());
  CHECK(twice.evaluation().counts().rows == 10);
  CHECK(twice.evaluation().counts().rank == 8);
  CHECK(twice.evaluation().dependent_rows().size() == 2);
}

TEST_CASE(
    "solution 3: a rod ten times as heavy loads its pins 7.5 times as much, and stops the crank") {
  Motion light = motion({}), heavy = motion({.rod_mass = 10.0});
  const auto force = [](Motion& crank, const std::string& joint) {
    return std::hypot(value(crank, joint + ".fx"), value(crank, joint + ".fy"));
  };
  const auto growth = [&](const std::string& joint) {
    return force(heavy, joint) / force(light, joint);
  };
  for (const double error : slider_crank::errors({.rod_mass = 10.0}, heavy.columns(), heavy.row()))
    CHECK(error < 1e-11);
  CHECK(growth("rod_wheel") == Approx(7.5).epsilon(0.02));
  CHECK(growth("slider_rod") == Approx(7.5).epsilon(0.02));
  CHECK(growth("slider_frame") == Approx(3.1).epsilon(0.02));
  CHECK(growth("wheel_frame") == Approx(2.8).epsilon(0.02));
  CHECK(value(heavy, "wheel_frame.fx") == Approx(value(heavy, "rod_wheel.fx")).epsilon(1e-12));
  for (int i = 0; i < 200; ++i) {
    heavy.advance(10, 1e-3);
    CHECK(value(heavy, "wheel.theta") < std::numbers::pi);
  }
}

namespace {
const measure::RunOptions defaults{.duration = 2.0, .step = 0.001};
}

TEST_CASE("the pictures of the lesson are those that the program draws") {
  picture_check::compare_all("07_slider_crank", slider_crank::pictures({}, defaults));
}

TEST_CASE("pictures can be drawn of every scene the options allow") {
  for (const Scene& scene :
       {Scene{.torque = 0.0}, Scene{.rod = 0.3}, Scene{.crank = 1e-6, .rod = 1e-5},
        Scene{.crank = 40.0, .rod = 50.0, .gravity = 0.0}}) {
    const measure::RunOptions run{.duration = 0.05, .step = 0.001};
    for (const auto& picture : slider_crank::pictures(scene, run))
      CHECK_NOTHROW(draw::render({.scale = 0.5}, picture.draw));
    CHECK_NOTHROW(draw::render({.width = 480, .height = 300},
                               pictures::picture_at(slider_crank::stage(scene, run), 0.02).draw));
  }
}

TEST_CASE(
    "the crank runs for ten minutes, and under its torque until its speed outgrows the step") {
  constexpr double step = 0.001;
  const auto runs_to = [&](const Scene& scene, double duration) {
    Motion crank = motion(scene, {integrators::Scheme::rk4, Stabilization::projection});
    const double balance = crank.measures().balance();
    double most = crank.measures().kinetic;
    while (crank.time() < duration) {
      crank.advance(10, step);
      const mechanics::Measures now = crank.measures();
      most = std::max(most, now.kinetic);
      if (!(std::abs(now.balance() - balance) < 0.01 * most)) break;
    }
    return crank.time();
  };
  CHECK(runs_to({.torque = 0.0}, 60.0) >= 60.0);
  CHECK(runs_to({.torque = 0.0, .omega0 = 20.0}, 600.0) >= 600.0);
  // RK4 is good for some tenths of a radian a step, and 2 N·m bring 7 to 8 rad/s each second.
  const double outgrown = runs_to({}, 600.0);
  CHECK(outgrown > 25.0);
  CHECK(outgrown < 60.0);
}

TEST_CASE("every stiff and extreme case ends as expected, and the map is that of theory") {
  check_stability(slider_crank::stability());
}
