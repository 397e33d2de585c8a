// Constraints that depend on time: the driver, and a rail that turns by itself, whose J depends on
// time too. Against finite differences, closed forms, and the same scene in other frames.
#include <array>
#include <cmath>
#include <vector>

#include "allocations.hpp"
#include "catch.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/joints/driver.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"
#include "mechanics/motion/watch.hpp"
#include "random.hpp"

using namespace dynamics;
using Eigen::Vector2d;
using Eigen::VectorXd;
using integrators::Scheme;
using joints::Driver;
using joints::Given;
using mechanics::Mechanism;
using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<Mechanism>;

namespace {

double random_number(double size = 1) {
  return std::uniform_real_distribution<double>(-size, size)(generator);
}
Body random_body() {
  const double theta = random_number(4);
  return {{random_number(3), random_number(3)},
          {random_number(), random_number()},
          theta,
          random_number(3),
          rotation(theta)};
}

/// Some function with all derivatives, and the same with a constant added.
struct Swing {
  double phase = 0.3, added = 0;
  Given operator()(double t) const {
    return {added + std::sin(2 * t + phase) + t * t, 2 * std::cos(2 * t + phase) + 2 * t,
            -4 * std::sin(2 * t + phase) + 2};
  }
};
/// The opposite of a function.
template <class F>
struct Minus {
  F f;
  Given operator()(double t) const {
    const Given given = f(t);
    return {-given.f, -given.f_dot, -given.f_ddot};
  }
};

/// A rail through the origin that turns at w: a bead stays on n(t).x = 0. J = n^T depends on time
/// alone, so Jdot_v = 0, C_t = n'.x, and what else Cddot has is 2 n'.v + n''.x.
struct TurningRail {
  static constexpr std::array unit{"m"};
  double w;

  Rows<1, Particle, World> rows(double t, const Particle& bead, const World&) const {
    using Row = Eigen::Vector<double, 1>;
    const Vector2d n(-std::sin(w * t), std::cos(w * t)), n_t = w * S(n), n_tt = -w * w * n;
    return {.C = Row(n.dot(bead.x)),
            .J1 = n.transpose(),
            .J2 = {},
            .Jdot_v = Row(0),
            .size = Row(bead.x.lpNorm<1>()),
            .C_t = Row(n_t.dot(bead.x)),
            .C_tt = Row(2 * n_t.dot(bead.v) + n_tt.dot(bead.x))};
  }
};

/// A bead of 2 kg on that rail, at rest on it 1 m from its middle.
constexpr double w = 1.5, mass = 2.0;
Mechanism bead_on_rail(const Method& method) {
  Mechanism mechanism(method);
  const auto bead = mechanism.system.add_particle("bead", mass, {1, 0}, {0, w});
  mechanism.report("bead_world", mechanism.system.add("bead_world", TurningRail{w}, bead), bead);
  mechanism.assemble();
  return mechanism;
}

/// A wheel of 0.5 kg m^2 that is told f, and nothing else.
template <class F>
Mechanism wheel_told(const F& f, const Method& method) {
  Mechanism mechanism(method);
  const auto wheel =
      mechanism.system.add_body("wheel", 1.0, 0.5, {0, 0}, f(0.0).f, {0, 0}, f(0.0).f_dot);
  mechanism.system.add("wheel_world", joints::Revolute{}, wheel);
  mechanism.report("wheel_driver", mechanism.system.add("wheel_driver", Driver{f}, wheel), wheel);
  mechanism.assemble();
  return mechanism;
}

}  // namespace

