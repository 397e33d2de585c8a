#include <Eigen/LU>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "allocations.hpp"
#include "catch.hpp"
#include "cost.hpp"
#include "exact.hpp"
#include "full_matrices.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/measure/run_options.hpp"
#include "instruments/pictures/stage.hpp"
#include "main_check.hpp"
#include "mechanism.hpp"
#include "orders.hpp"
#include "picture_check.hpp"
#include "stability_check.hpp"
#include "study.hpp"

using dynamics::Body;
using dynamics::System;
using mechanics::Mechanism;
using mechanics::Method;
using mechanics::Stabilization;
using revolute::direction;
using revolute::end_of_rod;
using revolute::make_mechanism;
using revolute::Scene;

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

using Motion = mechanics::Motion<Mechanism>;

constexpr double pi = std::numbers::pi;

Motion motion(const Scene& scene, const Method& method = {}) {
  return {make_mechanism(scene, method), method};
}

Vector2d free_end(const Scene& scene, const Motion& motion) {
  return end_of_rod(scene, motion.q(), scene.links - 1);
}

// The second derivation of the pendulum: time as an integral over the angle, in 50 digits.
using Real = boost::multiprecision::cpp_bin_float_50;

/// Time from rest at φ0 > 0, counted from hanging, to φ0 cos(π part): part 1 is half a period. From
/// energy φ̇² = 2 ω0² (cos φ − cos φ0); written as a product of sines, and with φ = φ0 cos s, the
/// roots at both ends cancel.
Real time_to(const Scene& scene, const Real& phi0, const Real& part) {
  const Real omega0 = sqrt(3 * Real(scene.gravity) / (2 * Real(scene.length)));
  const auto dt_ds = [&](const Real& s) {
    // cos φ − cos φ0 = 2 sin((φ0 + φ)/2) sin((φ0 − φ)/2), and (φ0 ± φ)/2 = φ0 cos²(s/2), φ0
    // sin²(s/2).
    const Real a = phi0 * cos(s / 2) * cos(s / 2), b = phi0 * sin(s / 2) * sin(s / 2);
    const auto sinc = [](const Real& x) -> Real { return x == 0 ? Real(1) : Real(sin(x) / x); };
    return 1 / (omega0 * sqrt(sinc(a) * sinc(b)));  // φ0 sin s cancels: sin s = 2 sin(s/2) cos(s/2)
  };
  return boost::math::quadrature::gauss_kronrod<Real, 61>::integrate(
      dt_ds, Real(0), boost::math::constants::pi<Real>() * part, 12, Real(1e-28));
}

}  // namespace

TEST_CASE("the exact swing is right over thousands of periods, from tiny amplitudes to near π") {
  const Real half_pi = boost::math::constants::half_pi<Real>();
  for (const double amplitude : {1e-6, 1e-3, 0.5, pi / 2, 2.5, 3.1, 3.1415}) {
    const Scene scene{.length = 1.3, .angle0 = pi / 2 + amplitude};
    const Real phi0 = Real(scene.angle0) - half_pi;
    const Real half_period = time_to(scene, phi0, 1);
    for (const int periods : {0, 1, 30, 5000})
      for (const double part : {0.05, 0.3, 0.5, 0.9}) {
        const Real exact_t = 2 * periods * half_period + time_to(scene, phi0, part);
        const double t = static_cast<double>(exact_t);
        const Real phi = phi0 * cos(2 * half_pi * part);
        const Real omega0_squared = 3 * Real(scene.gravity) / (2 * Real(scene.length));
        const Real rate = -sqrt(2 * omega0_squared * (cos(phi) - cos(phi0)));
        const Real dt = Real(t) - exact_t;  // t was rounded to a double
        const Real truth = half_pi + phi + rate * dt - omega0_squared * sin(phi) * dt * dt / 2;
        const auto [theta, omega] = revolute::swing(scene, t);
        INFO("amplitude " << amplitude << ", t " << t);
        CHECK(std::abs(theta - static_cast<double>(truth)) <= 1e-15 * (1 + std::abs(theta)));
        const Real truth_rate = rate - omega0_squared * sin(phi) * dt;
        CHECK(std::abs(omega - static_cast<double>(truth_rate)) <=
              1e-14 * std::abs(static_cast<double>(rate)) + 1e-18);
      }
  }
}

