#include <Eigen/Core>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "allocations.hpp"
#include "catch.hpp"
#include "erratum.hpp"
#include "exact.hpp"
#include "implicit_bead.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/pictures/stage.hpp"
#include "main_check.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "orders.hpp"
#include "picture_check.hpp"
#include "stability_check.hpp"
#include "study.hpp"

using Eigen::Vector2d;
using mechanics::Method;
using mechanics::Motion;
using mechanics::Stabilization;
using parabola::ExactMotion;
using parabola::ImplicitBead;
using parabola::Scene;
using particle_on_curve::AsPrinted;

namespace {

// The second derivation of the exact motion: t as an integral over x itself, in 50 digits.
using Real = boost::multiprecision::cpp_bin_float_50;

/// Time from rest at x0 to x0 + part·(x1 − x0), x1 the other turning point, from the energy
/// integral ½ m q̇² (1 + q²/p²) = V(x0) − V(q). With q = x0 + (x1 − x0) sin²u the root at both ends
/// cancels: V(x0) − V(q) = (m g/2p) (q − x0)(x1 − q).
Real time_to(const Scene& scene, const Real& part) {
  const Real p = scene.p, g = scene.gravity, x0 = scene.x0;
  const Real x1 = 2 * p * Real(scene.force_x) / (Real(scene.mass) * g) - x0;
  const auto dt_du = [&](const Real& u) {
    const Real s = sin(u), q = x0 + (x1 - x0) * s * s;
    return 2 * sqrt(p / g * (1 + q * q / (p * p)));
  };
  const auto integrate = [&](const Real& a, const Real& b) {
    return boost::math::quadrature::gauss_kronrod<Real, 61>::integrate(dt_du, a, b, 14,
                                                                       Real(1e-30));
  };
  const Real end = asin(sqrt(part));
  // Far up the valley dt/du bends sharply where q = 0: cut there.
  const Real zero = x0 / (x0 - x1);
  const Real cut = zero > 0 && zero < part ? asin(sqrt(zero)) : end;
  return integrate(0, cut) + (cut < end ? integrate(cut, end) : Real(0));
}

/// The state at the double nearest to time_to(part) + periods·T, by one Taylor step from the exact
/// point.
struct Reference {
  double t, q;
  double conditioning;  ///< how far q moves when t is rounded [m]
};

Reference reference(const Scene& scene, double part, int periods) {
  const Real p = scene.p, g = scene.gravity, x0 = scene.x0, m = scene.mass, Fx = scene.force_x;
  const Real x1 = 2 * p * Fx / (m * g) - x0;
  const Real q = x0 + Real(part) * (x1 - x0);
  const Real exact_t = 2 * periods * time_to(scene, 1) + time_to(scene, part);
  const double t = static_cast<double>(exact_t);
  const Real speed = sqrt((g / p) * (q - x0) * (x1 - q) / (1 + q * q / (p * p)));
  const Real qdot = x1 > x0 ? speed : -speed;
  const Real qddot = (-q * qdot * qdot - p * g * q + p * p * Fx / m) / (p * p + q * q);
  const Real dt = Real(t) - exact_t;
  return {t, static_cast<double>(q + qdot * dt + qddot * dt * dt / 2),
          static_cast<double>(speed) * t * 1e-16};
}

Motion<ImplicitBead> motion(const Scene& scene, const Method& method = {}) {
  return {ImplicitBead(scene, method.ks, method.kd), method};
}

}  // namespace

TEST_CASE("the exact motion is right to 1e-12 of the start over ten periods, from 1e-3 to 1e3 m") {
  for (const double x0 : {1e-3, -0.7, 3.0, 100.0, 1e3}) {
    const Scene scene{.x0 = x0};
    const ExactMotion exact(scene);
    for (const int periods : {0, 1, 3, 9})
      for (const double part : {0.01, 0.3, 0.5, 0.77, 0.999}) {
        const Reference truth = reference(scene, part, periods);
        INFO("x0 " << x0 << ", t " << truth.t);
        CHECK(std::abs(exact.at(truth.t).q - truth.q) <= 1e-12 * std::abs(x0));
      }
  }
}

