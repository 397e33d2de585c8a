#include <Eigen/Core>
#include <cmath>
#include <random>

#include "01_particle_on_curve_implicit/exact.hpp"
#include "01_particle_on_curve_implicit/implicit_bead.hpp"
#include "allocations.hpp"
#include "catch.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/pictures/stage.hpp"
#include "main_check.hpp"
#include "orders.hpp"
#include "parametric_bead.hpp"
#include "picture_check.hpp"
#include "stability_check.hpp"
#include "study.hpp"

using Eigen::Vector2d;
using mechanics::Method;
using mechanics::Motion;
using parabola::ImplicitBead;
using parabola::Scene;
using parametric_lagrangian::ParametricBead;

namespace {

Motion<ParametricBead> motion(const Scene& scene, const Method& method = {}) {
  return {ParametricBead(scene), method};
}

/// Scenes and states of all sorts.
struct Random {
  std::mt19937 generator{3};
  double operator()() { return std::uniform_real_distribution<double>(-10, 10)(generator); }
  Scene scene() {
    return {.x0 = (*this)(),
            .mass = 0.1 + std::abs((*this)()),
            .gravity = std::abs((*this)()),
            .p = 0.2 + std::abs((*this)()),
            .force_x = (*this)()};
  }
};

}  // namespace

TEST_CASE("the loop in main ends where the exact motion does") {
  const std::string text = printed_by("02_parametric_lagrangian");
  const double exact = parabola::ExactMotion({}).at(20.0).q;
  CHECK(std::abs(number_after(text, "q = ") - exact) < 1e-8);
  CHECK(std::abs(number_after(text, "error")) < 1e-8);
}

TEST_CASE("the equation of motion is Lagrange's: d/dt ∂L/∂q̇ = ∂L/∂q, by finite differences of L") {
  Random number;
  for (int i = 0; i < 100; ++i) {
    const Scene scene = number.scene();
    const double q = number(), qdot = number();
    const auto L = [&](double at, double rate) {
      const auto& [x0, m, g, p, Fx, without] = scene;
      return m * rate * rate * (1 + at * at / (p * p)) / 2 - m * g * at * at / (2 * p) + Fx * at;
    };
    // L is quadratic in q̇ and in q: central differences are exact but for rounding.
    const double h = 0.01;
    const double L_q = (L(q + h, qdot) - L(q - h, qdot)) / (2 * h);
    const double L_vv = (L(q, qdot + h) - 2 * L(q, qdot) + L(q, qdot - h)) / (h * h);
    const double L_vq =
        (L(q + h, qdot + h) - L(q - h, qdot + h) - L(q + h, qdot - h) + L(q - h, qdot - h)) /
        (4 * h * h);
    double qddot = 0;
    ParametricBead(scene).acceleration(0, q, qdot, qddot);
    const double scale = std::abs(L_vv * qddot) + std::abs(L_vq * qdot) + std::abs(L_q);
    CHECK(std::abs(L_vv * qddot + L_vq * qdot - L_q) <= 1e-7 * scale);
  }
}

TEST_CASE("both descriptions have the same acceleration and the same constraint force") {
  Random number;
  for (int i = 0; i < 100; ++i) {
    const Scene scene = number.scene();
    const ParametricBead parametric(scene);
    const ImplicitBead implicit(scene);
    const double q = number(), qdot = number();
    const Vector2d x = parametric.x(q), v = parametric.v(q, qdot);
    double qddot = 0;
    parametric.acceleration(0, q, qdot, qddot);
    Vector2d a;
    implicit.acceleration(0, x, v, a);
    CHECK(qddot == Approx(a.x()).epsilon(1e-10).margin(1e-10));
    const Vector2d force = implicit.constraint_force(x, v, scene.applied_force());
    CHECK((parametric.constraint_force(q, qdot) - force).norm() <= 1e-10 * (1 + force.norm()));
  }
}

TEST_CASE("the particle is on the curve to rounding, whatever the integrator does") {
  for (const auto& scheme : integrators::schemes) {
    Motion<ParametricBead> bead = motion({}, {.integrator = scheme.id});
    for (int i = 0; i < 100; ++i) {
      bead.advance(1, 0.3);
      const double q = bead.q();
      CHECK(bead.measures().constraint_error <= 4e-16 * q * q);
      CHECK(bead.measures().velocity_error <= 1e-15 * (1.0 + std::abs(q * bead.v())));
    }
  }
}

TEST_CASE(
    "q and dq/dt converge with the order of the integrator, with and without a horizontal force") {
  using enum integrators::Scheme;
  for (const double force_x : {0.0, 5.0}) {
    INFO("Fx " << force_x);
    const Scene scene{.force_x = force_x};
    const measure::Start start = [&](const Method& method) {
      return std::make_unique<Motion<ParametricBead>>(motion(scene, method));
    };
    const measure::Errors errors = [&](const mechanics::Row& row) {
      return parametric_lagrangian::errors(scene, row);
    };
    CHECK(check_orders(
              {.methods = {{explicit_euler}, {semi_implicit_euler}, {implicit_midpoint}, {rk4}},
               .duration = 4.0,
               .coarsest = 1.0 / 32,
               .rungs = 9},
              start, errors, [](const measure::Rung& rung, std::size_t k) {
                return rung.errors[k] > 1e-11 && rung.step < 0.01;
              }) > 38);
    if (force_x == 0.0) check_order({dop853}, 5.5, 28, start, errors);
  }
}