TEST_CASE("limits of the exact swing that need no integral") {
  // Small swings are an oscillator with ω0² = 3g/2L; without gravity nothing moves; each turn of
  // the start turns the whole motion.
  const double omega0 = std::sqrt(1.5 * 9.81);
  const auto small = revolute::swing({.angle0 = pi / 2 - 1e-5}, 2.0);
  CHECK(small.theta - pi / 2 == Approx(-1e-5 * std::cos(2.0 * omega0)).epsilon(1e-8));
  CHECK(small.omega == Approx(1e-5 * omega0 * std::sin(2.0 * omega0)).epsilon(1e-8));
  CHECK(revolute::swing({.angle0 = 0.3, .gravity = 0.0}, 5.0).theta == Approx(0.3).epsilon(1e-15));
  CHECK(revolute::swing({}, 0.0).theta == Approx(0.0).margin(1e-16));
  const auto once = revolute::swing({.angle0 = 0.4}, 3.0);
  const auto turned = revolute::swing({.angle0 = 0.4 + 2 * pi}, 3.0);
  CHECK(turned.theta - once.theta == Approx(2 * pi).epsilon(1e-14));
  // Released upright to the left, it falls to the left.
  CHECK(revolute::swing({.angle0 = -pi / 2 - 0.1}, 0.5).omega < 0.0);
}

TEST_CASE("pin force of the rod released from horizontal: (5/2) m g sin θ and (1/4) m g cos θ") {
  const Scene scene{.length = 0.7, .mass = 2.0};
  const double weight = 2.0 * 9.81;
  Motion rod = motion(scene);
  for (const double t : {0.0, 0.1, 0.25, 0.4, 0.6, 0.9}) {
    const auto [theta, omega] = revolute::swing(scene, t);
    const Vector2d e = direction(theta), across(-e.y(), e.x());
    const Vector2d expected =
        -2.5 * weight * std::sin(theta) * e - 0.25 * weight * std::cos(theta) * across;
    CHECK((revolute::exact_pendulum(scene, t).pin_force - expected).norm() < 1e-13 * weight);
    // And the program's, from the state alone.
    VectorXd q(3), v(3), a(3);
    const Vector2d x = scene.length / 2 * e, xdot = scene.length / 2 * omega * across;
    q << x, theta;
    v << xdot, omega;
    Mechanism& model = rod.model();
    mechanics::Row row;
    row.measures = model.measures(t, q, v);
    model.observe(t, q, v, row);
    CHECK((Vector2d(row.reactions[0], row.reactions[1]) - expected).norm() < 1e-13 * weight);
    // The pin sits at −L/2 from the centre of mass: its moment about it is that lever times force.
    const double lever = -scene.length / 2 * across.dot(expected);
    CHECK(row.reactions[2] == Approx(lever).epsilon(0.0).margin(1e-13 * weight));
  }
}

TEST_CASE("the end of the rod at 0.5 s, and that of a chain of 10") {
  const auto end = [](const Scene& scene) {
    Motion rods = motion(scene);
    rods.advance(5000, 1e-4);
    return free_end(scene, rods);
  };
  CHECK((end({}) - Vector2d(-0.0902292085736804, 0.9959210259454147)).norm() < 1e-12);
  CHECK((end({.links = 10}) - Vector2d(-0.264645112001838, 0.863546754750283)).norm() < 1e-9);
}