TEST_CASE("beyond that the exact motion is as good as the rounding of t allows") {
  for (const double x0 : {1e-3, 100.0, 1e4, 1e6}) {
    const Scene scene{.x0 = x0};
    const ExactMotion exact(scene);
    for (const int periods : {0, 10, 5000})
      for (const double part : {0.1, 0.4999, 0.5, 0.6}) {
        const Reference truth = reference(scene, part, periods);
        INFO("x0 " << x0 << ", t " << truth.t);
        CHECK(std::abs(exact.at(truth.t).q - truth.q) <= 4e-16 * std::abs(x0) + truth.conditioning);
      }
  }
}

TEST_CASE("a horizontal force has its own exact motion") {
  for (const double force_x : {5.0, -30.0, 1e-3})
    for (const double x0 : {100.0, 2.0}) {
      const Scene scene{.x0 = x0, .mass = 2.0, .force_x = force_x};
      const ExactMotion exact(scene);
      for (const int periods : {0, 3})
        for (const double part : {0.05, 0.5, 0.9}) {
          const Reference truth = reference(scene, part, periods);
          INFO("Fx " << force_x << ", x0 " << x0 << ", t " << truth.t);
          CHECK(std::abs(exact.at(truth.t).q - truth.q) <=
                1e-12 * (std::abs(x0) + std::abs(force_x)));
        }
    }
}

TEST_CASE("limits of the exact motion that need no integral") {
  // A small swing is an oscillator, T = 2π √(p/g). Without gravity and force nothing moves; with a
  // force alone and a track that is almost flat, x = Fx t²/2m.
  CHECK(ExactMotion({.x0 = 1e-3}).period() ==
        Approx(2 * std::numbers::pi * std::sqrt(50.0 / 9.81)).epsilon(1e-9));
  CHECK(ExactMotion({.x0 = 7.0, .gravity = 0.0}).at(5.0).q == 7.0);
  const auto pulled = ExactMotion({.x0 = 0.0, .gravity = 0.0, .p = 1e9, .force_x = 3.0}).at(2.0);
  CHECK(pulled.q == Approx(6.0).epsilon(1e-14));
  CHECK(pulled.qdot == Approx(6.0).epsilon(1e-14));
  CHECK(ExactMotion({.x0 = 0.0}).at(3.0).q == 0.0);
}

TEST_CASE("the exact velocity is the derivative of the exact position") {
  for (const double force_x : {0.0, 4.0}) {
    const ExactMotion exact({.force_x = force_x});
    for (const double t : {0.3, 4.0, 9.0, 13.0, 21.0}) {
      const double h = 1e-4;
      CHECK(exact.at(t).qdot ==
            Approx((exact.at(t + h).q - exact.at(t - h).q) / (2 * h)).epsilon(1e-7));
    }
  }
}

TEST_CASE(
    "the constraint force is the one that the curvature asks for, at every point of the motion") {
  for (const double force_x : {0.0, 5.0}) {
    const Scene scene{.mass = 1.5, .force_x = force_x};
    const ImplicitBead bead(scene);
    const ExactMotion exact(scene);
    for (double t = 0.0; t < 24.0; t += 1.7) {
      const auto truth = particle_on_curve::exact(scene, exact, t);
      const Vector2d force = bead.constraint_force(truth.x, truth.v, scene.applied_force());
      CHECK((force - truth.constraint_force).norm() <= 1e-13 * truth.constraint_force.norm());
    }
  }
}

