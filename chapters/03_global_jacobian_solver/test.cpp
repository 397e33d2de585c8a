#include <Eigen/Core>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "01_particle_on_curve_implicit/exact.hpp"
#include "01_particle_on_curve_implicit/implicit_bead.hpp"
#include "allocations.hpp"
#include "catch.hpp"
#include "exact.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/pictures/stage.hpp"
#include "main_check.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanism.hpp"
#include "orders.hpp"
#include "picture_check.hpp"
#include "stability_check.hpp"
#include "study.hpp"
#include "turned_off.hpp"

using dumbbell::Exact;
using dumbbell::ExactMotion;
using dumbbell::OneBead;
using dumbbell::OneByOne;
using dumbbell::Scene;
using Eigen::Vector2d;
using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<mechanics::Mechanism>;

namespace {

Motion motion(const Scene& scene, const Method& method = {}) {
  return {dumbbell::make_mechanism(scene, method), method};
}

// The second derivation of the exact motion, in 50 digits and in another coordinate: φ, the angle
// of the rod. The beads stand at p tan φ ∓ (L/2) cos φ; energies are plain sums over the beads, all
// derivatives of positions are taken by the chain rule from these two lines.
using Real = boost::multiprecision::cpp_bin_float_50;

struct ByAngle {
  explicit ByAngle(const Scene& s) : scene(s), p(s.p) {
    const Real x1 = s.x1, x2 = s.x2, slope = (x1 + x2) / (2 * p);
    L = (x2 - x1) * sqrt(1 + slope * slope);
    phi0 = atan(slope);
  }
  Real x(const Real& phi, int side) const { return p * tan(phi) + side * L / 2 * cos(phi); }
  Real dx(const Real& phi, int side) const {
    return p / (cos(phi) * cos(phi)) - side * L / 2 * sin(phi);
  }
  Real V(const Real& phi) const {
    const Real a = x(phi, -1), b = x(phi, 1);
    return Real(scene.gravity) * (Real(scene.m1) * a * a + Real(scene.m2) * b * b) / (2 * p);
  }
  Real inertia(const Real& phi) const {
    const auto part = [&](double m, int side) {
      const Real slope = x(phi, side) / p, rate = dx(phi, side);
      return Real(m) * rate * rate * (1 + slope * slope);
    };
    return part(scene.m1, -1) + part(scene.m2, 1);
  }
  /// The other turning point: V falls away from φ0, and there it is back. Walks, then bisects.
  void find_turning_point() {
    const Real tiny = 1e-12;
    const int way = V(phi0 + tiny) < V(phi0) ? 1 : -1;
    Real low = phi0 + way * tiny, high = low;
    for (Real step = 1e-9; V(high) < V(phi0); step = step < 1e-3 ? Real(1.1 * step) : step) {
      low = high;
      high += way * step;
    }
    for (int i = 0; i < 180; ++i) {
      const Real middle = (low + high) / 2;
      (V(middle) < V(phi0) ? low : high) = middle;
    }
    phi1 = (low + high) / 2;
  }
  /// Time from rest at φ0 to φ0 + part·(φ1 − φ0), with φ = φ0 + (φ1 − φ0) sin²w. V(φ0) − V(φ) is a
  /// plain difference: with 50 digits there are enough left.
  Real time_to(const Real& part) const {
    const Real way = phi1 - phi0;
    const auto dt_dw = [&](const Real& w) -> Real {
      const Real s = sin(w), phi = phi0 + way * s * s;
      return abs(way) * sin(2 * w) * sqrt(inertia(phi) / (2 * (V(phi0) - V(phi))));
    };
    return boost::math::quadrature::gauss_kronrod<Real, 61>::integrate(
        dt_dw, Real(0), Real(asin(sqrt(part))), 12, Real(1e-26));
  }

