// What a joint can see: the things it joins, the points fixed in them, and the rows it returns.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace dynamics {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// The fixed surroundings: no coordinates, no columns.
struct World {
  static constexpr int dof = 0;
};

/// A point mass: position x (m) and velocity v (m/s). It has no angle.
struct Particle {
  static constexpr int dof = 2;
  Vector2d x, v;
};

/// A rigid body: centre of mass x (m), its velocity v (m/s), angle theta (rad), omega (rad/s) and
/// the rotation A(theta), which is computed once for each evaluation and shared by its joints.
struct Body {
  static constexpr int dof = 3;
  Vector2d x, v;
  double theta, omega;
  Matrix2d A;
};

/// A = [cos, -sin; sin, cos]: turns the body's own frame into the world's.
inline Matrix2d rotation(double theta) {
  const double c = std::cos(theta), s = std::sin(theta);
  Matrix2d A;
  A << c, -s, s, c;
  return A;
}

/// S d = [0, -1; 1, 0] d: a quarter turn from +x towards +y, so that dA/dt = omega S A.
inline Vector2d S(const Vector2d& d) { return {-d.y(), d.x()}; }

/// A point fixed in a thing: where it is, how it moves, and how it depends on the thing's
/// coordinates: rdot = J v. Jdot_v is the acceleration it has while v stays constant.
template <class Thing>
struct Point {
  Vector2d r, rdot;
  Eigen::Matrix<double, 2, Thing::dof> J;
  Vector2d Jdot_v;
  double size;  ///< size (m) of the terms that r is the sum of: r is rounded to about epsilon size
};

/// The point u (m) of the world.
inline Point<World> point(const World&, const Vector2d& u) {
  return {u, Vector2d::Zero(), {}, Vector2d::Zero(), u.lpNorm<1>()};
}

/// The point at x + u: a particle does not turn, so u (mostly 0) is constant.
inline Point<Particle> point(const Particle& p, const Vector2d& u) {
  return {p.x + u, p.v, Matrix2d::Identity(), Vector2d::Zero(), p.x.lpNorm<1>() + u.lpNorm<1>()};
}

/// The point u (m, in the body's own frame):
///   r = x + A u,   rdot = v + omega S A u,   J = [I, S A u],   Jdot_v = omega^2 S S A u.
inline Point<Body> point(const Body& b, const Vector2d& u) {
  const Vector2d Au = b.A * u, SAu = S(Au);
  Point<Body> p;
  p.r = b.x + Au;
  p.rdot = b.v + b.omega * SAu;
  p.J.leftCols<2>().setIdentity();
  p.J.col(2) = SAu;
  p.Jdot_v = -b.omega * b.omega * Au;
  p.size = b.x.lpNorm<1>() + u.lpNorm<1>() * (1 + std::abs(b.theta));
  return p;
}

/// What a joint returns: r rows of the constraint and, for each of its two things, a block of J.
/// Cdot = J1 v1 + J2 v2 and Cddot = J1 a1 + J2 a2 + Jdot_v, with v = (vx, vy, omega) of each thing.
/// Where C depends on time besides, Cdot has C_t too, and Cddot C_tt: all else that it has,
/// 2 dJ/dt v included.
template <int rows, class First, class Second>
struct Rows {
  static constexpr int r = rows;

  Eigen::Vector<double, r> C;
  Eigen::Matrix<double, r, First::dof> J1;
  Eigen::Matrix<double, r, Second::dof> J2;
  Eigen::Vector<double, r> Jdot_v;
  Eigen::Vector<double, r> size;  ///< size of the terms that C is the difference of, in C's units
  Eigen::Vector<double, r> C_t = Eigen::Vector<double, r>::Zero();
  Eigen::Vector<double, r> C_tt = Eigen::Vector<double, r>::Zero();
};

}  // namespace dynamics
