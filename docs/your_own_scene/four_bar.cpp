// A four-bar linkage: crank, coupler and rocker, pinned in a row between two pivots of the ground.
#include <cmath>
#include <cstdio>
#include <exception>

#include "mechanics/dynamics/system.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/joints/revolute.hpp"

using Eigen::Vector2d, Eigen::VectorXd;

constexpr double ground = 1.0, crank = 0.3, coupler = 0.9, rocker = 0.6;  // lengths [m]

/// The rocker's angle at a crank angle theta. With the way D from the crank's pin to the rocker's
/// pivot, the coupler has its length where |D + rocker (cos psi, sin psi)| = coupler.
/// Freudenstein's equation is that, squared and divided: P cos psi + Q sin psi = R.
double rocker_angle(double theta) {
  const double P = ground / crank - std::cos(theta), Q = -std::sin(theta);
  const double R = ground / rocker * std::cos(theta) -
                   (ground * ground + crank * crank + rocker * rocker - coupler * coupler) /
                       (2 * crank * rocker);
  return std::atan2(Q, P) - std::acos(R / std::hypot(P, Q));  // +: the loop folded the other way
}

int main() try {
  dynamics::System system;
  // A uniform bar of 1 kg/m and its pose at the start: its middle, and the way it points.
  const auto add_bar = [&](const char* name, double length, const Vector2d& from,
                           const Vector2d& to) {
    const Vector2d way = to - from;
    return system.add_body(name, length, length * length * length / 12, (from + to) / 2,
                           std::atan2(way.y(), way.x()));
  };
  const Vector2d pivot(ground, 0), A(crank, 0), B(0.9, -0.6);  // y is down; B is a guess
  const auto crank_bar = add_bar("crank", crank, {0, 0}, A);
  const auto coupler_bar = add_bar("coupler", coupler, A, B);
  const auto rocker_bar = add_bar("rocker", rocker, pivot, B);

  using joints::Revolute;  // point u1 of the first thing stays on point u2 of the second
  system.add("crank_ground", Revolute{.u1 = {-crank / 2, 0}}, crank_bar);
  system.add("coupler_crank", Revolute{.u1 = {-coupler / 2, 0}, .u2 = {crank / 2, 0}}, coupler_bar,
             crank_bar);
  system.add("rocker_coupler", Revolute{.u1 = {rocker / 2, 0}, .u2 = {coupler / 2, 0}}, rocker_bar,
             coupler_bar);
  system.add("rocker_ground", Revolute{.u1 = {-rocker / 2, 0}, .u2 = pivot}, rocker_bar);
  const double torque = 3.0;  // [N m]
  system.apply(crank_bar, {0, 0, torque});
  system.set_gravity({0, 9.81});

  VectorXd q = system.initial_q(), v = system.initial_v();
  system.assemble(0, q, v);
  const double& theta = q[crank_bar.column + 2];  // x, y, theta: of each body three
  const double& psi = q[rocker_bar.column + 2];
  const double theta0 = theta, energy0 = system.energy(q, v);
  dynamics::Evaluation e(system);
  const auto acceleration = [&](double t, const VectorXd& x, const VectorXd& w, VectorXd& a) {
    system.evaluate(t, x, w, e);
    a = e.a();
  };
  integrators::Rk4<VectorXd> rk4(q);
  std::puts("    t [s]  crank [rad]  rocker [rad]  rocker - exact [rad]  energy - work [J]");
  for (int step = 0; step <= 1000; ++step) {
    const double h = 1e-3, t = step * h;
    if (step % 125 == 0)
      std::printf("%9.3f %12.6f %13.6f %21.1e %18.1e\n", t, theta, psi, psi - rocker_angle(theta),
                  system.energy(q, v) - energy0 - torque * (theta - theta0));
    rk4.step(acceleration, t, q, v, h);
    system.project(t + h, q, v, e);
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "four_bar: %s\n", error.what());
  return 1;
}