  Scene scene;
  Real p, L, phi0, phi1;
};

/// Where the beads are at the double nearest to a time, by a Taylor step from a part of the way.
struct Reference {
  double t, x1, x2;
};

Reference reference(const ByAngle& way, double part, const Real& exact_t) {
  const Real phi = way.phi0 + Real(part) * (way.phi1 - way.phi0);
  const double t = static_cast<double>(exact_t);
  const Real speed = sqrt(2 * (way.V(way.phi0) - way.V(phi)) / way.inertia(phi));
  const Real late = (Real(t) - exact_t) * (way.phi1 > way.phi0 ? speed : -speed);
  return {t, static_cast<double>(way.x(phi, -1) + way.dx(phi, -1) * late),
          static_cast<double>(way.x(phi, 1) + way.dx(phi, 1) * late)};
}

}  // namespace

TEST_CASE("the loop in main ends where the exact motion does") {
  const std::string text = printed_by("03_global_jacobian_solver");
  const Exact exact = dumbbell::ExactMotion({}).at(20.0);
  CHECK(std::abs(number_after(text, "bead1 is at (") - exact.x1.x()) < 1e-7);
  CHECK(number_after(text, "error") < 1e-7);
  CHECK(number_after(text, "largest |C|") < 1e-11);
}

TEST_CASE("the exact motion agrees with a second derivation, over many swings") {
  // The last three: a rod so long that its level place is the top of a hill, with a well on each
  // side; in one well, in the other, and over the hill.
  for (const Scene& scene :
       {Scene{}, Scene{.x1 = 60, .x2 = -20, .m1 = 3}, Scene{.x1 = 400, .x2 = 410, .m2 = 1e-3},
        Scene{.x1 = -1e-3, .x2 = 2e-3, .m2 = 1}, Scene{.x1 = -140, .x2 = 160, .m2 = 1},
        Scene{.x1 = -90, .x2 = 220, .m2 = 1.1}, Scene{.x1 = -40, .x2 = 400, .m2 = 1.1}}) {
    ByAngle way(scene);
    way.find_turning_point();
    const ExactMotion exact(scene);
    const double size = std::max(std::abs(scene.x1), std::abs(scene.x2));
    const Real period = 2 * way.time_to(1);
    CHECK(exact.period() == Approx(static_cast<double>(period)).epsilon(1e-14));
    for (const double part : {0.01, 0.3, 0.5, 0.8, 0.999}) {
      const Real first = way.time_to(part);
      for (const int periods : {0, 1, 30}) {
        const Reference truth = reference(way, part, periods * period + first);
        const Exact at = exact.at(truth.t);
        INFO("x1 " << scene.x1 << ", x2 " << scene.x2 << ", t " << truth.t);
        CHECK(std::abs(at.x1.x() - truth.x1) <= 2e-15 * size * (1 + periods));
        CHECK(std::abs(at.x2.x() - truth.x2) <= 2e-15 * size * (1 + periods));
      }
    }
  }
}

TEST_CASE("limits of the exact motion that need no integral") {
  // Equal masses, level rod: at rest for ever. Without gravity as well.
  CHECK(ExactMotion({.x1 = -3, .x2 = 3, .m2 = 1}).at(7.0).x2 == Vector2d(3, -0.09));
  CHECK(ExactMotion({.gravity = 0}).at(7.0).x1 == Vector2d(20, -4));
  // A light bead2 close by: bead1 moves as alone, as chapter 1 has it.
  const parabola::ExactMotion alone({.x0 = 20.0});
  for (const double t : {1.0, 5.0, 12.0})
    CHECK(ExactMotion({.x1 = 20, .x2 = 20.5, .m2 = 1e-9}).at(t).x1.x() ==
          Approx(alone.at(t).q).epsilon(1e-8));
  // A short rod near the bottom swings as an oscillator of frequency √(g/p).
  CHECK(ExactMotion({.x1 = 0.01, .x2 = 0.02}).period() ==
        Approx(2 * std::numbers::pi * std::sqrt(50.0 / 9.81)).epsilon(1e-6));
}