TEST_CASE("the reference of chains: one link is the pendulum, its energy stays, Newton agrees") {
  const Scene one{.length = 0.8, .mass = 3.0, .angle0 = -0.7};
  for (const double t : {0.0, 0.3, 2.0}) {
    const auto chain = revolute::ChainReference(one).exact(t).value();
    const auto pendulum = revolute::exact_pendulum(one, t);
    CHECK((chain.end - pendulum.end).norm() < 1e-14);
    CHECK((chain.end_velocity - pendulum.end_velocity).norm() < 1e-13);
    CHECK((chain.pin_force - pendulum.pin_force).norm() < 1e-12);
  }
  for (const int links : {2, 3, 7}) {
    const Scene scene{.links = links, .length = 1.5, .mass = 2.0, .angle0 = 0.3};
    const revolute::ChainReference reference(scene);
    const double l = scene.l(), m = scene.m(), g = scene.gravity;
    // Of rod i: centre of mass and its rates, from the angles.
    struct Rod {
      Vector2d x, v, a;
      double omega, alpha;
    };
    const auto rods = [&](double t) {
      const auto y = reference.at(t).value();
      const auto alpha = reference.acceleration(y);
      std::vector<Rod> list;
      Rod tip{Vector2d::Zero(), Vector2d::Zero(), Vector2d::Zero(), 0, 0};
      for (int i = 0; i < links; ++i) {
        const double w = double(reference.omega(y, i)), al = double(alpha[i]);
        const Vector2d e = direction(double(reference.theta(y, i))), n(-e.y(), e.x());
        const Vector2d dx = l / 2 * e, dv = l / 2 * w * n, da = l / 2 * (al * n - w * w * e);
        list.push_back({tip.x + dx, tip.v + dv, tip.a + da, w, al});
        tip = {tip.x + 2 * dx, tip.v + 2 * dv, tip.a + 2 * da, 0, 0};
      }
      return list;
    };
    const auto energy = [&](double t) {
      double E = 0;
      for (const Rod& rod : rods(t))
        E +=
            m / 2 * rod.v.squaredNorm() + scene.I() / 2 * rod.omega * rod.omega - m * g * rod.x.y();
      return E;
    };
    CHECK(energy(0.0) == Approx(-2.0 * 9.81 * 0.75 * std::sin(0.3)).epsilon(1e-14));
    CHECK(energy(1.5) == Approx(energy(0.0)).epsilon(1e-13));
    // Euler's law about every pin, for all that hangs on it: what Lagrange's equations must agree
    // with, written without them.
    const auto now = rods(0.9);
    Vector2d pin(0, 0);
    for (int i = 0; i < links; ++i) {
      double balance = 0, size = 0;
      for (int k = i; k < links; ++k) {
        const Rod& rod = now[std::size_t(k)];
        const Vector2d r = rod.x - pin, f = m * (rod.a - Vector2d(0, g));
        const double moment = r.x() * f.y() - r.y() * f.x() + scene.I() * rod.alpha;
        balance += moment;
        size += std::abs(moment) + r.norm() * f.norm();
      }
      CHECK(std::abs(balance) < 1e-13 * size);
      pin = 2 * now[std::size_t(i)].x - pin;
    }
  }
}

TEST_CASE("position, velocity and pin force converge with the order of the integrator") {
  using enum integrators::Scheme;
  for (const Scene& scene :
       {Scene{}, Scene{.angle0 = -0.9}, Scene{.links = 2}, Scene{.links = 4}}) {
    INFO("links " << scene.links << ", angle0 " << scene.angle0);
    const measure::Start start = [&](const Method& method) {
      return std::make_unique<Motion>(motion(scene, method));
    };
    const measure::Errors errors = [&](const mechanics::Row& row) {
      return revolute::errors(scene, row);
    };
    const auto theory_holds = [&](const measure::Rung& rung, std::size_t k) {
      // The Euler methods meet their order late, a chain's many terms cancel late too.
      const double late = scene.links > 1 ? 6e-4 : 4e-3;
      return rung.errors[k] > (k == 0 ? 1e-12 : 1e-11) &&
             rung.step < (rung.order == 1 ? 4e-4 : late);
    };
    CHECK(check_orders({.methods = {{explicit_euler},
                                    {semi_implicit_euler},
                                    {implicit_midpoint},
                                    {rk4},
                                    {rk4, Stabilization::projection}},
                        .duration = 0.4,
                        .coarsest = 0.4 / 64,
                        .rungs = 8},
                       start, errors, theory_holds) > 24);
    if (scene.links > 1 || scene.angle0 != 0.0) continue;
    check_order({dop853}, 0.4, 8, start, errors);
    check_order({dop853, Stabilization::projection}, 0.4, 8, start, errors);
  }
}

