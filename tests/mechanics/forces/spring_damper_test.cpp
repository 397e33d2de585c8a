// Spring and damper between any two things: against finite differences of the potential, turned
// frames, conservation laws and the exact motion of two masses.
#include "mechanics/forces/spring_damper.hpp"

#include <cmath>
#include <complex>

#include "catch.hpp"
#include "evaluated.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "random.hpp"

using namespace dynamics;
using forces::SpringDamper;

namespace {

double random_number(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(generator);
}
Vector2d random_vector() {
  const double x = random_number(-2, 2);
  return {x, random_number(-2, 2)};
}
VectorXd random_velocity(const System& s) {
  VectorXd v(s.initial_q().size());
  for (double& x : v) x = random_number(-2, 2);
  return v;
}

SpringDamper random_spring(double c) {
  return {.k = random_number(1, 50),
          .c = c,
          .L = random_number(0, 2),
          .u1 = random_vector(),
          .u2 = random_vector()};
}

/// Two bodies, two particles and the world, each with a spring to each other. A particle has its
/// end at its place; turned by phi and moved by shift as a whole.
void tangle(System& s, double c, double phi = 0, const Vector2d& shift = {0, 0}) {
  const Matrix2d R = rotation(phi);
  const auto place = [&] { return Vector2d(R * random_vector() + shift); };
  const Vector2d x1 = place(), x2 = place(), x3 = place(), x4 = place();
  const auto b1 = s.add_body("b1", 1.5, 0.4, x1, 0.3 + phi), b2 = s.add_body("b2", 2, 1, x2, phi);
  const auto p1 = s.add_particle("p1", 0.7, x3), p2 = s.add_particle("p2", 3, x4);
  const auto spring = [&](bool first_turns, bool second_turns) {
    SpringDamper random = random_spring(c);
    if (!first_turns) random.u1.setZero();
    if (!second_turns) random.u2.setZero();
    return random;
  };
  s.apply(b1, b2, spring(true, true));
  s.apply(b1, p1, spring(true, false));
  s.apply(p2, b2, spring(false, true));
  s.apply(p1, p2, spring(false, false));
  SpringDamper tied = spring(true, true), held = tied, hung = spring(false, true);
  tied.u2 = R * tied.u2 + shift;
  held.u1 = R * held.u1 + shift;
  hung.u2 = tied.u2;
  s.apply(b1, System::world, tied);
  s.apply(System::world, b2, held);
  s.apply(p1, System::world, hung);
}

/// Steps until t with RK4.
void run(Evaluated& s, double t, int steps, VectorXd& q, VectorXd& v) {
  integrators::Rk4<VectorXd> rk4(q);
  for (int i = 0; i < steps; ++i)
    rk4.step([&](double time, const VectorXd& x, const VectorXd& w,
                 VectorXd& a) { s.acceleration(time, x, w, a); },
             0.0, q, v, t / steps);
}

}  // namespace

TEST_CASE("a spring's force is minus the gradient of its potential, moments included") {
  for (int i = 0; i < 50; ++i) {
    Evaluated s;
    tangle(s, 0);
    const VectorXd q = s.initial_q(), v = random_velocity(s), F = s.forces(0, q, v);
    const double h = 1e-6;
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      VectorXd more = q, less = q;
      more[k] += h;
      less[k] -= h;
      const double dV = (s.energy(more, v) - s.energy(less, v)) / (2 * h);
      CHECK(F[k] == Approx(-dV).margin(1e-5));
    }
  }
}