TEST_CASE("the exact forces are what the exact motion needs, and each acts only along its joint") {
  for (const Scene& scene : {Scene{}, Scene{.x1 = 60, .x2 = -20, .m1 = 3}}) {
    const ExactMotion exact(scene);
    const double h = 1e-3;
    for (const double t : {0.5, 2.0, 4.5, 8.0, 13.0}) {
      const Exact at = exact.at(t), before = exact.at(t - h), after = exact.at(t + h);
      const Vector2d weight(0, scene.gravity);
      const auto close = [](const Vector2d& a, const Vector2d& b) {
        return (a - b).norm() <= 1e-5 * (1 + b.norm());
      };
      CHECK(close((after.x1 - before.x1) / (2 * h), at.v1));
      CHECK(close((after.x2 - before.x2) / (2 * h), at.v2));
      const Vector2d a1 = (after.v1 - before.v1) / (2 * h), a2 = (after.v2 - before.v2) / (2 * h);
      CHECK(close(scene.m1 * (a1 - weight), at.curve1 + at.rod1));
      CHECK(close(scene.m2 * (a2 - weight), at.curve2 - at.rod1));
      CHECK(std::abs(at.curve1.dot(Vector2d(scene.p, -at.x1.x()))) < 1e-10);
      CHECK(std::abs(at.curve2.dot(Vector2d(scene.p, -at.x2.x()))) < 1e-10);
      const Vector2d d = at.x2 - at.x1;
      CHECK(std::abs(at.rod1.x() * d.y() - at.rod1.y() * d.x()) < 1e-10);
      CHECK(d.norm() == Approx(scene.rod()).epsilon(1e-14));
    }
  }
}

TEST_CASE("the rod pushes the beads apart all the way, with 1.6 N to 5.8 N, as the lesson says") {
  const ExactMotion exact({});
  double least = 1e300, most = -1e300;
  for (int i = 0; i <= 1000; ++i) {
    const Exact at = exact.at(exact.period() * i / 1000);
    const double push = -at.rod1.dot((at.x2 - at.x1).normalized());
    least = std::min(least, push);
    most = std::max(most, push);
  }
  CHECK(least == Approx(1.6).margin(0.05));
  CHECK(most == Approx(5.8).margin(0.05));
}

TEST_CASE("the global solver returns chapter 1's force and lambda to 1e-12, in every state") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-10, 10);
  for (int i = 0; i < 200; ++i) {
    const parabola::Scene scene{.x0 = number(random),
                                .mass = 0.1 + std::abs(number(random)),
                                .gravity = std::abs(number(random)),
                                .p = 0.1 + std::abs(number(random)),
                                .force_x = i % 2 ? number(random) : 0.0};
    const double ks = i % 3 ? std::abs(number(random)) : 0,
                 kd = i % 3 ? std::abs(number(random)) : 0;
    const parabola::ImplicitBead formula(scene, ks, kd);
    OneBead solver(scene, {.stabilization = Stabilization::feedback, .ks = ks, .kd = kd});
    const Vector2d x(number(random), number(random)), v(number(random), number(random));
    const Vector2d force = formula.constraint_force(x, v, scene.applied_force());
    const double lambda = force.dot(formula.gradient(x)) / formula.gradient(x).squaredNorm();
    // The parts of the numerator can cancel: 1e-12 is relative to the largest of them.
    const double parts = (2 * scene.mass * v.x() * v.x() +
                          formula.gradient(x).cwiseAbs().dot(scene.applied_force().cwiseAbs()) +
                          scene.mass * (ks * std::abs(formula.C(x)) +
                                        kd * formula.gradient(x).cwiseAbs().dot(v.cwiseAbs()))) /
                         formula.gradient(x).squaredNorm();
    const OneBead::Answer answer = solver.solve(x, v);
    CHECK(std::abs(answer.lambda - lambda) <= 1e-12 * parts);
    CHECK((answer.force - force).norm() <= 1e-12 * parts * formula.gradient(x).norm());
  }
}

