#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <numbers>

#include "allocations.hpp"
#include "catch.hpp"
#include "exact.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/pictures/stage.hpp"
#include "main_check.hpp"
#include "mechanism.hpp"
#include "orders.hpp"
#include "picture_check.hpp"
#include "stability_check.hpp"
#include "study.hpp"
#include "turned_off.hpp"

using dynamics::Body;
using mechanics::Mechanism;
using mechanics::Method;
using mechanics::Stabilization;
using prismatic::across;
using prismatic::along;
using prismatic::angular_momentum;
using prismatic::make_mechanism;
using prismatic::Scene;

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

using Motion = mechanics::Motion<Mechanism>;

Motion motion(const Scene& scene, const Method& method = {}) {
  return {make_mechanism(scene, method), method};
}

// The second derivation of the spinning rail: forces instead of what is conserved. Along the rail
// nothing acts, r̈ = r θ̇²; across it the block takes m (r θ̈ + 2 ṙ θ̇), whose moment r slows the rail:
// (I0 + m r²) θ̈ = −2 m r ṙ θ̇. Integrated with order 8 in long double.
struct Polar {
  long double r, rdot, theta, omega;
};

Polar integrated(const Scene& scene, double t) {
  namespace odeint = boost::numeric::odeint;
  using State = std::array<long double, 4>;
  const long double m = scene.mass, I0 = scene.rail_inertia + scene.inertia();
  State y{scene.r0, 0.0L, 0.0L, scene.spin};
  const auto rates = [&](const State& s, State& rate, long double) {
    const auto& [r, rdot, theta, omega] = s;
    rate = {rdot, r * omega * omega, omega, -2 * m * r * rdot * omega / (I0 + m * r * r)};
  };
  using Stepper = odeint::runge_kutta_fehlberg78<State, long double, State, long double>;
  odeint::integrate_adaptive(odeint::make_controlled<Stepper>(1e-17L, 1e-17L), rates, y, 0.0L,
                             static_cast<long double>(t), 1e-4L);
  return {y[0], y[1], y[2], y[3]};
}

}  // namespace

TEST_CASE("the loop in main ends where the exact motion does") {
  const std::string text = printed_by("06_prismatic");
  const double way = prismatic::exact({.spin = 5.0}, 1.0).x.norm();
  CHECK(std::abs(number_after(text, "the block is at") - way) < 1e-9);
  CHECK(std::abs(number_after(text, "error")) < 1e-9);
  CHECK(number_after(text, "largest |C|") < 1e-14);
}

TEST_CASE("the exact spin is what the forces give, for light and heavy blocks, either way round") {
  for (const double mass : {0.01, 1.0, 50.0})
    for (const double spin : {5.0, -0.7, 40.0})
      for (const double t : {0.01, 0.4, 1.0, 7.0}) {
        const Scene scene{.mass = mass, .spin = spin};
        const auto truth = integrated(scene, t);
        const auto exact = prismatic::exact(scene, t);
        INFO("mass " << mass << ", spin " << spin << ", t " << t);
        const double r = double(truth.r);
        CHECK(exact.x.norm() == Approx(r).epsilon(1e-14));
        CHECK(exact.theta == Approx(double(truth.theta)).epsilon(1e-14));
        CHECK(exact.omega == Approx(double(truth.omega)).epsilon(1e-13));
        const Vector2d e = along(exact.theta), n = across(exact.theta);
        CHECK(exact.v.dot(e) == Approx(double(truth.rdot)).epsilon(1e-13));
        CHECK(exact.v.dot(n) == Approx(double(truth.r * truth.omega)).epsilon(1e-13));
        // The reaction: Newton and Euler for the block.
        const double I0 = scene.rail_inertia + scene.inertia();
        const double alpha = double(-2 * mass * truth.r * truth.rdot * truth.omega /
                                    (I0 + mass * truth.r * truth.r));
        const double force = mass * double(truth.r * alpha + 2 * truth.rdot * truth.omega);
        // Far out the two terms of the force cancel, here but not in exact.hpp.
        const double size = 2 * mass * double(truth.rdot * std::abs(truth.omega));
        CHECK(exact.force.dot(n) == Approx(force).epsilon(0.0).margin(1e-13 * size));
        CHECK(exact.force.dot(e) == Approx(0.0).margin(1e-13 * size));
        CHECK(exact.moment == Approx(scene.inertia() * alpha).epsilon(1e-12));
      }
}