TEST_CASE("energy is kept, the work of the pins is nothing") {
  for (const int links : {1, 3, 30}) {
    Motion rods = motion({.links = links, .mass = 2.0, .angle0 = 0.4},
                         {integrators::Scheme::rk4, Stabilization::projection});
    const double before = rods.measures().energy;
    CHECK(before == Approx(-2.0 * 9.81 * 0.5 * std::sin(0.4)).epsilon(1e-13));
    rods.advance(1000, 1e-3 / links);
    CHECK(rods.measures().energy == Approx(before).epsilon(0.0).margin(1e-9));
  }
}

TEST_CASE("the loop in main ends where the exact motion does") {
  const std::string text = printed_by("05_revolute");
  const double angle = revolute::swing({}, 5.0).theta;
  CHECK(std::abs(number_after(text, "rod stands at") - angle) < 1e-6);
  CHECK(std::abs(number_after(text, "error")) < 1e-6);
  CHECK(number_after(text, "largest |C|") < 1e-14);
}

TEST_CASE("the pins' forces explain the whole motion: Newton and Euler for each rod of a chain") {
  const Scene scene{.links = 3, .angle0 = 0.2};
  Motion rods = motion(scene);
  rods.advance(700, 1e-3);
  const mechanics::Row row = rods.row();
  VectorXd a(9);
  rods.model().acceleration(rods.time(), rods.q(), rods.v(), a);
  const Vector2d half(scene.l() / 2, 0.0);
  for (int i = 0; i < 3; ++i) {
    // Joint i acts on rod i at its start; joint i + 1 acts on rod i with the opposite, at its end.
    const auto force = [&](int joint) {
      return joint < 3 ? Vector2d(row.reactions[std::size_t(3 * joint)],
                                  row.reactions[std::size_t(3 * joint) + 1])
                       : Vector2d(Vector2d::Zero());
    };
    const Vector2d arm = scene.l() / 2 * direction(rods.q()[3 * i + 2]);
    const auto cross = [](const Vector2d& r, const Vector2d& f) {
      return r.x() * f.y() - r.y() * f.x();
    };
    const Vector2d sum = force(i) - force(i + 1) + Vector2d(0.0, scene.m() * scene.gravity);
    CHECK((sum - scene.m() * a.segment<2>(3 * i)).norm() < 1e-11);
    const double moment = cross(-arm, force(i)) - cross(arm, force(i + 1));
    CHECK(moment == Approx(scene.I() * a[3 * i + 2]).epsilon(0.0).margin(1e-11));
    CHECK(row.reactions[std::size_t(3 * i) + 2] ==
          Approx(cross(-arm, force(i))).epsilon(0.0).margin(1e-11));
  }
}

TEST_CASE("rows and columns by hand count, names as the table has them") {
  Motion rod = motion({});
  rod.advance(1, 1e-3);
  const auto one = rod.model().evaluation().counts();
  CHECK((one.coordinates == 3 && one.rows == 2 && one.rank == 2 && one.degrees_of_freedom == 1));
  CHECK(rod.columns().state ==
        std::vector<std::string>{"rod.x", "rod.y", "rod.theta", "rod.vx", "rod.vy", "rod.omega"});
  CHECK(rod.columns().reactions ==
        std::vector<std::string>{"rod_world.fx", "rod_world.fy", "rod_world.moment"});
  for (const int N : {2, 10, 200}) {
    Motion rods = motion({.links = N});
    rods.advance(1, 1e-4);
    const auto counts = rods.model().evaluation().counts();
    CHECK(counts.coordinates == 3 * N);
    CHECK(counts.rows == 2 * N);
    CHECK(counts.rank == 2 * N);
    CHECK(counts.degrees_of_freedom == N);
    CHECK(counts.jacobian_blocks == 2 * N - 1);  // two for each pin, one for the world's
  }
  CHECK(motion({.links = 3}).columns().reactions[3] == "rod2_rod1.fx");
}