TEST_CASE("a driver: C, J, C_t and C_tt against finite differences in state and in time") {
  constexpr double h = 1e-5;
  const Driver driver{Swing{}};
  for (int i = 0; i < 20; ++i) {
    const Body first = random_body(), second = random_body();
    const double t = random_number(2);
    const auto at = [&](double dt, double d1, double d2) {
      Body a = first, b = second;
      a.theta += d1;
      b.theta += d2;
      return driver.rows(t + dt, a, b);
    };
    const auto rows = at(0, 0, 0);
    const auto slope = [&](auto f) { return (f(h) - f(-h)) / (2 * h); };
    CHECK(rows.C[0] == Approx(first.theta - second.theta - Swing{}(t).f));
    CHECK(rows.J1(0, 2) == Approx(slope([&](double d) { return at(0, d, 0).C[0]; })));
    CHECK(rows.J2(0, 2) == Approx(slope([&](double d) { return at(0, 0, d).C[0]; })));
    CHECK(rows.J1.leftCols<2>().isZero(0));
    CHECK(rows.J2.leftCols<2>().isZero(0));
    CHECK(rows.C_t[0] == Approx(slope([&](double d) { return at(d, 0, 0).C[0]; })).margin(1e-8));
    CHECK(rows.C_tt[0] == Approx(slope([&](double d) { return at(d, 0, 0).C_t[0]; })).margin(1e-8));
    CHECK(rows.Jdot_v[0] == 0);
    CHECK(std::abs(rows.C[0]) <= rows.size[0] * (1 + 1e-12));
    // The world stands still at the angle 0.
    Body still = second;
    still.theta = 0;
    CHECK(driver.rows(t, first, World()).C[0] == driver.rows(t, first, still).C[0]);
    CHECK(driver.rows(t, first, World()).C_tt[0] == rows.C_tt[0]);
    // The other way round it is the opposite function, and all rows change their sign.
    const auto swapped = Driver{Minus<Swing>{}}.rows(t, second, first);
    CHECK(swapped.C[0] == Approx(-rows.C[0]).margin(1e-14));
    CHECK(swapped.J1 == -rows.J2);
    CHECK(swapped.J2 == -rows.J1);
    CHECK(swapped.C_t[0] == -rows.C_t[0]);
    CHECK(swapped.C_tt[0] == -rows.C_tt[0]);
  }
}

TEST_CASE("a turning rail: Cdot and Cddot along any motion are what its rows say") {
  const TurningRail rail{w};
  for (int i = 0; i < 20; ++i) {
    const Vector2d x(random_number(), random_number()), v(random_number(), random_number()),
        a(random_number(), random_number());
    const double t = random_number(3), h = 1e-4;
    const auto at = [&](double s) {
      return rail.rows(t + s, {x + s * v + s * s / 2 * a, v + s * a}, World());
    };
    const auto rows = at(0);
    const double Cdot = rows.J1.row(0).dot(v) + rows.C_t[0];
    const double Cddot = rows.J1.row(0).dot(a) + rows.Jdot_v[0] + rows.C_tt[0];
    CHECK(Cdot == Approx((at(h).C[0] - at(-h).C[0]) / (2 * h)).margin(1e-6));
    CHECK(Cddot == Approx((at(h).C[0] - 2 * at(0).C[0] + at(-h).C[0]) / (h * h)).margin(1e-5));
  }
}

TEST_CASE(
    "a bead on a turning rail flies out as cosh, the rail pushes as sinh, and does the work") {
  // r'' = w^2 r, from rest: r = cosh wt; the force across the rail is 2 m w r'.
  for (const Method& method :
       {Method{}, Method{Scheme::rk4, Stabilization::projection},
        Method{Scheme::rk4, Stabilization::feedback, 100, 20}, Method{Scheme::dop853}}) {
    INFO(method.label());
    Motion motion(bead_on_rail(method), method);
    motion.advance(1000, 1e-3);
    const double t = 1.0, r = std::cosh(w * t), r_dot = w * std::sinh(w * t);
    const Vector2d along(std::cos(w * t), std::sin(w * t)), across = S(along);
    const VectorXd q = motion.q(), v = motion.v();
    CHECK((q - r * along).norm() < 1e-10);
    CHECK((v - r_dot * along - w * r * across).norm() < 1e-9);
    const mechanics::Row row = motion.row();
    const Vector2d force(row.reactions[0], row.reactions[1]);
    CHECK((force - 2 * mass * w * r_dot * across).norm() < 1e-8);
    const mechanics::Measures now = motion.measures();
    CHECK(now.velocity_error < 1e-9);
    CHECK(now.power == Approx(2 * mass * w * r_dot * w * r).epsilon(1e-9));
    CHECK(now.work == Approx(mass / 2 * (r_dot * r_dot + w * w * (r * r - 1))).epsilon(1e-9));
    CHECK(now.balance() == Approx(mass * w * w / 2).epsilon(1e-9));
  }
}