TEST_CASE("limits of the exact spin") {
  const Scene scene{.spin = 5.0};
  const auto start = prismatic::exact(scene, 0.0);
  CHECK((start.x - Vector2d(0.3, 0.0)).norm() < 1e-16);
  CHECK((start.v - Vector2d(0.0, 1.5)).norm() < 1e-15);
  CHECK(start.force.norm() == 0.0);
  // Far out the rail is almost at rest and all the energy has become speed along it: L²/I(r0) = m
  // ṙ².
  const double I = scene.rail_inertia + scene.inertia() + 0.09;
  const auto late = prismatic::exact(scene, 1e4);
  CHECK(late.v.norm() == Approx(5.0 * std::sqrt(I)).epsilon(1e-6));
  CHECK(late.omega * (late.x.squaredNorm() + I - 0.09) == Approx(5.0 * I).epsilon(1e-12));
}

namespace {

/// A scene on the fixed rail with spring and damper.
Scene sprung(double k, double c, double s0 = 0.1, double v0 = 0.0, double incline = 30.0,
             double mass = 1.0) {
  return {.incline = incline, .mass = mass, .stiffness = k, .damping = c, .s0 = s0, .v0 = v0};
}

/// Way and velocity along the rail.
std::array<double, 2> on_rail(const Scene& scene, double t) {
  const auto exact = prismatic::exact(scene, t);
  return {exact.x.dot(along(scene.angle())), exact.v.dot(along(scene.angle()))};
}

// The second derivation of the fixed rail: the state (s, ṡ, 1) obeys ẏ = A y, so y(t) = exp(A t)
// y(0), by the power series over a span so short that A t is small, squared as often as needed. The
// velocity counts in units that make A t small soonest.
std::array<long double, 2> by_exponential(const Scene& scene, double t) {
  using Matrix = Eigen::Matrix<long double, 3, 3>;
  const long double k = scene.stiffness / static_cast<long double>(scene.mass),
                    c = scene.damping / static_cast<long double>(scene.mass),
                    unit = std::max({std::sqrt(k), c, 1.0L});
  Matrix A;
  A << 0, unit, 0, -k / unit, -c, scene.gravity * std::sin(scene.angle()) / unit, 0, 0, 0;
  A *= t;
  int halvings = 0;
  for (; A.lpNorm<1>() > 0.1L; ++halvings) A *= 0.5L;
  // Of exp(A) − 1, which squares to 2 x + x²: nothing is lost beside the 1.
  Matrix x = Matrix::Zero(), term = Matrix::Identity();
  for (int n = 1; n < 20; ++n) x += term = term * A / n;
  for (int i = 0; i < halvings; ++i) x = 2 * x + x * x;
  const Eigen::Vector<long double, 3> start(scene.s0, scene.v0 / unit, 1.0L);
  const Eigen::Vector<long double, 3> end = start + x * start;
  return {end[0], unit * end[1]};
}

}  // namespace