TEST_CASE("and over chapter 1's own motion to 1e-12 of the force, without cancellation") {
  const parabola::Scene scene;
  mechanics::Motion<parabola::ImplicitBead> bead(parabola::ImplicitBead(scene), {});
  OneBead solver(scene), mover(scene);
  Motion moved(std::move(mover.mechanism), {});
  for (int i = 0; i < 2000; ++i) {
    const Vector2d force = bead.model().constraint_force(bead.q(), bead.v(), scene.applied_force());
    const OneBead::Answer answer = solver.solve(bead.q(), bead.v());
    REQUIRE((answer.force - force).norm() <= 1e-12 * force.norm());
    const double lambda = force.y() / (2 * scene.p);
    REQUIRE(std::abs(answer.lambda - lambda) <= 1e-12 * std::abs(lambda));
    bead.advance(1, 0.01);
    moved.advance(1, 0.01);
  }
  CHECK((moved.q() - Eigen::VectorXd(bead.q())).norm() < 1e-9);
}

TEST_CASE("the lambdas are those of the exact forces") {
  const Scene scene;
  dumbbell::Parts parts;
  mechanics::Mechanism mechanism = dumbbell::make_mechanism(scene, {}, &parts);
  const ExactMotion exact(scene);
  Eigen::VectorXd q(4), v(4), a(4);
  for (double t = 0.0; t < 20.0; t += 1.3) {
    const Exact at = exact.at(t);
    q << at.x1, at.x2;
    v << at.v1, at.v2;
    mechanism.acceleration(t, q, v, a);
    const auto lambda = [&](dynamics::JointHandle j) {
      return mechanism.evaluation().lambda(j)[0];
    };
    CHECK(lambda(parts.bead1_curve) == Approx(at.curve1.y() / (2 * scene.p)).epsilon(1e-12));
    CHECK(lambda(parts.bead2_curve) == Approx(at.curve2.y() / (2 * scene.p)).epsilon(1e-12));
    // The rod's force on bead1 is −λ d.
    CHECK(lambda(parts.bead1_bead2) ==
          Approx(-at.rod1.dot(at.x2 - at.x1) / std::pow(scene.rod(), 2)).epsilon(1e-11));
  }
}

TEST_CASE("the counts are those of a hand: 4 coordinates, 3 rows, 1 degree of freedom, no angles") {
  Motion beads = motion({});
  beads.row();
  const dynamics::Counts counts = beads.model().evaluation().counts();
  CHECK(counts.things == 2);
  CHECK(counts.coordinates == 4);  // two particles, x and y each
  CHECK(counts.rows == 3);
  CHECK(counts.rank == 3);
  CHECK(counts.degrees_of_freedom == 1);
  CHECK(counts.jacobian_blocks == 4);  // one for each curve, two for the rod
  CHECK(counts.factor_blocks == 5);    // three on the diagonal, the rod with each curve
  for (const std::string& name : beads.columns().state)
    CHECK(name.find("theta") == std::string::npos);
  OneBead one{parabola::Scene{}};
  CHECK(one.mechanism.system.rows() == 1);
  CHECK(one.mechanism.initial_position().size() == 2);
}

TEST_CASE("the tables name two beads and three joints") {
  const mechanics::Columns columns = motion({}).columns();
  CHECK(columns.state == std::vector<std::string>{"bead1.x", "bead1.y", "bead1.vx", "bead1.vy",
                                                  "bead2.x", "bead2.y", "bead2.vx", "bead2.vy"});
  REQUIRE(columns.reactions.size() == 9);
  CHECK(columns.reactions[0] == "bead1_curve.fx");
  CHECK(columns.reactions[4] == "bead2_curve.fy");
  CHECK(columns.reactions[8] == "bead1_bead2.moment");
}