TEST_CASE("a step allocates nothing") {
  for (const auto stabilization :
       {Stabilization::none, Stabilization::feedback, Stabilization::projection})
    for (const int links : {1, 20}) {
      Motion rods =
          motion({.links = links}, {integrators::Scheme::rk4, stabilization, 100.0, 20.0});
      rods.advance(1, 1e-3);
      const long before = allocations();
      rods.advance(100, 1e-3);
      CHECK(allocations() == before);
    }
}

TEST_CASE("projection holds the pins to rounding, feedback returns what it is given") {
  Motion rods = motion({.links = 5}, {integrators::Scheme::rk4, Stabilization::projection});
  rods.advance(2000, 1e-3);
  CHECK(rods.measures().constraint_error < 1e-14);
  CHECK(rods.measures().velocity_error < 1e-13);
  // Each row obeys C̈ + kd Ċ + ks C = 0: pulled off its pin by 0.01 m, the rod returns critically
  // damped, C(t) = C(0) (1 + 5t) exp(−5t).
  struct Off : Mechanism {
    explicit Off(Mechanism model) : Mechanism(std::move(model)) {}
    VectorXd initial_position() const {
      VectorXd q = Mechanism::initial_position();
      q[0] += 0.01;
      return q;
    }
  };
  const Method feedback{integrators::Scheme::rk4, Stabilization::feedback, 25.0, 10.0};
  mechanics::Motion<Off> fed(Off(make_mechanism({}, feedback)), feedback);
  fed.advance(1000, 1e-3);
  CHECK(fed.measures().constraint_error == Approx(0.01 * 6.0 * std::exp(-5.0)).epsilon(1e-6));
}

TEST_CASE("without J̇v the pin gives way by C̈ = −ω² A u") {
  Mechanism without = make_mechanism({.without_jdotv = true});
  const double theta = 0.7, omega = 3.0;
  const Vector2d e = direction(theta), across(-e.y(), e.x());
  VectorXd q(3), v(3), a(3);
  q << 0.5 * e, theta;
  v << 0.5 * omega * across, omega;
  without.acceleration(0.0, q, v, a);
  // The pin is at r = x − e/2: its acceleration is that of a point of the body.
  const Vector2d pin = a.head<2>() - 0.5 * (a[2] * across - omega * omega * e);
  CHECK((pin - 0.5 * omega * omega * e).norm() < 1e-13);
}

TEST_CASE("a pin given twice changes nothing, and is named") {
  const auto build = [](bool twice) {
    Mechanism mechanism({});
    System& system = mechanism.system;
    system.set_gravity({0.0, 9.81});
    const auto rod = system.add_body("rod", 1.0, 1.0 / 12, {0.5, 0.0});
    const joints::Revolute pin{{-0.5, 0.0}, {0.0, 0.0}};
    system.add("rod_world", pin, rod, system.world);
    if (twice) system.add("again", pin, rod, system.world);
    mechanism.assemble();
    return Motion(std::move(mechanism), {});
  };
  Motion once = build(false), twice = build(true);
  once.advance(500, 1e-3);
  twice.advance(500, 1e-3);
  CHECK((once.q() - twice.q()).norm() < 1e-13);
  REQUIRE(twice.model().evaluation().dependent_rows().size() == 2);
  CHECK(twice.model().evaluation().dependent_rows()[0].joint == "again");
}

TEST_CASE("where chaos or the work is too much, a chain has no exact answer") {
  // Two rods that start almost upright tumble, and forget within a minute where they came from.
  const revolute::ChainReference two(Scene{.links = 2, .angle0 = -1.5});
  CHECK(two.at(1.0).has_value());
  CHECK_FALSE(two.at(300.0).has_value());
  CHECK_FALSE(revolute::ChainReference(Scene{.links = 5, .gravity = 1e12}).at(1e6).has_value());
  // Without gravity it stays where it was put, however long that takes.
  const auto still = revolute::ChainReference(Scene{.links = 3, .gravity = 0.0}).exact(1e9);
  REQUIRE(still.has_value());
  CHECK((still->end - Vector2d(1.0, 0.0)).norm() < 1e-15);
}