TEST_CASE("the exact spring and damper are the exponential of their equation, in every regime") {
  // Undamped, weak and strong damping, critical, and all of it stiff; no spring, nothing at all.
  for (const auto& [k, c] : {std::pair{0.0, 0.0},
                             {100.0, 0.0},
                             {100.0, 1.0},
                             {100.0, 20.0},
                             {100.0, 20.0000001},
                             {100.0, 19.9999999},
                             {100.0, 300.0},
                             {1e4, 1e5},
                             {1e4, 1e-5},
                             {1e10, 0.0},
                             {1e10, 2e5},
                             {1e10, 1e7},
                             {1e-12, 0.0},
                             {1e-6, 1e-3},
                             {0.0, 1e-9},
                             {0.0, 3.0},
                             {0.0, 1e6},
                             {1e-9, 1e6}})
    for (const double mass : {1.0, 7.0})
      for (const double t : {1e-7, 1e-3, 0.05, 0.7, 2.0}) {
        const Scene scene = sprung(k, c, 0.1, -0.3, 30.0, mass);
        const auto [s, v] = on_rail(scene, t);
        const auto truth = by_exponential(scene, t);
        INFO("k " << k << ", c " << c << ", mass " << mass << ", t " << t);
        const double speed =
            0.3 + 0.1 * std::min(std::sqrt(k / mass), c > 0.0 ? k / c : 1e300) + 9.81 * t;
        CHECK(s == Approx(double(truth[0])).epsilon(0.0).margin(1e-14 * (1.0 + 5.0 * t * t)));
        CHECK(v == Approx(double(truth[1])).epsilon(0.0).margin(1e-12 * speed));
      }
}

TEST_CASE("limits of the exact spring and damper") {
  const double g = 9.81 * 0.5, t = 1.3;
  {  // without a damper it swings about where the spring carries the block
    const double w = 10.0, rest = g / 100.0;
    const auto [s, v] = on_rail(sprung(100.0, 0.0, 0.1, 0.4), t);
    CHECK(s == Approx(rest + (0.1 - rest) * std::cos(w * t) + 0.4 / w * std::sin(w * t)));
    CHECK(v == Approx(-w * (0.1 - rest) * std::sin(w * t) + 0.4 * std::cos(w * t)));
  }
  {  // without a spring it tends to the speed g/c
    const auto [s, v] = on_rail(sprung(0.0, 4.0, 0.1, 0.4), t);
    const double left = std::exp(-4.0 * t), end = g / 4.0;
    CHECK(s == Approx(0.1 + end * t + (0.4 - end) * (1.0 - left) / 4.0));
    CHECK(v == Approx(end + (0.4 - end) * left));
  }
  {  // critically damped
    const auto [s, v] = on_rail(sprung(25.0, 10.0, 0.1, 0.4, 0.0), t);
    CHECK(s == Approx((0.1 + (0.4 + 0.5) * t) * std::exp(-5.0 * t)));
    CHECK(v == Approx((0.9 - 5.0 * (0.1 + 0.9 * t)) * std::exp(-5.0 * t)));
  }
  // Across the critical damping, and as spring and damper vanish, nothing jumps.
  const auto close = [&](const Scene& a, const Scene& b, double most) {
    CHECK(std::abs(on_rail(a, t)[0] - on_rail(b, t)[0]) < most);
    CHECK(std::abs(on_rail(a, t)[1] - on_rail(b, t)[1]) < most);
  };
  for (const double off : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15})
    for (const double sign : {1.0, -1.0})
      close(sprung(25.0, 10.0 * (1.0 + sign * off)), sprung(25.0, 10.0), off + 1e-16);
  for (const double small : {1e-3, 1e-6, 1e-9, 1e-12}) {
    close(sprung(small, 0.0), sprung(0.0, 0.0), 10.0 * small + 1e-15);
    close(sprung(0.0, small), sprung(0.0, 0.0), 10.0 * small + 1e-15);
    close(sprung(small, 5.0), sprung(0.0, 5.0), 10.0 * small + 1e-15);
    close(sprung(90.0, small), sprung(90.0, 0.0), 10.0 * small + 1e-15);
  }
  // The slow motion alone: s(t) = s0 e^(−ρ t), to the digits of its start.
  const Scene slow = sprung(1e4, 1e5, 0.1, -0.01000001, 0.0);
  const double rho = 1e4 / (5e4 + std::sqrt(25e8 - 1e4));
  CHECK(on_rail(slow, 2.0)[0] == Approx(0.1 * std::exp(-2.0 * rho)).epsilon(1e-14));
}