TEST_CASE("J at the start is 2x, 2p for each curve and −d, d for the rod") {
  mechanics::Mechanism mechanism = dumbbell::make_mechanism({}, {});
  Eigen::MatrixXd expected(3, 4);
  expected << 40, 100, 0, 0,  //
      0, 0, 120, 100,         //
      -40, 32, 40, -32;       // d = (60 − 20, −36 + 4)
  Eigen::VectorXd a(4);
  mechanism.acceleration(0, mechanism.initial_position(), mechanism.initial_velocity(), a);
  CHECK((mechanism.evaluation().jacobian() - expected).norm() < 1e-12);
}

TEST_CASE("positions, velocities and forces converge with the order of the integrator") {
  using enum integrators::Scheme;
  const Scene scene;
  const measure::Start start = [&](const Method& method) {
    return std::make_unique<Motion>(motion(scene, method));
  };
  const measure::Errors errors = [&](const mechanics::Row& row) {
    return dumbbell::errors(scene, row);
  };
  CHECK(check_orders({.methods = {{explicit_euler},
                                  {semi_implicit_euler},
                                  {implicit_midpoint},
                                  {rk4},
                                  {rk4, Stabilization::feedback, 1.0, 2.0},
                                  {rk4, Stabilization::projection}},
                      .duration = 4.0,
                      .coarsest = 1.0 / 16,
                      .rungs = 10},
                     start, errors, [](const measure::Rung& rung, std::size_t k) {
                       return rung.errors[k] > 1e-10 && rung.step < 1.0 / 60;
                     }) > 60);
  check_order({dop853}, 4.0, 8, start, errors);
  check_order({dop853, Stabilization::projection}, 4.0, 8, start, errors);
}

TEST_CASE("RK4 with a step of 1 ms is within 1e-10 of the exact answer after 20 s") {
  Motion beads = motion({});
  beads.advance(20000, 1e-3);
  for (const double error : dumbbell::errors({}, beads.row())) CHECK(error < 1e-10);
}

TEST_CASE("energy is conserved: the three forces together do no work") {
  for (const Scene& scene : {Scene{}, Scene{.x1 = 60, .x2 = -20, .m1 = 3}}) {
    Motion beads = motion(scene);
    const double start = beads.measures().energy;
    CHECK(start == Approx(scene.gravity *
                          (scene.m1 * scene.x1 * scene.x1 + scene.m2 * scene.x2 * scene.x2) / 100));
    for (int i = 0; i < 20; ++i) {
      beads.advance(1000, 1e-3);
      const mechanics::Measures now = beads.measures();
      CHECK(now.energy == Approx(start).epsilon(1e-12));
      CHECK(now.constraint_error < 1e-9);
    }
  }
}

TEST_CASE("forces do no work in any state that the constraints allow") {
  const ExactMotion exact({});
  Motion beads = motion({});
  for (int i = 0; i < 40; ++i) {
    beads.advance(37, 0.01);
    const mechanics::Row row = beads.row();
    double power = 0.0, size = 0.0;
    for (const auto& [force, velocity, sign] :
         {std::tuple{0, 2, 1}, {3, 6, 1}, {6, 2, 1}, {6, 6, -1}})
      for (int k = 0; k < 2; ++k) {
        const double part = sign * row.reactions[static_cast<std::size_t>(force + k)] *
                            row.state[static_cast<std::size_t>(velocity + k)];
        power += part;
        size += std::abs(part);
      }
    CHECK(std::abs(power) <= 1e-8 * size);
  }
}

TEST_CASE("projection holds all three constraints to rounding") {
  Motion beads = motion({}, {.stabilization = Stabilization::projection});
  for (int i = 0; i < 100; ++i) {
    beads.advance(1, 0.1);
    CHECK(beads.measures().constraint_error < 2e-11);  // of terms of 1e4 m²
    CHECK(beads.measures().velocity_error < 2e-11);
  }
}