TEST_CASE("long chains have no exact answer") {
  Motion rods = motion({.links = 11});
  CHECK(revolute::errors({.links = 11}, rods.row()).empty());
  Motion ten = motion({.links = 10});
  for (const double error : revolute::errors({.links = 10}, ten.row())) CHECK(error < 1e-12);
}

TEST_CASE("full matrices have the same equation: the solver's, to rounding") {
  for (const int links : {1, 2, 7}) {
    const Scene scene{.links = links, .length = 2.0, .mass = 3.0, .angle0 = 0.4};
    mechanics::Mechanism chain = revolute::make_mechanism(scene);
    revolute::FullMatrices full(scene);
    VectorXd q = chain.initial_position(), v = chain.initial_velocity(), a = v, b = v;
    for (int i = 0; i < links; ++i) {
      q[3 * i + 2] += 0.3 * i;
      v[3 * i + 2] = std::sin(i + 1.0);
    }
    chain.project(0.0, q, v);
    chain.acceleration(0.0, q, v, a);
    full.acceleration(q, v, b);
    CHECK((a - b).norm() < 1e-12 * a.norm());
  }
}

TEST_CASE("the table of costs reads back, and its exponent is that of a power law") {
  using revolute::Cost;
  revolute::CostTable costs{{"processor: any"}, {}};
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (const int N : {1, 10, 100, 1000})
    costs.rows.push_back({N, 1e-6 * std::pow(N, 1.5), N < 500 ? 1e-6 * std::pow(N, 3) : none});
  CHECK(revolute::growth(costs, 10, 1000, &Cost::blocks) == Approx(1.5));
  CHECK(revolute::growth(costs, 1, 100, &Cost::full) == Approx(3.0));
  CHECK(std::isnan(revolute::growth(costs, 1, 50, &Cost::blocks)));
  const auto path = std::filesystem::temp_directory_path() / "cost_vs_links_test.csv";
  std::ofstream(path) << revolute::csv(costs);
  const auto read = revolute::read_costs(path);
  CHECK(read.machine == costs.machine);
  REQUIRE(read.rows.size() == 4);
  CHECK(read.rows[2].links == 100);
  CHECK(read.rows[2].blocks == Approx(1e-3));
  CHECK(read.rows[2].full == Approx(1.0));
  CHECK(std::isnan(read.rows[3].full));
  std::filesystem::remove(path);
  CHECK_THROWS_AS(revolute::read_costs(path), std::runtime_error);
}

TEST_CASE("solution 1: struck at two thirds of its length, the pin feels nothing") {
  for (const double at : {0.5, 2.0 / 3.0, 0.9}) {
    const Scene scene{.length = 1.2, .mass = 2.0, .angle0 = pi / 2, .gravity = 0.0};
    Mechanism rod = make_mechanism(scene);
    const double blow = 5.0, lever = (at - 0.5) * scene.length;  // along −x, below the centre
    rod.system.apply(rod.system.thing<Body>("rod"), Vector3d(-blow, 0.0, lever * blow));
    mechanics::Row row;
    row.measures = rod.measures(0.0, rod.initial_position(), rod.initial_velocity());
    rod.observe(0.0, rod.initial_position(), rod.initial_velocity(), row);
    // m L² θ̈/3 = at L · blow about the pin, and m a = −m θ̈ L/2 = pin − blow: so the force of the
    // pin is blow (1 − 3 at/2) against the blow.
    CHECK(row.reactions[0] == Approx(blow * (1.0 - 1.5 * at)).epsilon(0.0).margin(1e-13));
    CHECK(row.reactions[1] == Approx(0.0).margin(1e-13));
  }
}