TEST_CASE("what the exact damper takes is what the exact energy loses") {
  using Quadrature = boost::math::quadrature::gauss_kronrod<double, 61>;
  for (const auto& [k, c] :
       {std::pair{50.0, 0.0}, {50.0, 2.0}, {100.0, 20.0}, {30.0, 90.0}, {0.0, 5.0}})
    for (const double t : {0.01, 0.8, 2.0}) {
      const Scene scene = sprung(k, c, 0.2, 1.5);
      const auto energy = [&, k = k](double at) {
        const auto [s, v] = on_rail(scene, at);
        return 0.5 * v * v + 0.5 * k * s * s - 9.81 * 0.5 * s;
      };
      const double taken = Quadrature::integrate(
          [&, c = c](double at) { return c * on_rail(scene, at)[1] * on_rail(scene, at)[1]; }, 0.0,
          t, 12, 1e-14);
      CHECK(energy(0.0) - energy(t) == Approx(taken).epsilon(1e-12).margin(1e-13));
    }
}

TEST_CASE("spring and damper in motion converge to the exact answer, and leave the rail alone") {
  using enum integrators::Scheme;
  for (const Scene& scene : {sprung(60.0, 0.0, 0.2, 1.0), sprung(60.0, 3.0, 0.2, 1.0, -50.0, 2.0),
                             sprung(4.0, 9.0, -0.3)}) {
    const measure::Start start = [&](const Method& method) {
      return std::make_unique<Motion>(motion(scene, method));
    };
    const measure::Errors errors = [&](const mechanics::Row& row) {
      auto all = prismatic::errors(scene, row);
      CHECK(all[2] < 1e-11);  // the rail's force and moment are those of the free block
      CHECK(all[3] < 1e-11);
      return std::vector<double>{all[0], all[1]};
    };
    const auto theory_holds = [](const measure::Rung& rung, std::size_t k) {
      return rung.errors[k] > 1e-12 && rung.step < 1.5e-3;
    };
    CHECK(check_orders({.methods = {{explicit_euler}, {implicit_midpoint}, {rk4}},
                        .duration = 0.5,
                        .coarsest = 1.0 / 64,
                        .rungs = 9},
                       start, errors, theory_holds) > 10);
    Motion block = motion(scene, {dop853});
    block.advance(32, 0.5 / 32);
    for (const double error : errors(block.row())) CHECK(error < 1e-13);
  }
}

TEST_CASE("a spring keeps the energy, with a damper it is not compared, and none is gained") {
  Motion spring = motion(sprung(100.0, 0.0));
  spring.advance(1000, 1e-3);
  CHECK(spring.measures().balances());
  CHECK(spring.measures().energy == Approx(0.5 - 9.81 * 0.05).epsilon(1e-9));
  const auto verdict = [](const Scene& scene, const Method& method, long steps, double h) {
    Motion block = motion(scene, method);
    mechanics::Watch watch(block);
    measure::run(block, {steps, h}, watch);
    CHECK(std::isnan(watch.largest_energy_error()));
    const auto errors = prismatic::errors(scene, block.row());
    return measure::judge(watch, {{"position", "m"}, {"velocity", "m/s"}}, {errors[0], errors[1]});
  };
  using enum integrators::Scheme;
  CHECK(verdict(sprung(100.0, 3.0), {}, 1000, 1e-3).right());
  // Explicit Euler gains some in its first steps, which the damper takes again.
  CHECK(verdict(sprung(0.0, 800.0, 0.0, 0.0, -0.5, 0.1), {explicit_euler}, 150, 1.7e-4).right());
  const Scene slow = sprung(1e4, 1e5, 0.1, -0.01000001, 0.0);
  CHECK(verdict(slow, {implicit_midpoint}, 8, 0.25).right());
  CHECK(verdict(slow, {}, 8, 0.25).words() == "energy, position and velocity");
  // Off the slow motion the midpoint rule turns the fast part round: the place is right, the
  // velocity is not.
  const Scene kicked = sprung(1e4, 1e5, 0.1, 1.0, 0.0);
  CHECK(verdict(kicked, {implicit_midpoint}, 8, 0.25).words() == "velocity");
  CHECK(verdict(kicked, {implicit_midpoint}, 4096, 2.0 / 4096).right());
  // A block that stays where spring and weight balance.
  const Scene still = sprung(1e3, 10.0, 9.81 * 0.5 / 1e3);
  CHECK(verdict(still, {}, 1000, 1e-3).right());
  CHECK(verdict(still, {implicit_midpoint}, 1000, 1e-3).right());
  CHECK(verdict(sprung(1e3, 10.0, 0.0, 0.0, 0.0), {}, 1000, 1e-3).right());
}