TEST_CASE("RK4 keeps the energy that explicit Euler feeds and semi-implicit Euler starves") {
  // The acceleration depends on the velocity here, so semi-implicit Euler is not symplectic in q:
  // the bounded energy error that it is known for is gone.
  const auto energy = [](integrators::Scheme name) {
    Motion<ParametricBead> bead = motion({}, {.integrator = name});
    bead.advance(10000, 0.02);
    return bead.measures().energy;
  };
  const double start = motion({}).measures().energy;
  CHECK(start == Approx(1.0 * 9.81 * 100.0));  // m g h
  CHECK(energy(integrators::Scheme::explicit_euler) > 1.1 * start);
  CHECK(energy(integrators::Scheme::semi_implicit_euler) < 0.9 * start);
  CHECK(std::abs(energy(integrators::Scheme::rk4) - start) < 1e-4 * start);
}

TEST_CASE("solution 1: a small swing is an oscillator of frequency √(g/p)") {
  const Scene scene{.x0 = 1e-3};
  Motion<ParametricBead> bead = motion(scene);
  bead.advance(10000, 1e-3);
  CHECK(bead.q() == Approx(1e-3 * std::cos(std::sqrt(9.81 / 50.0) * 10.0)).epsilon(1e-8));
}

TEST_CASE("solution 2: the generalised momentum changes by the generalised force and ∂T/∂q") {
  // p_q = m q̇ (1 + q²/p²); its rate along the motion against ∂L/∂q = m q q̇²/p² − m g q/p.
  const double h = 1e-3;
  Motion<ParametricBead> bead = motion({});
  const auto momentum = [&] { return bead.v() * (1 + bead.q() * bead.q() / 2500.0); };
  bead.advance(4000, h);
  const double before = momentum();
  bead.advance(1, h);
  const double q = bead.q(), qdot = bead.v();
  bead.advance(1, h);
  CHECK((momentum() - before) / (2 * h) ==
        Approx(q * qdot * qdot / 2500.0 - 9.81 * q / 50.0).epsilon(1e-5));
}

TEST_CASE("solution 3: the length along the wire has a constant inertia, and no formula for q") {
  // m ℓ̈ = −m g dH/dℓ with H = q²/2p; q(ℓ) is found by Newton's method at each evaluation.
  const double p = 50.0, g = 9.81;
  const auto length = [&](double q) {
    return 0.5 * (q * std::sqrt(1 + q * q / (p * p)) + p * std::asinh(q / p));
  };
  const auto q_at = [&](double l) {
    double q = l;
    for (int i = 0; i < 50; ++i) q -= (length(q) - l) / std::sqrt(1 + q * q / (p * p));
    return q;
  };
  double l = length(100.0), rate = 0.0;
  integrators::Integrator<double> rk4(integrators::Scheme::rk4, l);
  const auto acceleration = [&](double, double place, double, double& a) {
    const double slope = q_at(place) / p;
    a = -g * slope / std::sqrt(1 + slope * slope);
  };
  for (int i = 0; i < 1000; ++i) rk4.step(acceleration, 0.0, l, rate, 0.01);
  CHECK(q_at(l) == Approx(parabola::ExactMotion({}).at(10.0).q).epsilon(1e-7));
}

TEST_CASE("a step allocates nothing") {
  Motion<ParametricBead> bead = motion({});
  const long before = allocations();
  bead.advance(100, 0.01);
  CHECK(allocations() == before);
}

namespace {
const measure::RunOptions defaults{.duration = 20.0, .step = 0.01};
}

TEST_CASE("the pictures of the lesson are those that the program draws") {
  picture_check::compare_all("02_parametric_lagrangian",
                             parametric_lagrangian::pictures({}, defaults));
}

TEST_CASE("pictures can be drawn of every scene the options allow") {
  for (const Scene& scene :
       {Scene{.x0 = 0.0}, Scene{.x0 = 1e6}, Scene{.gravity = 0.0, .force_x = 3.0},
        Scene{.p = 1e-3, .force_x = -40.0}}) {
    const measure::RunOptions run{.duration = 1.0, .step = 0.01};
    for (const auto& picture : parametric_lagrangian::pictures(scene, run))
      CHECK_NOTHROW(draw::render({.scale = 0.5}, picture.draw));
    CHECK_NOTHROW(
        draw::render({.width = 480, .height = 300},
                     pictures::picture_at(parametric_lagrangian::stage(scene, run), 0.5).draw));
  }
}

TEST_CASE("every stiff and extreme case ends as expected, and the map is that of theory") {
  check_stability(parametric_lagrangian::stability());
}