TEST_CASE("feedback brings a displaced dumbbell back by C̈ + kd Ċ + ks C = 0, each row alike") {
  dumbbell::Parts parts;
  const double ks = 25.0, kd = 10.0;
  mechanics::Mechanism mechanism = dumbbell::make_mechanism(
      {}, {.stabilization = Stabilization::feedback, .ks = ks, .kd = kd}, &parts);
  const auto C = [](const Eigen::VectorXd& q) {
    const double l2 = std::pow(Scene{}.rod(), 2);
    return Eigen::Vector3d(q[0] * q[0] + 100 * q[1], q[2] * q[2] + 100 * q[3],
                           ((q.tail<2>() - q.head<2>()).squaredNorm() - l2) / 2);
  };
  Eigen::VectorXd q = mechanism.initial_position() + Eigen::Vector4d(0.1, -0.2, 0.05, 0.1);
  Eigen::VectorXd v = Eigen::VectorXd::Zero(4), a(4);
  const Eigen::Vector3d C0 = C(q);
  integrators::Rk4<Eigen::VectorXd> rk4(q);
  const auto acceleration = [&](double t, const auto& x, const auto& xdot, auto& out) {
    mechanism.acceleration(t, x, xdot, out);
  };
  for (int i = 0; i < 1000; ++i) rk4.step(acceleration, 0.0, q, v, 1e-3);
  const Eigen::Vector3d expected = C0 * 6.0 * std::exp(-5.0);  // C0 (1 + kd t/2) exp(−kd t/2)
  CHECK((C(q) - expected).norm() < 1e-8 * C0.norm());
}

TEST_CASE("one by one, the first step already breaks the rod by its coupling with the curves") {
  // By hand: each force keeps its own C̈, and J W Jᵀ beside the diagonal passes on the rest.
  const Scene scene;
  OneByOne apart(scene);
  Eigen::VectorXd a(4);
  apart.acceleration(0.0, apart.initial_position(), Eigen::VectorXd::Zero(4), a);
  const double g = 9.81;
  const double l1 = -100 * g / (1600.0 + 10000.0), l2 = -100 * g / ((14400.0 + 10000.0) / 2);
  // Row of the rod times W F is 32 g − 32 g = 0: alone, the rod has nothing to do.
  const double stretch = l1 * (-40 * 40 + 32 * 100) + l2 / 2 * (40 * 120 - 32 * 100);
  const Eigen::VectorXd rod = Eigen::Vector4d(-40, 32, 40, -32);
  CHECK(rod.dot(a) == Approx(stretch));
  CHECK(std::abs(stretch) > 1.0);

  mechanics::Motion<OneByOne> loose(OneByOne(scene), {});
  loose.advance(300, 0.01);
  CHECK(loose.measures().constraint_error > 10.0);
}

TEST_CASE("a rod without a length is refused, naming the option") {
  for (const Scene& scene :
       {Scene{.x1 = 20, .x2 = 20}, Scene{.x1 = 0, .x2 = 0}, Scene{.x1 = 1e3, .x2 = 1e3 + 1e-4}}) {
    CHECK_THROWS_AS(dumbbell::make_mechanism(scene, {}), std::invalid_argument);
    try {
      dumbbell::make_mechanism(scene, {});
    } catch (const std::invalid_argument& error) {
      CHECK(std::string(error.what()).starts_with("x2 "));
      CHECK(std::string(error.what()).find('\n') == std::string::npos);
    }
  }
  CHECK_NOTHROW(dumbbell::make_mechanism({.x1 = 0, .x2 = 1e-9}, {}));
}

TEST_CASE("solution 1: equal beads on a level rod stay, and the rod carries m g a/p") {
  // Each curve's force must carry the weight, so it is (m g x/p, −m g): the rod takes the rest.
  const double a = 30.0;
  Motion beads = motion({.x1 = -a, .x2 = a, .m1 = 2, .m2 = 2});
  beads.advance(500, 0.01);
  const mechanics::Row row = beads.row();
  CHECK(std::abs(row.state[0] + a) < 1e-9);
  CHECK(row.reactions[1] == Approx(-2 * 9.81));
  CHECK(row.reactions[6] == Approx(-2 * 9.81 * a / 50.0));  // on bead1, to the left: a push
}