TEST_CASE("the midpoint rule turns a fast part round by (1 - z/2)/(1 + z/2) in each step") {
  const double h = 0.05, z = h * 1e5;
  const Scene kicked{.incline = 0.0, .damping = 1e5, .v0 = 1.0};
  Motion block = motion(kicked, {integrators::Scheme::implicit_midpoint});
  double factor = 1.0;
  for (int i = 0; i < 9; ++i) {
    block.advance(1, h);
    factor *= (1.0 - z / 2.0) / (1.0 + z / 2.0);
    CHECK(block.v()[0] == Approx(factor).epsilon(1e-9));
  }
}

TEST_CASE("without spring, damper and start the block is the old one, on a spinning rail refused") {
  Mechanism sliding = make_mechanism({});
  CHECK(sliding.initial_velocity().norm() == 0.0);
  CHECK_FALSE(sliding.work);
  for (const Scene& scene :
       {Scene{.spin = 5.0, .stiffness = 1.0}, Scene{.spin = 5.0, .damping = 1.0},
        Scene{.spin = 5.0, .s0 = 0.1}, Scene{.spin = 5.0, .v0 = -1.0}})
    CHECK_THROWS_AS(make_mechanism(scene), std::invalid_argument);
}

TEST_CASE("on the incline every method with the right velocity is exact, and RK4 is") {
  for (const double incline : {30.0, -50.0, 0.0, 90.0}) {
    const Scene scene{.incline = incline, .mass = 2.5};
    Motion block = motion(scene);
    block.advance(20, 0.1);
    for (const double error : prismatic::errors(scene, block.row())) CHECK(error < 1e-12);
    const double beta = incline * std::numbers::pi / 180.0;
    const double s = 0.5 * 9.81 * std::sin(beta) * 4.0;
    CHECK((block.q().head<2>() - Vector2d(s * std::cos(beta), s * std::sin(beta))).norm() < 1e-12);
    // The reaction pushes the block off the rail, upwards, and turns nothing.
    const mechanics::Row row = block.row();
    const double N = 2.5 * 9.81 * std::cos(beta);
    CHECK(row.reactions[0] == Approx(N * std::sin(beta)).epsilon(0.0).margin(1e-12));
    CHECK(row.reactions[1] == Approx(-N * std::cos(beta)).epsilon(0.0).margin(1e-12));
    CHECK(row.reactions[2] == Approx(0.0).margin(1e-13));
    CHECK(row.measures.constraint_error < 1e-13);
  }
  // Semi-implicit Euler is off by g sin β t h/2, explicit Euler by the same the other way.
  for (const auto& [name, sign] : {std::pair{integrators::Scheme::semi_implicit_euler, 1.0},
                                   std::pair{integrators::Scheme::explicit_euler, -1.0}}) {
    Motion block = motion({}, {.integrator = name});
    block.advance(100, 0.01);
    const double s = block.q().head<2>().norm();
    CHECK(s - 0.5 * 9.81 * 0.5 == Approx(sign * 9.81 * 0.5 * 0.01 / 2).epsilon(1e-9));
  }
}