TEST_CASE("any force, anywhere: C̈ + kd Ċ + ks C = 0, and the constraint force lies along ∇C") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-10, 10);
  for (int i = 0; i < 200; ++i) {
    const Scene scene{.mass = 0.1 + std::abs(number(random)), .p = 0.1 + std::abs(number(random))};
    const double ks = i % 2 ? std::abs(number(random)) : 0.0,
                 kd = i % 3 ? std::abs(number(random)) : 0.0;
    const ImplicitBead bead(scene, ks, kd);
    const Vector2d x(number(random), number(random)), v(number(random), number(random)),
        F(number(random), number(random));
    const Vector2d a = (F + bead.constraint_force(x, v, F)) / scene.mass;
    // C along x + v s + a s²/2 is a polynomial: C(s) = C + Ċ s + C̈ s²/2 + …, differentiated by
    // hand.
    const double C = x.x() * x.x() + 2 * scene.p * x.y();
    const double Cdot = 2 * x.x() * v.x() + 2 * scene.p * v.y();
    const double Cddot = 2 * v.x() * v.x() + 2 * x.x() * a.x() + 2 * scene.p * a.y();
    const double scale =
        2 * v.x() * v.x() + std::abs(2 * x.x() * a.x()) + std::abs(2 * scene.p * a.y());
    CHECK(std::abs(Cddot + kd * Cdot + ks * C) <=
          1e-13 * (scale + std::abs(kd * Cdot) + std::abs(ks * C)));
    const Vector2d force = bead.constraint_force(x, v, F);
    CHECK(std::abs(force.x() * 2 * scene.p - force.y() * 2 * x.x()) <=
          1e-13 * force.norm() * bead.gradient(x).norm());
  }
}

TEST_CASE("a force that depends on time and speed leaves the bead on the curve, to order 4") {
  // Drag and a turning force, through the same constraint_force.
  struct Dragged : ImplicitBead {
    using ImplicitBead::ImplicitBead;
    void acceleration(double t, const Vector& x, const Vector& v, Vector& a) const {
      const Vector F = Vector(3 * std::cos(2 * t), 9.81 + 3 * std::sin(2 * t)) - 0.2 * v;
      a = F + constraint_force(x, v, F);
    }
  };
  const auto error = [](double h) {
    Motion<Dragged> bead(Dragged(Scene{.x0 = 10.0}), {});
    bead.advance(std::lround(5.0 / h), h);
    return bead.measures().constraint_error;
  };
  CHECK(error(0.01) < 1e-4);
  CHECK(std::log2(error(0.02) / error(0.01)) == Approx(4.0).margin(0.3));
}

TEST_CASE("the article's printed coefficient is wrong by exactly C̈ = −2x Fx/m") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-10, 10);
  for (int i = 0; i < 50; ++i) {
    const Scene scene{.mass = 0.5 + std::abs(number(random)), .force_x = number(random)};
    const Vector2d F = scene.applied_force(), x(number(random), number(random)),
                   v(number(random), number(random));
    const ImplicitBead bead(scene);
    const auto Cddot = [&](const Vector2d& force) {
      return 2 * v.x() * v.x() + bead.gradient(x).dot(F + force) / scene.mass;
    };
    CHECK(std::abs(Cddot(bead.constraint_force(x, v, F))) <=
          1e-12 * F.norm() * bead.gradient(x).norm());
    CHECK(Cddot(AsPrinted(scene).constraint_force(x, v, F)) ==
          Approx(-2 * x.x() * scene.force_x / scene.mass).epsilon(1e-9));
  }
}

TEST_CASE("a horizontal force exposes the misprint, gravity alone hides it") {
  const auto off = [](double force_x) {
    const Scene scene{.force_x = force_x};
    Motion<AsPrinted> printed(AsPrinted(scene), {});
    Motion<ImplicitBead> right = motion(scene);
    printed.advance(1000, 0.01);
    right.advance(1000, 0.01);
    return std::pair{printed.measures().constraint_error, right.measures().constraint_error};
  };
  CHECK(off(5.0).first > 100.0);
  CHECK(off(5.0).second < 1e-4);
  CHECK(off(0.0).first == Approx(off(0.0).second).epsilon(1e-6));
}

TEST_CASE("the loop in main ends where the exact motion does") {
  const std::string text = printed_by("01_particle_on_curve_implicit");
  CHECK(std::abs(number_after(text, "the bead is at (") - ExactMotion({}).at(20.0).q) < 1e-7);
  CHECK(number_after(text, "error") < 1e-7);
  CHECK(std::abs(number_after(text, "C =")) < 1e-5);
}

