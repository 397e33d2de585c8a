// Applied forces: taken back, and between two things.
#include "mechanics/dynamics/force.hpp"

#include <cmath>
#include <limits>

#include "catch.hpp"
#include "evaluated.hpp"
#include "mechanics/joints/revolute.hpp"
#include "random.hpp"

using namespace dynamics;

namespace {

Vector2d random_vector() {
  std::uniform_real_distribution<double> number(-2, 2);
  const double x = number(generator);
  return {x, number(generator)};
}
VectorXd a(Evaluated& s) { return s.at(s.initial_q(), s.initial_v()).a(); }

/// The momentum that F brings each second, and the angular momentum about the origin.
Vector3d brings(const System& s, const VectorXd& F) {
  Vector3d sum = Vector3d::Zero();
  for (const ThingInfo& thing : s.things()) {
    const Vector2d x = s.initial_q().segment<2>(thing.column), f = F.segment<2>(thing.column);
    sum.head<2>() += f;
    sum[2] += S(x).dot(f) + (thing.dof == 3 ? F[thing.column + 2] : 0);
  }
  return sum;
}

}  // namespace

TEST_CASE("what was applied can be taken back, as if it had never been") {
  const auto scene = [](Evaluated& s) {
    s.set_gravity({0, 9.81});
    const auto rod = s.add_body("rod", 1, 1.0 / 12, {0.5, 0});
    s.add("pin", joints::Revolute{{-0.5, 0}, {0, 0}}, rod);
    s.apply(rod, {0.1, 0.2, 0.3});
    return rod;
  };
  Evaluated without, s;
  scene(without);
  const auto rod = scene(s);
  const VectorXd a0 = a(without);
  const double E0 = s.energy(s.initial_q(), s.initial_v());
  const auto other = s.add_body("other", 1, 1, {2, 0.1});
  const auto a_rod = [&] { return VectorXd(a(s).head<3>()); };
  CHECK(a_rod() == a0);

  const ForceHandle load = s.apply(rod, {1e3, 1e3, 1.0 / 3});
  const ForceHandle again = s.apply(rod, {0, 0, 1});
  const ForceHandle law = s.apply(
      rod, [](double, const Body& b) { return Vector3d(-b.x.x(), 0, 7); },
      [](const Body& b) { return b.x.x() * b.x.x() / 2; });
  const ForceHandle mutual = s.apply(
      rod, other,
      [](double, const Body& one, const Body& two) {
        return Push{{3, 4}, one.x, one.theta - two.theta + 1};
      },
      [](const Body&, const Body&) { return 5.0; });
  const Evaluation before = s.at(s.initial_q(), s.initial_v());
  CHECK((a_rod() - a0).norm() > 1);
  CHECK(s.energy(s.initial_q(), s.initial_v()) > E0 + 4);
  for (const ForceHandle force : {load, law, mutual, again}) {
    const VectorXd a_before = a_rod();
    s.remove(force);
    CHECK(a_rod() != a_before);  // the evaluation that there was sees it
    CHECK_THROWS_WITH(s.remove(force), "remove: this force is not applied any more");
  }
  CHECK(a_rod() == a0);
  CHECK(s.forces(0, s.initial_q(), s.initial_v()).tail<3>() == Vector3d(0, 9.81, 0));
  CHECK(s.energy(s.initial_q(), s.initial_v()) ==
        Approx(E0 - 9.81 * 0.1).epsilon(1e-15));  // the other thing's height
  CHECK(VectorXd(before.a().head<3>()) != a0);    // but one that was kept keeps what it was told

  CHECK_THROWS_WITH(without.remove(load), "remove: a handle of another System, or of none");
  CHECK_THROWS_AS(s.remove({}), std::invalid_argument);
  CHECK_THROWS_AS(s.remove({99, load.system}), std::invalid_argument);

  // What only the other load kept finite stays.
  const double most = std::numeric_limits<double>::max();
  s.apply(other, {most, 0, 0});
  const ForceHandle opposite = s.apply(other, {-most, 0, 0});
  s.apply(other, {most, 0, 0});
  CHECK_THROWS_WITH(s.remove(opposite), "other: its weight and constant forces must be finite");
  CHECK(a(s).allFinite());
}