TEST_CASE("solution 2: a level rod longer than 2p between equal beads is not stable") {
  // For a small slope σ, V = M g p/2 (σ² + l²/4p² (1 − σ²)): its bend changes sign at l = 2p.
  const auto strays = [](double half) {
    const ExactMotion exact({.x1 = -half, .x2 = half + 1e-6, .m1 = 1, .m2 = 1});
    return std::abs(exact.at(0.5 * exact.period()).x2.x() - half);
  };
  CHECK(strays(49.0) < 1e-3);
  CHECK(strays(51.0) > 1.0);
}

TEST_CASE(
    "solution 3: three beads and two rods have 5 rows, 6 columns, 7 blocks of J, 10 of J W Jᵀ") {
  const Scene scene;
  dynamics::System system;
  const joints::OnCurve<joints::Parabola> curve{{scene.p}};
  dynamics::Handle<dynamics::Particle> last;
  for (const double x : {20.0, 60.0, 90.0}) {
    const std::string number = fmt::format("{}", x);
    const auto bead = system.add_particle("bead" + number, 1.0, scene.on_curve(x));
    system.add("curve" + number, curve, bead);
    if (last.index >= 0) {
      const double length = (scene.on_curve(x) - system.initial_q().segment<2>(last.column)).norm();
      system.add("rod" + number, joints::Distance{.length = length}, last, bead);
    }
    last = bead;
  }
  system.set_gravity({0, scene.gravity});
  dynamics::Evaluation e(system);
  system.evaluate(0.0, system.initial_q(), system.initial_v(), e);
  const dynamics::Counts counts = e.counts();
  CHECK(counts.rows == 5);
  CHECK(counts.coordinates == 6);
  CHECK(counts.degrees_of_freedom == 1);
  CHECK(counts.jacobian_blocks == 7);
  CHECK(counts.factor_blocks == 10);
}

TEST_CASE("a step allocates nothing") {
  for (const auto stabilization :
       {Stabilization::none, Stabilization::feedback, Stabilization::projection}) {
    Motion beads = motion({}, {integrators::Scheme::rk4, stabilization, 1.0, 2.0});
    beads.advance(1, 0.01);
    const long before = allocations();
    beads.advance(100, 0.01);
    CHECK(allocations() == before);
  }
}

namespace {
const measure::RunOptions defaults{.duration = 20.0, .step = 0.01};
}

TEST_CASE("the pictures of the lesson are those that the program draws") {
  picture_check::compare_all("03_global_jacobian_solver", dumbbell::pictures({}, defaults));
}

TEST_CASE("pictures can be drawn of every scene the options allow") {
  for (const Scene& scene : {Scene{.x1 = 0.0}, Scene{.x1 = 60, .x2 = 20}, Scene{.gravity = 0.0},
                             Scene{.x1 = -1e6, .x2 = 1e6}, Scene{.x1 = 1e-9, .x2 = 0.0},
                             Scene{.p = 1e-3}, Scene{.m1 = 1e-12, .m2 = 1e12}, Scene{.p = 1e12}}) {
    INFO(scene.x1 << " " << scene.x2 << " " << scene.gravity << " " << scene.p);
    const measure::RunOptions run{.duration = 1.0, .step = 0.01};
    for (const auto& picture : dumbbell::pictures(scene, run))
      CHECK_NOTHROW(draw::render({.scale = 0.5}, picture.draw));
    CHECK_NOTHROW(draw::render({.width = 480, .height = 300},
                               pictures::picture_at(dumbbell::stage(scene, run), 0.5).draw));
  }
}

TEST_CASE("every stiff and extreme case ends as expected, and the map is that of theory") {
  check_stability(dumbbell::stability());
}