TEST_CASE(
    "solution 2: the free end of a horizontal double pendulum starts with 6/7 g, of one rod with "
    "3/2 g") {
  // At the release of a horizontal double pendulum: θ̈1 = 9g/7l, θ̈2 = −3g/7l, from
  // 4/3 θ̈1 + 1/2 θ̈2 = 3/2 g/l and 1/2 θ̈1 + 1/3 θ̈2 = 1/2 g/l.
  const Scene scene{.links = 2};
  Mechanism rods = make_mechanism(scene);
  VectorXd a(6);
  rods.acceleration(0.0, rods.initial_position(), rods.initial_velocity(), a);
  CHECK(a[2] == Approx(9.0 / 7.0 * 9.81 / scene.l()).epsilon(1e-13));
  CHECK(a[5] == Approx(-3.0 / 7.0 * 9.81 / scene.l()).epsilon(1e-13));
  // The free end starts down with (9 − 3)/7 g, less than g.
  CHECK(scene.l() * (a[2] + a[5]) == Approx(6.0 / 7.0 * 9.81).epsilon(1e-13));
  Mechanism rod = make_mechanism({});
  a.resize(3);
  rod.acceleration(0.0, rod.initial_position(), rod.initial_velocity(), a);
  CHECK(a[1] + 0.5 * a[2] == Approx(1.5 * 9.81).epsilon(1e-13));
}

TEST_CASE("solution 3: the largest step that a chain allows shrinks as 1/N") {
  const auto energy_error = [](int links, double step) {
    Motion rods = motion({.links = links});
    const double before = rods.measures().energy;
    try {
      rods.advance(std::lround(0.3 / step), step);
    } catch (const mechanics::Diverged&) {
      return std::numeric_limits<double>::infinity();
    }
    return std::abs(rods.measures().energy - before);
  };
  const auto works = [&](int links, double step) { return energy_error(links, step) < 1e-3; };
  for (const auto& [links, step] :
       {std::pair{100, 0.0027}, std::pair{200, 0.0013}, std::pair{300, 0.00085}}) {
    CHECK(works(links, step));
    CHECK_FALSE(works(links, 1.1 * step));
  }
}

namespace {
const measure::RunOptions defaults{.duration = 5.0, .step = 0.005};
}

TEST_CASE("the pictures of the lesson are those that the program draws") {
  picture_check::compare_all("05_revolute", revolute::pictures({}, defaults));
  const auto costs = revolute::read_costs(std::filesystem::path(TUTORIAL_SOURCE) /
                                          "chapters/05_revolute/snapshots/cost_vs_links.csv");
  picture_check::compare("05_revolute", "cost_vs_links",
                         draw::render({.captions = false}, revolute::cost_picture(costs).draw));
}

TEST_CASE("pictures can be drawn of every scene the options allow") {
  for (const Scene& scene :
       {Scene{.links = 40}, Scene{.length = 1e-6}, Scene{.length = 1e6}, Scene{.mass = 1e12},
        Scene{.angle0 = 100.0}, Scene{.angle0 = -pi / 2}, Scene{.gravity = 0.0}}) {
    INFO(scene.links << " " << scene.length << " " << scene.angle0);
    const measure::RunOptions run{.duration = 0.2, .step = 1e-3 * std::sqrt(scene.length)};
    for (const auto& picture :
         revolute::pictures(scene, {.duration = 200 * run.step, .step = run.step}))
      CHECK_NOTHROW(draw::render({.scale = 0.5}, picture.draw));
    CHECK_NOTHROW(
        draw::render({.width = 480, .height = 300},
                     pictures::picture_at(revolute::stage(scene, run), 50 * run.step).draw));
  }
}

TEST_CASE("a chain of any length bears the step that it is given: projected, it keeps its energy") {
  const auto [links, duration] = GENERATE(table<int, double>(
      {{1, 60.0}, {2, 60.0}, {3, 60.0}, {5, 5.0}, {6, 20.0}, {10, 5.0}, {20, 5.0}, {300, 0.5}}));
  INFO(links << " links");
  const Scene scene{.links = links};
  Motion chain = motion(scene, {integrators::Scheme::rk4, Stabilization::projection});
  const double energy = chain.measures().energy, step = std::min(0.005, 0.1 / scene.fastest());
  double most = 0.0, off = 0.0;
  while (chain.time() < duration) {
    chain.advance(std::max(1L, std::lround(0.01 / step)), step);
    const mechanics::Measures now = chain.measures();
    most = std::max(most, now.kinetic);
    off = std::max(off, std::abs(now.energy - energy));
  }
  CHECK(off < 0.01 * most);
}

TEST_CASE("every stiff and extreme case ends as expected, and the map is that of theory") {
  check_stability(revolute::stability());
}