TEST_CASE("springs and dampers of a scene turned and moved as a whole turn along") {
  for (int i = 0; i < 20; ++i) {
    const double phi = random_number(-3, 3);
    const Vector2d shift = 3 * random_vector();
    Evaluated straight, turned;
    const auto seed = generator;
    tangle(straight, 2.5);
    generator = seed;  // the same scene
    tangle(turned, 2.5, phi, shift);
    VectorXd v = random_velocity(straight);
    VectorXd v_turned = v, a = straight.at(straight.initial_q(), v).a();
    for (const ThingInfo& thing : straight.things())
      for (VectorXd* x : {&v_turned, &a})
        x->segment<2>(thing.column) = rotation(phi) * x->segment<2>(thing.column);
    const VectorXd a_turned = turned.at(turned.initial_q(), v_turned).a();
    CHECK((a_turned - a).norm() < 1e-12 * a.norm());
    CHECK(turned.energy(turned.initial_q(), v_turned) ==
          Approx(straight.energy(straight.initial_q(), v)).epsilon(1e-12));
  }
}

TEST_CASE("a damper takes as much energy as it makes heat, and a spring none") {
  for (int i = 0; i < 50; ++i) {
    Evaluated s;
    const auto b = s.add_body("b", 1, 0.3, random_vector(), 0.4);
    const auto c = s.add_body("c", 2, 0.1, random_vector(), -1);
    const SpringDamper spring = random_spring(3);
    s.apply(b, c, spring);
    const VectorXd q = s.initial_q(), v = random_velocity(s), a = s.at(q, v).a();
    // dE/dt along the motion. The potential's part by finite differences.
    const double h = 1e-6;
    const double V_dot = (s.energy(q + h * v, v) - s.energy(q - h * v, v)) / (2 * h);
    const double T_dot = v.dot(a.cwiseQuotient(s.W()));
    CHECK(-(T_dot + V_dot) == Approx(spring.heat(s.state(b, q, v), s.state(c, q, v))).margin(1e-5));
  }
}

TEST_CASE("two bodies on a spring and damper keep momentum and angular momentum") {
  Evaluated s;
  const auto b = s.add_body("b", 1, 0.3, {-1, 0.5}, 0.4);
  const auto c = s.add_body("c", 2, 0.1, {1.5, -0.5}, -1);
  s.apply(b, c, SpringDamper{.k = 40, .c = 0.5, .L = 1, .u1 = {0.3, 0.1}, .u2 = {-0.2, 0.4}});
  VectorXd q = s.initial_q(), v(6);
  v << 1, 2, 3, -2, 0.5, -4;
  const auto momenta = [&] {
    Vector3d sum = Vector3d::Zero();
    for (const ThingInfo& thing : s.things()) {
      const VectorXd p = v.segment(thing.column, 3).cwiseQuotient(s.W().segment(thing.column, 3));
      const Vector2d x = q.segment<2>(thing.column);
      sum += Vector3d(p[0], p[1], p[2] + S(x).dot(p.head<2>()));
    }
    return sum;
  };
  const Vector3d before = momenta();
  const double E = s.energy(q, v);
  run(s, 5, 5000, q, v);
  CHECK((momenta() - before).norm() < 1e-9);  // RK4's own error
  CHECK(s.energy(q, v) < E - 1);
}

TEST_CASE("two masses on a spring swing as they must, damped or not") {
  // x = x2 - x1 - L obeys m x'' + c x' + k x = 0 with the reduced mass m.
  const double m1 = 1.5, m2 = 0.5, k = 30, L = 0.8, x0 = 0.3, t = 2, m = m1 * m2 / (m1 + m2);
  const Vector2d e = rotation(0.7).col(0), from(3, -2);
  for (const double c : {0.0, 1.0, 2 * std::sqrt(k * m) * 1.5}) {
    Evaluated s;
    const auto one = s.add_particle("one", m1, from);
    const auto two = s.add_body("two", m2, 0.1, from + (L + x0) * e);
    s.apply(one, two, SpringDamper{.k = k, .c = c, .L = L});
    VectorXd q = s.initial_q(), v = s.initial_v();
    run(s, t, 4000, q, v);
    const std::complex<double> root = std::sqrt(std::complex<double>(c * c - 4 * k * m));
    const auto s1 = (-c + root) / (2 * m), s2 = (-c - root) / (2 * m);
    const double x = (x0 * (s1 * std::exp(s2 * t) - s2 * std::exp(s1 * t)) / (s1 - s2)).real();
    if (c == 0) CHECK(x == Approx(x0 * std::cos(std::sqrt(k * (1 / m1 + 1 / m2)) * t)));
    const Vector2d way = q.segment<2>(two.column) - q.segment<2>(one.column);
    CHECK(std::abs(way.dot(e) - L - x) < 1e-10);
    CHECK(std::abs(way.dot(S(e))) < 1e-13);
    const Vector2d centre = (m1 * q.segment<2>(one.column) + m2 * q.segment<2>(two.column)) / 2;
    CHECK((centre - (from + m2 / 2 * (L + x0) * e)).norm() < 1e-13);
  }
}