TEST_CASE("position, velocity, force and moment converge with the order of the integrator") {
  using enum integrators::Scheme;
  for (const Scene& scene : {Scene{.spin = 5.0}, Scene{.mass = 3.0, .spin = -2.0}}) {
    INFO("spin " << scene.spin);
    const measure::Start start = [&](const Method& method) {
      return std::make_unique<Motion>(motion(scene, method));
    };
    const measure::Errors errors = [&](const mechanics::Row& row) {
      return prismatic::errors(scene, row);
    };
    const auto theory_holds = [](const measure::Rung& rung, std::size_t k) {
      return rung.errors[k] > (k == 3 ? 1e-13 : 1e-11) &&
             rung.step < (rung.order == 1 ? 1e-3 : 1e-2);
    };
    CHECK(check_orders({.methods = {{explicit_euler},
                                    {semi_implicit_euler},
                                    {implicit_midpoint},
                                    {rk4},
                                    {rk4, Stabilization::projection}},
                        .duration = 0.5,
                        .coarsest = 1.0 / 64,
                        .rungs = 9},
                       start, errors, theory_holds) > 60);
    if (scene.spin < 0.0) continue;
    check_order({dop853}, 0.5, 12, start, errors);
    check_order({dop853, Stabilization::projection}, 0.5, 12, start, errors);
  }
}

TEST_CASE("energy and angular momentum are kept") {
  const Scene scene{.spin = 5.0};
  Motion spin = motion(scene, {integrators::Scheme::rk4, Stabilization::projection});
  const double I = scene.rail_inertia + 0.05 / 12.0 + 0.09;
  CHECK(angular_momentum(scene, spin.q(), spin.v()) == Approx(5.0 * I).epsilon(1e-15));
  CHECK(spin.measures().energy == Approx(0.5 * 25.0 * I).epsilon(1e-15));
  spin.advance(2000, 1e-3);
  CHECK(angular_momentum(scene, spin.q(), spin.v()) == Approx(5.0 * I).epsilon(1e-11));
  CHECK(spin.measures().energy == Approx(0.5 * 25.0 * I).epsilon(1e-11));
  Motion block = motion({.incline = 40.0, .mass = 2.0});
  block.advance(100, 0.01);
  CHECK(block.measures().energy == Approx(0.0).margin(1e-12));
}

TEST_CASE("rail and pin push against each other: the sum on the rail is nothing") {
  Motion spin = motion({.spin = 5.0});
  spin.advance(300, 1e-3);
  const mechanics::Row row = spin.row();
  const Vector2d block(row.reactions[0], row.reactions[1]), pin(row.reactions[3], row.reactions[4]);
  CHECK((pin - block).norm() < 1e-12 * block.norm());
  CHECK(row.reactions[5] == Approx(0.0).margin(1e-13));
  // The block slows the rail by its force at r and by the moment that turns the block itself.
  VectorXd a(6);
  spin.model().acceleration(0.0, spin.q(), spin.v(), a);
  const Vector2d r = spin.q().segment<2>(3);
  const double moment = -(r.x() * block.y() - r.y() * block.x()) - row.reactions[2];
  CHECK(moment == Approx(Scene{}.rail_inertia * a[2]).epsilon(1e-12));
  CHECK(a[2] < 0.0);
}

TEST_CASE("rows and columns by hand count, names as the table has them") {
  Motion block = motion({});
  block.advance(1, 1e-3);
  const auto incline = block.model().evaluation().counts();
  CHECK((incline.coordinates == 3 && incline.rows == 2 && incline.rank == 2 &&
         incline.degrees_of_freedom == 1));
  CHECK(block.columns().state.front() == "block.x");
  CHECK(block.columns().reactions ==
        std::vector<std::string>{"block_rail.fx", "block_rail.fy", "block_rail.moment"});
  Motion spin = motion({.spin = 5.0});
  spin.advance(1, 1e-3);
  const auto turning = spin.model().evaluation().counts();
  CHECK((turning.coordinates == 6 && turning.rows == 4 && turning.rank == 4 &&
         turning.degrees_of_freedom == 2));
  CHECK(spin.columns().state.front() == "rail.x");
  CHECK(spin.columns().reactions[3] == "rail_world.fx");
}

