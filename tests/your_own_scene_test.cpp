// What docs/your_own_scene.md shows besides its program: forces between two things, rates to start
// with, what a scene that is put together wrongly says, and the exercise.

#include <cmath>

#include "catch.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/forces/spring_damper.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/revolute.hpp"

using Eigen::VectorXd;

namespace {

/// What is thrown at a mistake.
template <class Mistake>
std::string says(const Mistake& mistake) {
  try {
    mistake();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing";
}

}  // namespace

TEST_CASE("forces between two things, and one that is taken back") {
  using dynamics::Body, dynamics::Push, dynamics::System;
  System system;
  const auto rocker = system.add_body("rocker", 1, 1, {0, 0}, 0.2);
  const auto crank = system.add_body("crank", 1, 1, {1, 0});

  // [forces]
  // A spring of 200 N/m and 0.3 m with a damper of 5 N s/m, from a point of the world to the end of
  // the rocker.
  using forces::SpringDamper;
  system.apply(System::world, rocker,
               SpringDamper{.k = 200, .c = 5, .L = 0.3, .u1 = {0.5, 0}, .u2 = {0.3, 0}});

  // A torsion spring of 4 N m/rad, as a law of one's own: what the second thing does to the first.
  const auto torsion = system.apply(
      crank, rocker,
      [](double, const Body& first, const Body& second) {
        return Push{.force = {0, 0}, .at = first.x, .moment = 4 * (second.theta - first.theta)};
      },
      [](const Body& first, const Body& second) {  // its potential, which counts in the energy
        return 2 * std::pow(second.theta - first.theta, 2);
      });
  system.remove(torsion);  // and it is as if it had never been
  // [forces]
  const VectorXd q = system.initial_q(), v = system.initial_v();
  const double l = std::hypot(0.3 * std::cos(0.2) - 0.5, 0.3 * std::sin(0.2));
  CHECK(system.energy(q, v) == Approx(100 * (l - 0.3) * (l - 0.3)));
  CHECK(system.forces(0, q, v).segment<3>(crank.column).norm() == 0);
}

TEST_CASE("start rates: one is given, the others follow") {
  using joints::Revolute;
  dynamics::System system;
  const auto crank = system.add_body("crank", 1, 1, {0.15, 0});
  const auto rocker = system.add_body("rocker", 1, 1, {0.3, 0.5}, std::acos(-1.0) / 2);
  system.add("crank_ground", Revolute{.u1 = {-0.15, 0}}, crank);
  system.add("rocker_crank", Revolute{.u1 = {-0.5, 0}, .u2 = {0.15, 0}}, rocker, crank);
  system.add("tip", joints::Distance{1, {0.5, 0}, {1.3, 1}}, rocker);
  VectorXd q = system.initial_q(), v = system.initial_v();
  // [rates]
  system.assemble(0, q, v);
  v = system.start_rates(q, {{crank, 2, 10.0}});  // of coordinate 2, its angle: 10 rad/s
  // [rates]
  CHECK(v[crank.column + 2] == 10);
  // The crank's end moves by 3 m/s along y, and so does the rocker's, whose tie holds its x.
  CHECK((v.segment<3>(rocker.column) - Eigen::Vector3d(0, 3, 0)).norm() < 1e-14);
}

TEST_CASE("solution: two masses on a spring swing at sqrt(k (1/m1 + 1/m2))") {
  const double m1 = 2, m2 = 0.5, k = 40, L = 0.6, stretched = 0.1;
  dynamics::System system;
  const auto one = system.add_particle("one", m1, {0, 0});
  const auto two = system.add_particle("two", m2, {L + stretched, 0});
  system.apply(one, two, forces::SpringDamper{.k = k, .L = L});
  VectorXd q = system.initial_q(), v = system.initial_v();
  const double E = system.energy(q, v), omega = std::sqrt(k * (1 / m1 + 1 / m2));
  CHECK(E == Approx(k / 2 * stretched * stretched));
  CHECK(omega == Approx(10));  // a period of 0.628 s
  dynamics::Evaluation e(system);
  integrators::Rk4<VectorXd> rk4(q);
  const double h = 1e-3;
  for (int step = 1; step <= 2000; ++step) {
    rk4.step(
        [&](double t, const VectorXd& x, const VectorXd& w, VectorXd& a) {
          system.evaluate(t, x, w, e);
          a = e.a();
        },
        0.0, q, v, h);
    const double swing = stretched * std::cos(omega * step * h);
    REQUIRE(q[two.column] - q[one.column] - L == Approx(swing).margin(1e-9));
    REQUIRE(m1 * v[one.column] + m2 * v[two.column] == Approx(0).margin(1e-14));
  }
  CHECK(system.energy(q, v) == Approx(E).epsilon(1e-9));
}

TEST_CASE("a scene that is put together wrongly says what is wrong, and names it") {
  using joints::Revolute;
  dynamics::System system, other;
  const auto rod = system.add_body("rod", 1, 1, {0, 0});
  const auto wheel = other.add_body("wheel", 1, 1, {0, 0});
  VectorXd q = system.initial_q(), v = system.initial_v();

  // [messages]
  CHECK(says([&] {
          system.add_body("plate", -1, 1, {0, 0});
        }) == "plate: mass and inertia must be positive and finite, and so must be their inverses");
  CHECK(says([&] { system.add_body("rod", 1, 1, {0, 0}); }) == "rod: another thing has this name");
  CHECK(says([&] { system.add("loop", Revolute{}, rod, rod); }) == "loop: joins a thing to itself");
  CHECK(says([&] { system.add("pin", Revolute{}, rod, wheel); }) ==
        "pin: a handle of another System, or of none");

  // A rod that is held at both ends, by pins further apart than its ends are.
  system.add("left", Revolute{.u1 = {-0.5, 0}, .u2 = {-0.5, 0}}, rod);
  system.add("right", Revolute{.u1 = {0.5, 0}, .u2 = {0.7, 0}}, rod);
  CHECK(says([&] { system.assemble(0, q, v); }) ==
        "cannot assemble: left row 1 (m) stays open by 0.1");
  CHECK(says([&] {
          system.start_rates(q, {{rod, 2, 1.0}});
        }) == "cannot start: the joints do not leave rod this rate of theta");

  // A thing that comes after q was taken has no place in it.
  system.add_particle("bead", 1, {1, 0});
  dynamics::Evaluation e(system);
  CHECK(says([&] { system.evaluate(0, q, v, e); }) ==
        "q and v must have one entry for each coordinate");
  // [messages]
}