TEST_CASE("position, velocity and constraint force converge with the order of the integrator") {
  using enum integrators::Scheme;
  for (const double force_x : {0.0, 5.0}) {
    INFO("Fx " << force_x);
    const Scene scene{.force_x = force_x};
    const measure::Start start = [&](const Method& method) {
      return std::make_unique<Motion<ImplicitBead>>(motion(scene, method));
    };
    const measure::Errors errors = [&](const mechanics::Row& row) {
      return particle_on_curve::errors(scene, row);
    };
    CHECK(check_orders({.methods = {{explicit_euler},
                                    {semi_implicit_euler},
                                    {implicit_midpoint},
                                    {rk4},
                                    {rk4, Stabilization::projection}},
                        .duration = 4.0,
                        .coarsest = 1.0 / 32,
                        .rungs = 9},
                       start, errors, [](const measure::Rung& rung, std::size_t k) {
                         return rung.errors[k] > (k == 2 ? 1e-11 : 1e-10) && rung.step < 0.01;
                       }) > 60);
    if (force_x != 0.0) continue;
    check_order({dop853}, 6.0, 32, start, errors);
    check_order({dop853, Stabilization::projection}, 6.0, 30, start, errors);
  }
}

TEST_CASE("x at t = 20 s is within 1e-8 m of the exact answer with RK4 and a step of 1 ms") {
  // The truth by bisection of the 50-digit integral: 20 s lie in the last quarter of the first
  // period.
  const Scene scene;
  const Real whole = 2 * time_to(scene, 1);
  Real low = 0, high = 1;  // on the way back the motion runs in reverse: t = T − time_to(part)
  for (int i = 0; i < 60; ++i) {
    const Real middle = (low + high) / 2;
    (time_to(scene, middle) < whole - 20 ? low : high) = middle;
  }
  const double truth = static_cast<double>(100 - 200 * low);
  Motion<ImplicitBead> bead = motion(scene);
  bead.advance(20000, 1e-3);
  CHECK(std::abs(bead.q().x() - truth) < 1e-8);
  CHECK(std::abs(ExactMotion(scene).at(20.0).q - truth) < 1e-12);
}

TEST_CASE("projection brings position and velocity back, along ∇C, and leaves a good state alone") {
  const ImplicitBead bead(Scene{});
  for (const double x0 : {-80.0, -1.0, 0.0, 30.0}) {
    const Vector2d on(x0, -x0 * x0 / 100.0), tangent = Vector2d(50.0, -x0).normalized();
    const Vector2d normal(-tangent.y(), tangent.x());
    Vector2d x = on + 0.3 * normal, v = 4.0 * tangent + 0.2 * normal;
    bead.project(0.0, x, v);
    CHECK(std::abs(bead.C(x)) <= 1e-12 * (1 + x0 * x0));
    CHECK(std::abs(bead.gradient(x).dot(v)) <= 1e-12 * bead.gradient(x).norm());
    CHECK((x - on).norm() < 0.1);  // back to where it came from, but for the curve's bend
    CHECK((v - 4.0 * tangent).norm() < 0.05);
    Vector2d again = x, v_again = v;
    bead.project(0.0, again, v_again);
    CHECK((again - x).norm() <= 1e-14 * (1 + x.norm()));
    CHECK((v_again - v).norm() <= 1e-14 * v.norm());
  }
}

TEST_CASE("projection keeps the bead on the curve to rounding, feedback brings it back") {
  Motion<ImplicitBead> projected =
      motion({}, {integrators::Scheme::rk4, Stabilization::projection});
  projected.advance(200, 0.1);
  CHECK(projected.measures().constraint_error < 1e-11);
  CHECK(projected.measures().velocity_error < 1e-11);

  // Started off the curve by C(0), the error must follow its own closed form, critically damped:
  // C(t) = C(0) (1 + kd t/2) exp(−kd t/2).
  struct Off : ImplicitBead {
    using ImplicitBead::ImplicitBead;
    Vector initial_position() const { return ImplicitBead::initial_position() + Vector(0.0, 1.0); }
  };
  Motion<Off> fed(Off(Scene{}, 25.0, 10.0), {});
  fed.advance(1000, 1e-3);
  CHECK(fed.measures().constraint_error == Approx(100.0 * 6.0 * std::exp(-5.0)).epsilon(1e-8));
}