TEST_CASE("solution 3: with a second rail the motion stays right, and its rows are named") {
  const Scene scene{.incline = 25.0};
  const auto build = [&](bool second_rail) {
    Mechanism mechanism({});
    dynamics::System& system = mechanism.system;
    system.set_gravity({0.0, scene.gravity});
    const double beta = scene.angle();
    const auto block = system.add_body("block", 1.0, scene.inertia(), {0.0, 0.0}, beta);
    const joints::Prismatic rail{.n_hat = across(beta), .theta21 = beta};
    joints::Prismatic beside = rail;
    beside.u1 = 0.05 * across(beta);  // a rail along the lower side of the block
    beside.u2 = {0.0, 0.05};
    const auto first = system.add("block_rail", rail, system.world, block);
    if (second_rail) system.add("second_rail", beside, system.world, block);
    mechanism.report("block_rail", first, block);
    mechanism.assemble();
    return Motion(std::move(mechanism), {});
  };
  Motion one = build(false), two = build(true);
  one.advance(100, 0.01);
  two.advance(100, 0.01);
  CHECK((one.q() - two.q()).norm() < 1e-12);
  CHECK((two.q().head<2>() - prismatic::exact(scene, 1.0).x).norm() < 1e-12);
  REQUIRE(two.model().evaluation().counts().rank == 2);
  for (std::size_t i = 0; i < 3; ++i)  // the first rail carries what it did alone
    CHECK(two.row().reactions[i] == Approx(one.row().reactions[i]).margin(1e-12));
  const auto dependent = two.model().evaluation().dependent_rows();
  REQUIRE(dependent.size() == 2);
  for (const auto& row : dependent) CHECK(row.joint == "second_rail");
}

TEST_CASE("a step allocates nothing") {
  for (const Scene& scene : {Scene{}, Scene{.spin = 5.0}, sprung(100.0, 2.0)})
    for (const auto stabilization :
         {Stabilization::none, Stabilization::feedback, Stabilization::projection}) {
      Motion block = motion(scene, {integrators::Scheme::rk4, stabilization, 100.0, 20.0});
      block.advance(1, 1e-3);
      const long before = allocations();
      block.advance(100, 1e-3);
      CHECK(allocations() == before);
    }
}

TEST_CASE("projection keeps the block on the turning rail to rounding") {
  Motion spin = motion({.spin = 5.0}, {integrators::Scheme::rk4, Stabilization::projection});
  spin.advance(100, 0.01);
  CHECK(spin.measures().constraint_error < 1e-14);
  CHECK(spin.measures().velocity_error < 1e-13);
}

TEST_CASE("without the Coriolis part the rail gives way by C̈ = 2 ω1 (S n)·ḋ") {
  const Scene scene{.spin = 5.0};
  const auto truth = prismatic::exact(scene, 0.3);
  VectorXd q(6), v(6), a(6);
  q << 0.0, 0.0, truth.theta, truth.x, truth.theta;
  v << 0.0, 0.0, truth.omega, truth.v, truth.omega;
  const Vector2d n = across(truth.theta);
  // C = n·x2 with n turning: C̈ = n·a2 − 2 ω e·v2 − α e·x2 − ω² n·x2, since dn/dt = −ω e.
  const auto Cddot = [&](Mechanism mechanism) {
    mechanism.acceleration(0.0, q, v, a);
    const Vector2d e = along(truth.theta);
    return n.dot(a.segment<2>(3)) - 2 * truth.omega * e.dot(truth.v) - a[2] * e.dot(truth.x) -
           truth.omega * truth.omega * n.dot(truth.x);
  };
  CHECK(Cddot(prismatic::make_spin(scene)) == Approx(0.0).margin(1e-12));
  const double rdot = truth.v.dot(along(truth.theta));
  CHECK(Cddot(prismatic::make_spin<prismatic::WithoutCoriolis>(scene)) ==
        Approx(-2 * truth.omega * rdot).epsilon(1e-12));
}

TEST_CASE("solution 1: pushed at its lower edge the block feels a moment, and slides as before") {
  // A force along the rail at the lower edge, 0.05 m across from the centre of mass.
  const Scene scene;
  const double push = 3.0, beta = scene.angle();
  Mechanism block = make_mechanism(scene);
  const Vector2d force = push * along(beta), arm = 0.05 * across(beta);
  block.system.apply(block.system.thing<Body>("block"),
                     Vector3d(force.x(), force.y(), arm.x() * force.y() - arm.y() * force.x()));
  mechanics::Row row;
  row.measures = block.measures(0.0, block.initial_position(), block.initial_velocity());
  block.observe(0.0, block.initial_position(), block.initial_velocity(), row);
  CHECK(row.reactions[2] == Approx(push * 0.05).epsilon(1e-13));
  VectorXd a(3);
  block.acceleration(0.0, block.initial_position(), block.initial_velocity(), a);
  CHECK(a.head<2>().dot(along(beta)) == Approx(9.81 * 0.5 + push).epsilon(1e-13));
  CHECK(a[2] == Approx(0.0).margin(1e-12));
}

