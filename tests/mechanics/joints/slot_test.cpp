// The joint of docs/adding_a_joint.md, as written there.

#include "slot.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "catch.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"

using dynamics::Body;
using dynamics::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using joints::Slot;

namespace {

/// A body at coordinates (x, y, θ) with velocities (vx, vy, ω).
Body body(const Vector3d& q, const Vector3d& v) {
  return {q.head<2>(), v.head<2>(), q.z(), v.z(), dynamics::rotation(q.z())};
}

}  // namespace

// [finite_differences]
TEST_CASE("slot: J and J̇v against finite differences") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-2, 2);
  const auto vector = [&] { return Vector3d(number(random), number(random), number(random)); };
  for (int i = 0; i < 200; ++i) {
    const Slot slot{.u1 = vector().head<2>(),
                    .u2 = vector().head<2>(),
                    .n_hat = vector().head<2>().normalized()};
    const Vector3d q1 = vector(), q2 = vector(), v1 = vector(), v2 = vector();
    const auto rows = [&](double t) {  // the motion q + v t
      return slot.rows(body(q1 + t * v1, v1), body(q2 + t * v2, v2));
    };
    const auto Cdot = [&](double t) { return (rows(t).J1 * v1 + rows(t).J2 * v2)[0]; };
    const double h = 1e-5;
    CHECK(Cdot(0) == Approx((rows(h).C[0] - rows(-h).C[0]) / (2 * h)).margin(1e-7));
    CHECK(rows(0).Jdot_v[0] == Approx((Cdot(h) - Cdot(-h)) / (2 * h)).margin(1e-7));
  }
}
// [finite_differences]

// [scene]
TEST_CASE("slot: a Scotch yoke moves as the cosine of its disc") {
  dynamics::System system;
  const double r = 0.3, omega = 5.0;
  const auto disc = system.add_body("disc", 2.0, 0.1, {0, 0}, 0.0, {0, 0}, omega);
  const auto bar = system.add_body("bar", 1.0, 0.1, {r, 0});
  system.add("disc_world", joints::Revolute{}, disc);
  system.add("bar_world", joints::Prismatic{}, dynamics::System::world, bar);
  system.add("disc_bar", Slot{.u2 = {r, 0}, .n_hat = {1, 0}}, bar, disc);
  VectorXd q = system.initial_q(), v = system.initial_v();
  system.assemble(0, q, v);
  dynamics::Evaluation e(system);
  integrators::Rk4<VectorXd> integrator(q);
  const double energy = system.energy(q, v);
  for (int i = 0; i < 1000; ++i) {
    integrator.step(
        [&](double t, const VectorXd& x, const VectorXd& w, VectorXd& a) {
          system.evaluate(t, x, w, e);
          a = e.a();
        },
        0.0, q, v, 1e-3);
    REQUIRE(q[bar.column] == Approx(r * std::cos(q[disc.column + 2])).margin(1e-9));
  }
  // [scene]
  CHECK(q[disc.column + 2] > 3.0);
  CHECK(system.energy(q, v) == Approx(energy).epsilon(1e-9));
  CHECK(e.counts().degrees_of_freedom == 1);
}