TEST_CASE("projection goes to J v = -C_t, at its time, and so do assembly and start rates") {
  System system;
  const auto wheel = system.add_body("wheel", 1, 0.5, {0.1, 0}, 0.2, {0.3, 0}, 5);
  system.add("pin", joints::Revolute{}, wheel);
  system.add("driver", Driver{Swing{}}, wheel);
  Evaluation e(system);
  for (const double t : {0.0, 0.7, 1.9}) {
    const Given told = Swing{}(t);
    VectorXd q = Eigen::Vector3d(0.01, -0.02, told.f + 0.03), v = Eigen::Vector3d(1, 2, -3);
    CHECK(system.project(t, q, v, e).converged);
    CHECK((q - Eigen::Vector3d(0, 0, told.f)).norm() < 1e-14);
    CHECK((v - Eigen::Vector3d(0, 0, told.f_dot)).norm() < 1e-14);
    q = system.initial_q(), v = system.initial_v();
    const Assembly assembly = system.assemble(t, q, v);
    CHECK(assembly.projected);
    CHECK(assembly.Jv_before == Approx(std::max(0.3, std::abs(5 - told.f_dot))));
    CHECK((q - Eigen::Vector3d(0, 0, told.f)).norm() < 1e-14);
    CHECK((v - Eigen::Vector3d(0, 0, told.f_dot)).norm() < 1e-14);
    system.evaluate(t, q, v, e);
    CHECK(e.velocity_error(v) < 1e-14);
    CHECK(e.velocity_error(v + VectorXd::Constant(3, 0.25)) == Approx(0.25));
  }
  const Given told = Swing{}(0);
  const Eigen::Vector3d q(0, 0, told.f);
  CHECK((system.start_rates(q, {}) - Eigen::Vector3d(0, 0, told.f_dot)).norm() < 1e-14);
  CHECK_THROWS_AS(system.start_rates(q, {{wheel, 2, told.f_dot + 1}}), AssemblyError);
}

TEST_CASE("a run projects at the new time: the driven angle is the function's to rounding") {
  const Method method{Scheme::explicit_euler, Stabilization::projection};
  Motion motion(wheel_told(Swing{}, method), method);
  for (int i = 1; i <= 20; ++i) {
    motion.advance(1, 0.1);
    const Given told = Swing{}(motion.time());
    CHECK(motion.q()[2] == Approx(told.f).epsilon(1e-14));
    CHECK(motion.v()[2] == Approx(told.f_dot).epsilon(1e-14));
    CHECK(motion.row().reactions[2] == Approx(0.5 * told.f_ddot).epsilon(1e-12));
  }
}

TEST_CASE("feedback of a driver that starts open decays as that of any joint") {
  // Critically damped: C = e0 (1 + k t) exp(-k t).
  const double k = 10, e0 = 0.05;
  const Method method{Scheme::rk4, Stabilization::feedback, k * k, 2 * k};
  Mechanism mechanism(method);
  const auto wheel = mechanism.system.add_body("wheel", 1, 0.5, {0, 0}, Swing{}(0).f + e0, {0, 0},
                                               Swing{}(0).f_dot);
  mechanism.system.add("wheel_world", joints::Revolute{}, wheel);
  mechanism.system.add("driver", Driver{Swing{}}, wheel);
  mechanism.start_as_given();
  Motion motion(std::move(mechanism), method);
  for (int i = 0; i < 4; ++i) {
    motion.advance(100, 1e-3);
    const double t = motion.time();
    CHECK(motion.q()[2] - Swing{}(t).f ==
          Approx(e0 * (1 + k * t) * std::exp(-k * t)).epsilon(1e-5));
  }
}

TEST_CASE("a driven scene moves alike where it is turned, shifted, or its joints are swapped") {
  struct Found {
    VectorXd a;
    double lambda;
  };
  const double t = 0.8, phi = 0.9;
  const Vector2d shift(2, -3);
  const auto solve = [&](bool moved, bool swapped) {
    const Eigen::Matrix2d R = moved ? rotation(phi) : rotation(0);
    const Vector2d s = moved ? shift : Vector2d(0, 0);
    const double turn = moved ? phi : 0;
    System system;
    const auto add = [&](const char* name, const Vector2d& x, double theta, const Vector2d& v,
                         double omega) {
      return system.add_body(name, 1.3, 0.4, R * x + s, theta + turn, R * v, omega);
    };
    const auto arm = add("arm", {0.5, 0}, 0, {0, 1}, 2),
               hand = add("hand", {1.2, 0}, 0, {0, 2.2}, -1);
    system.add("shoulder", joints::Revolute{.u1 = {-0.5, 0}, .u2 = s}, arm);
    system.add("elbow", joints::Revolute{.u1 = {-0.2, 0}, .u2 = {0.5, 0}}, hand, arm);
    const auto joint = swapped ? system.add("driver", Driver{Minus<Swing>{}}, arm, hand)
                               : system.add("driver", Driver{Swing{}}, hand, arm);
    system.set_gravity(R * Vector2d(0, 9.81));
    Evaluation e(system);
    system.evaluate(t, system.initial_q(), system.initial_v(), e);
    Found found{e.a(), e.lambda(joint)[0]};
    for (const int column : {0, 3})
      found.a.segment<2>(column) = (R.transpose() * found.a.segment<2>(column)).eval();
    return found;
  };
  const Found plain = solve(false, false);
  CHECK(plain.a[5] - plain.a[2] == Approx(Swing{}(t).f_ddot));
  for (const bool moved : {false, true})
    for (const bool swapped : {false, true}) {
      const Found other = solve(moved, swapped);
      CHECK((other.a - plain.a).norm() < 1e-12 * plain.a.norm());
      CHECK(other.lambda == Approx(swapped ? -plain.lambda : plain.lambda));
    }
}