TEST_CASE("without J̇v the constraint gives way by C̈ = 2 vx²") {
  const Scene scene;
  const Vector2d x(30, -9), v(5, -3);
  Vector2d a;
  ImplicitBead({.without_velocity_term = true}).acceleration(0, x, v, a);
  const double Cddot = 2 * v.x() * v.x() + ImplicitBead(scene).gradient(x).dot(a);
  CHECK(Cddot == Approx(2 * 5.0 * 5.0));
}

TEST_CASE("solution 1: the horizontal force that holds the particle at x0 is m g x0/p") {
  const Scene scene{.x0 = 100.0, .mass = 2.0, .force_x = 2.0 * 9.81 * 100.0 / 50.0};
  Motion<ImplicitBead> bead = motion(scene);
  bead.advance(1000, 0.01);
  CHECK((bead.q() - Vector2d(100, -100)).norm() < 1e-10);
}

TEST_CASE("solution 2: at the bottom the curve carries m g (1 + x0²/p²)") {
  for (const double x0 : {10.0, 100.0, 300.0}) {
    const Scene scene{.x0 = x0, .mass = 3.0};
    const double v = std::sqrt(2 * 9.81 * x0 * x0 / 100.0);  // all of the height has become speed
    const Vector2d force =
        ImplicitBead(scene).constraint_force({0, 0}, {v, 0}, scene.applied_force());
    CHECK(force.x() == 0.0);
    CHECK(-force.y() == Approx(3.0 * 9.81 * (1 + x0 * x0 / 2500.0)));
  }
}

TEST_CASE("solution 3: within RK4's bound feedback can still throw off a bead that moves fast") {
  const double ks = 1e5, kd = 2 * std::sqrt(ks);
  const double bound = integrators::largest_stable_step(integrators::Scheme::rk4, ks, kd);
  CHECK(bound * std::sqrt(ks) == Approx(2.785).epsilon(1e-3));
  const auto miss = [&](double h) {  // at the first step at or after 4 s [m]
    Motion<ImplicitBead> bead =
        motion({}, {integrators::Scheme::rk4, Stabilization::feedback, ks, kd});
    bead.advance(std::lround(std::ceil(4.0 / h)), h);
    const double q = ExactMotion({}).at(bead.time()).q;
    return (bead.q() - Vector2d(q, Scene{}.height(q))).norm();
  };
  REQUIRE(0.0087 < bound);
  CHECK(miss(0.0087) > 10.0);
  CHECK(miss(0.005) < 1e-3);
}

TEST_CASE("a step allocates nothing") {
  for (const auto stabilization :
       {Stabilization::none, Stabilization::feedback, Stabilization::projection}) {
    Motion<ImplicitBead> bead = motion({}, {integrators::Scheme::rk4, stabilization, 1.0, 2.0});
    const long before = allocations();
    bead.advance(100, 0.01);
    CHECK(allocations() == before);
  }
}

namespace {

const measure::RunOptions defaults{.duration = 20.0, .step = 0.01};

}  // namespace

TEST_CASE("the pictures of the lesson are those that the program draws") {
  picture_check::compare_all("01_particle_on_curve_implicit",
                             particle_on_curve::pictures({}, defaults));
}

TEST_CASE("pictures can be drawn of every scene the options allow") {
  for (const Scene& scene :
       {Scene{.x0 = 0.0}, Scene{.x0 = -1e-6}, Scene{.x0 = 1e6}, Scene{.gravity = 0.0},
        Scene{.gravity = 0.0, .force_x = 3.0}, Scene{.p = 1e-3, .force_x = -40.0}}) {
    INFO(scene.x0 << " " << scene.gravity << " " << scene.p);
    const measure::RunOptions run{.duration = 1.0, .step = 0.01};
    for (const auto& picture : particle_on_curve::pictures(scene, run))
      CHECK_NOTHROW(draw::render({.scale = 0.5}, picture.draw));
    CHECK_NOTHROW(
        draw::render({.width = 480, .height = 300},
                     pictures::picture_at(particle_on_curve::stage(scene, run), 0.5).draw));
  }
}

TEST_CASE("every stiff and extreme case ends as expected, and the map is that of theory") {
  check_stability(particle_on_curve::stability());
}