TEST_CASE("where the ends of a spring meet") {
  const auto of = [](const SpringDamper& spring, const Vector2d& x, const Vector2d& v) {
    return spring.push(World{}, Particle{x, v}).force;  // towards the particle where it is pulled
  };
  SECTION("of no length at rest, it is linear through the point, and smooth") {
    const SpringDamper spring{.k = 10, .c = 2};
    CHECK(of(spring, {0, 0}, {0, 0}).norm() == 0);
    for (const double x : {0.3, 1e-3, 1e-9, 1e-200, 1e-310, 0.0, -1e-310, -1e-9, -0.3}) {
      const Vector2d way = x * rotation(0.4).col(0), v = rotation(0.4).col(0) * 3;
      CHECK((of(spring, way, v) - (10 * way + 2 * v)).norm() < 1e-11);
    }
    // Through the point and on: half a period later it is on the other side.
    Evaluated s;
    const auto p = s.add_particle("p", 1, {0.3, 0.4});
    s.apply(System::world, p, SpringDamper{.k = 10});
    VectorXd q = s.initial_q(), v = s.initial_v();
    run(s, std::acos(-1.0) / std::sqrt(10), 1000, q, v);
    CHECK((q + s.initial_q()).norm() < 1e-10);
  }
  SECTION("with a length at rest, the spring gives no force there, and the damper its own") {
    const SpringDamper spring{.k = 10, .c = 2, .L = 1};
    CHECK(of(spring, {0, 0}, {3, 4}) == Vector2d(6, 8));
    CHECK(spring.heat(World{}, Particle{{0, 0}, {3, 4}}) == 50);
    CHECK(spring.potential(World{}, Particle{{0, 0}, {3, 4}}) == 5);
    // On both sides it pushes outwards, with k L.
    CHECK((of(spring, {1e-12, 0}, {0, 0}) - Vector2d(-10, 0)).norm() < 1e-10);
    CHECK((of(spring, {-1e-12, 0}, {0, 0}) - Vector2d(10, 0)).norm() < 1e-10);
  }
}

TEST_CASE("a spring that is none is refused, and the things it was to join are named") {
  Evaluated s;
  const auto b = s.add_body("b", 1, 1, {0, 0});
  const auto p = s.add_particle("p", 1, {1, 0});
  const double nan = std::nan(""), inf = INFINITY;
  for (const double bad : {-1.0, nan, inf}) {
    const std::string words =
        "b and p: stiffness, damping and length at rest must be finite and not negative";
    CHECK_THROWS_WITH(s.apply(b, p, SpringDamper{.k = bad}), words);
    CHECK_THROWS_WITH(s.apply(b, p, SpringDamper{.c = bad}), words);
    CHECK_THROWS_WITH(s.apply(b, p, SpringDamper{.L = bad}), words);
  }
  CHECK_THROWS_WITH(s.apply(System::world, p, SpringDamper{.u1 = {nan, 0}}),
                    "world and p: its points must be finite");
  CHECK_THROWS_WITH(s.apply(b, b, SpringDamper{}), "b: no force acts between a thing and itself");
  CHECK(s.forces(0, s.initial_q(), s.initial_v()).norm() == 0);
}