namespace {

/// From rest at `start` by `by` in `duration` to rest: (2 s)^p / 2 in its first half, the same
/// turned by half a turn in its second, so that f'' jumps between them.
struct Turn {
  int p;
  double by, start, duration;

  std::array<double, 3> jumps() const { return {start, start + duration / 2, start + duration}; }

  Given operator()(double t) const {
    const auto [begin, middle, end] = jumps();
    if (t < begin || t >= end) return {t < begin ? 0 : by, 0, 0};
    const double sign = t < middle ? 1 : -1, half = duration / 2;
    const double s = (t < middle ? t - begin : end - t) / half;
    return {(t < middle ? 0 : by) + sign * by / 2 * std::pow(s, p),
            by * p / duration * std::pow(s, p - 1),
            sign * by * p * (p - 1) / (duration * half) * std::pow(s, p - 2)};
  }
};

}  // namespace

TEST_CASE("the work of a driver is that of its torque, with each integrator at its order") {
  // I f'' is the torque of a wheel, so that its work is the change of I f'^2 / 2.
  const Turn f{5, 1.5, 0.0, 1.0};
  for (const auto& scheme : integrators::schemes) {
    const auto off = [&](long steps) {
      Motion motion(wheel_told(f, {scheme.id}), {scheme.id});
      motion.advance(steps, 0.4 / static_cast<double>(steps));
      const double rate = f(0.4).f_dot;
      return std::abs(motion.measures().work - 0.25 * rate * rate);
    };
    INFO(scheme.text);
    const double coarse = off(20), fine = off(40);
    if (fine > 1e-13) CHECK(std::log2(coarse / fine) > scheme.order - 0.2);
    CHECK(fine < 0.3);
  }
}

TEST_CASE("a step that ends at a jump asks for what is before it, the next for what is behind") {
  const Turn f{3, 3.0, 0.13, 1.0};
  for (const Method& method : {Method{}, Method{Scheme::implicit_midpoint}, Method{Scheme::dop853},
                               Method{Scheme::dop853, Stabilization::none, 0, 0, 1e-9}})
    for (const long steps : {10L, 13L, 100L}) {  // 0.63 s is a multiple of the last step alone
      INFO(method.label() << ", " << steps << " steps");
      const auto off = [&](bool end_at_jumps) {
        Mechanism mechanism = wheel_told(f, method);
        const auto jumps = f.jumps();
        if (end_at_jumps) mechanism.jumps.assign(jumps.begin(), jumps.end());
        Motion motion(std::move(mechanism), method);
        motion.advance(steps, 1.0 / static_cast<double>(steps));
        CHECK(motion.time() == 1.0);
        return std::abs(motion.q()[2] - f(1.0).f);
      };
      // f'' is a straight line on each side: midpoint's own error is that of its f.
      CHECK(off(true) < (method.integrator == Scheme::implicit_midpoint ? 0.05 : 1e-8));
      if (method.tolerance == 0 && method.integrator != Scheme::implicit_midpoint)
        CHECK(off(false) > 1e-4);
    }
}

TEST_CASE("what a driver puts in is no divergence, and the watch's balance holds") {
  const Turn f{2, 50.0, 0.0, 1.0};
  const Method method;
  Mechanism mechanism = wheel_told(f, method);  // from rest, without any applied force
  Motion motion(std::move(mechanism), method);
  mechanics::Watch watch(motion);
  for (int i = 0; i < 400; ++i) {
    motion.advance(1, 1e-3);
    REQUIRE_NOTHROW(watch.look(motion.measures()));
  }
  CHECK(motion.measures().kinetic > 100);
  CHECK(watch.largest_energy_error() < 1e-4);
  CHECK(watch.verdict().right());
}

TEST_CASE("a step of a driven scene allocates nothing, and starting again forgets the work") {
  const Turn f{5, 1.5, 0.0, 1.0};
  const Method method{Scheme::rk4, Stabilization::projection};
  Motion motion(wheel_told(f, method), method);
  motion.advance(1, 1e-3);
  const long before = allocations();
  motion.advance(300, 1e-3);
  CHECK(allocations() == before);
  CHECK(motion.measures().work > 0.1);
  motion.restart();
  CHECK(motion.measures().work == 0.0);
}