TEST_CASE("solution 2: held at r0 the block needs a force of m ω² r0 inwards, and ω stays") {
  const Scene scene{.mass = 2.0, .spin = 5.0};
  Mechanism spin = make_mechanism(scene);
  spin.system.apply(spin.system.thing<Body>("block"), [&](double, const Body& block) {
    const Vector2d pull = -scene.mass * block.omega * block.omega * block.x;
    return Vector3d(pull.x(), pull.y(), 0.0);
  });
  Motion held(std::move(spin), {integrators::Scheme::rk4, Stabilization::projection});
  held.advance(1000, 1e-3);
  CHECK(held.q().segment<2>(3).norm() == Approx(0.3).epsilon(1e-10));
  CHECK(held.v()[2] == Approx(5.0).epsilon(1e-10));
  for (std::size_t i = 0; i < 3; ++i)  // the rail has nothing to push
    CHECK(held.row().reactions[i] == Approx(0.0).margin(1e-8));
}

namespace {
const measure::RunOptions defaults{.duration = 2.0, .step = 0.002};
}

TEST_CASE("the pictures of the lesson are those that the program draws") {
  picture_check::compare_all("06_prismatic", prismatic::pictures({}, defaults));
}

TEST_CASE("pictures can be drawn of every scene the options allow") {
  for (const Scene& scene :
       {Scene{.incline = 90.0}, Scene{.incline = -90.0}, Scene{.incline = 0.0}, Scene{.mass = 1e12},
        Scene{.gravity = 0.0}, Scene{.spin = -1e-3}, Scene{.spin = 1e3}, sprung(100.0, 2.0),
        sprung(1e6, 1.0, -1e6, 1e6), Scene{.damping = 1e-12}}) {
    INFO(scene.incline << " " << scene.mass << " " << scene.spin);
    const measure::RunOptions run{.duration = 0.01, .step = 1e-4};
    for (const auto& picture : prismatic::pictures(scene, run))
      CHECK_NOTHROW(draw::render({.scale = 0.5}, picture.draw));
    CHECK_NOTHROW(draw::render({.width = 480, .height = 300},
                               pictures::picture_at(prismatic::stage(scene, run), 0.005).draw));
  }
}

TEST_CASE("every stiff and extreme case ends as expected, and the map is that of theory") {
  check_stability(prismatic::stability());
}

TEST_CASE("J and Jdot v of the joint are the derivatives of C, wherever its points lie") {
  const joints::Prismatic rail{
      .u1 = {0.3, -0.2}, .u2 = {-0.4, 0.7}, .n_hat = {0.6, 0.8}, .theta21 = 0.5};
  const Vector3d q[] = {{0.2, -1.1, 0.7}, {1.3, 0.4, -1.9}},
                 v[] = {{0.5, -0.8, 1.7}, {-0.3, 0.9, 2.3}};
  const auto body = [&](int i, double t) {
    const Vector3d x = q[i] + t * v[i];
    return Body{x.head<2>(), v[i].head<2>(), x[2], v[i][2], dynamics::rotation(x[2])};
  };
  const auto C = [&](double t) { return rail.rows(body(0, t), body(1, t)).C; };
  const auto rows = rail.rows(body(0, 0), body(1, 0));
  const double h = 1e-4;
  CHECK((rows.J1 * v[0] + rows.J2 * v[1] - (C(h) - C(-h)) / (2 * h)).norm() < 1e-7);
  CHECK((rows.Jdot_v - (C(h) - 2 * C(0) + C(-h)) / (h * h)).norm() < 1e-6);
}