TEST_CASE("two things act on each other in equal and opposite ways, whatever the law") {
  for (int i = 0; i < 100; ++i) {
    Evaluated s;
    const auto one = s.add_body("one", 2, 3, random_vector(), 1);
    const auto two = s.add_body("two", 1, 0.3, random_vector(), -2);
    const auto bead = s.add_particle("bead", 1, random_vector());
    const Push push{random_vector(), random_vector(), random_vector().x()};
    const double sizes = 10 * (1 + push.force.norm());
    s.apply(one, two, [=](double, const Body&, const Body&) { return push; });
    // On a particle a force acts at its place, or along a line through it.
    s.apply(bead, one, [=](double, const Particle& p, const Body&) {
      return Push{push.force, p.x + push.moment * push.force};
    });
    CHECK(brings(s, s.forces(0, s.initial_q(), s.initial_v())).norm() < 1e-15 * sizes);
    CHECK((s.W().cwiseProduct(s.forces(0, s.initial_q(), s.initial_v())) - a(s)).norm() <=
          1e-15 * a(s).norm());

    // From the world, on either side: the force at its place, with its moment.
    Evaluated first, second;
    const Vector2d x = random_vector();
    const auto b1 = first.add_body("b", 2, 3, x, 1), b2 = second.add_body("b", 2, 3, x, 1);
    first.apply(b1, System::world, [=](double, const Body&, World) { return push; });
    second.apply(System::world, b2, [=](double, World, const Body&) { return push; });
    const Vector2d lever = push.at - x;
    const double moment = lever.x() * push.force.y() - lever.y() * push.force.x() + push.moment;
    const Vector3d wrench(push.force.x() / 2, push.force.y() / 2, moment / 3);
    CHECK((a(first) - wrench).norm() < 1e-15 * sizes);
    CHECK(a(first) == -a(second));
  }
}

TEST_CASE("a torsion spring between two discs has its known frequency") {
  const double I1 = 2, I2 = 0.5, k = 3, theta0 = 0.4;
  Evaluated s;
  const auto one = s.add_body("one", 1, I1, {0, 0});
  const auto two = s.add_body("two", 1, I2, {1, 2});
  s.apply(
      one, two,
      [=](double, const Body& b, const Body& c) {
        return Push{Vector2d::Zero(), b.x, k * (c.theta - b.theta)};
      },
      [=](const Body& b, const Body& c) {
        return k / 2 * (c.theta - b.theta) * (c.theta - b.theta);
      });
  VectorXd q = s.initial_q();
  for (const double relative : {theta0, -theta0, 2 * theta0}) {
    q[two.column + 2] = relative;
    const VectorXd acceleration = s.at(q, s.initial_v()).a();
    const double omega_squared = k * (1 / I1 + 1 / I2);
    CHECK(acceleration[two.column + 2] - acceleration[one.column + 2] ==
          Approx(-omega_squared * relative).epsilon(1e-14));
    CHECK(I1 * acceleration[one.column + 2] + I2 * acceleration[two.column + 2] == 0);
    CHECK(s.energy(q, s.initial_v()) == Approx(k / 2 * relative * relative).epsilon(1e-15));
  }
}

TEST_CASE("a force between a thing and itself, or one of another System, is refused") {
  Evaluated s, other;
  const auto b = s.add_body("b", 1, 1, {0, 0});
  const auto theirs = other.add_body("b", 1, 1, {0, 0});
  const auto law = [](double, const Body& one, const Body&) { return Push{{0, 0}, one.x}; };
  CHECK_THROWS_WITH(s.apply(b, b, law), "b: no force acts between a thing and itself");
  CHECK_THROWS_WITH(s.apply(b, theirs, law), "apply: a handle of another System, or of none");
  CHECK_THROWS_WITH(s.apply(theirs, b, law), "apply: a handle of another System, or of none");
  CHECK(s.forces(0, s.initial_q(), s.initial_v()).norm() == 0);
}
