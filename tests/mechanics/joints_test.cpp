// Each joint alone, between every pair of things that it can join, against finite differences of
// its own C, against rigid motions of the whole scene, and against Newton's third law.
#include <Eigen/Dense>

#include "catch.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/ground.hpp"
#include "mechanics/joints/on_curve.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "random.hpp"

using namespace dynamics;
using namespace joints;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

double random_number(double size = 1) {
  return std::uniform_real_distribution<double>(-size, size)(generator);
}
Vector2d random_vector(double size = 1) { return {random_number(size), random_number(size)}; }

template <class Thing>
Thing random_thing();
template <>
World random_thing<World>() {
  return {};
}
template <>
Particle random_thing<Particle>() {
  return {random_vector(3), random_vector(3)};
}
template <>
Body random_thing<Body>() {
  const double theta = random_number(4);
  return {random_vector(3), random_vector(3), theta, random_number(3), rotation(theta)};
}

// The thing after a step dq of its coordinates, its velocities unchanged.
World moved(const World& w, const VectorXd&) { return w; }
Particle moved(Particle p, const VectorXd& dq) {
  p.x += dq;
  return p;
}
Body moved(Body b, const VectorXd& dq) {
  b.x += dq.head<2>();
  b.theta += dq[2];
  b.A = rotation(b.theta);
  return b;
}

VectorXd velocity(const World&) { return VectorXd(0); }
VectorXd velocity(const Particle& p) { return p.v; }
VectorXd velocity(const Body& b) { return Vector3d(b.v.x(), b.v.y(), b.omega); }

// Everything a rigid motion of the whole scene, x -> R x + t, does.
struct Motion {
  double phi;
  Vector2d t;
  Matrix2d R = rotation(phi);

  Vector2d point(const Vector2d& x) const { return R * x + t; }
  World operator()(const World& w) const { return w; }
  Particle operator()(const Particle& p) const { return {point(p.x), R * p.v}; }
  Body operator()(const Body& b) const {
    return {point(b.x), R * b.v, b.theta + phi, b.omega, rotation(b.theta + phi)};
  }
  // An anchor turns with the scene when it is given in world axes: in the world or in a particle.
  Vector2d anchor(const World&, const Vector2d& u) const { return point(u); }
  Vector2d anchor(const Particle&, const Vector2d& u) const { return R * u; }
  Vector2d anchor(const Body&, const Vector2d& u) const { return u; }
  MatrixXd columns(int dof) const {
    MatrixXd T = MatrixXd::Identity(dof, dof);
    if (dof > 0) T.topLeftCorner(2, 2) = R;
    return T;
  }
};

// The rows with sizes known at run time only, so that blocks without columns need no special case.
struct Dynamic {
  template <class Rows>
  Dynamic(const Rows& rows)
      : C(rows.C), Jdot_v(rows.Jdot_v), size(rows.size), J1(C.size(), 0), J2(C.size(), 0) {
    if constexpr (decltype(rows.J1)::ColsAtCompileTime > 0) J1 = rows.J1;
    if constexpr (decltype(rows.J2)::ColsAtCompileTime > 0) J2 = rows.J2;
  }
  VectorXd C, Jdot_v, size;
  MatrixXd J1, J2;
};

template <class Joint, class First, class Second>
void check_derivatives(const Joint& joint, const First& first, const Second& second) {
  constexpr double h = 1e-5, tolerance = 3e-8;
  const Dynamic rows = joint.rows(first, second);
  const auto C = [&](const VectorXd& dq1, const VectorXd& dq2) {
    return VectorXd(joint.rows(moved(first, dq1), moved(second, dq2)).C);
  };
  const VectorXd zero1 = VectorXd::Zero(First::dof), zero2 = VectorXd::Zero(Second::dof);
  for (int k = 0; k < First::dof; ++k) {
    const VectorXd dq = h * VectorXd::Unit(First::dof, k);
    CHECK((rows.J1.col(k) - (C(dq, zero2) - C(-dq, zero2)) / (2 * h)).norm() < tolerance);
  }
  for (int k = 0; k < Second::dof; ++k) {
    const VectorXd dq = h * VectorXd::Unit(Second::dof, k);
    CHECK((rows.J2.col(k) - (C(zero1, dq) - C(zero1, -dq)) / (2 * h)).norm() < tolerance);
  }
  // Jdot_v is the rate of J v along q + t v, v held.
  const auto Jv = [&](double t) {
    const VectorXd v1 = velocity(first), v2 = velocity(second);
    const Dynamic later = joint.rows(moved(first, t * v1), moved(second, t * v2));
    return VectorXd(later.J1 * v1 + later.J2 * v2);
  };
  CHECK((rows.Jdot_v - (Jv(h) - Jv(-h)) / (2 * h)).norm() < 10 * tolerance);
  // C is the difference of terms of this size, so it cannot be larger.
  CHECK((rows.C.cwiseAbs().array() <= rows.size.array() * (1 + 1e-12) + 1e-12).all());
}

// Calls f(first, second) for many random states of each pair that a joint between points can join.
template <class F>
void for_pairs(const F& f) {
  for (int i = 0; i < 50; ++i) {
    f(random_thing<Body>(), random_thing<Body>());
    f(random_thing<Body>(), random_thing<Particle>());
    f(random_thing<Particle>(), random_thing<Body>());
    f(random_thing<Particle>(), random_thing<Particle>());
    f(random_thing<Body>(), random_thing<World>());
    f(random_thing<World>(), random_thing<Body>());
    f(random_thing<Particle>(), random_thing<World>());
    f(random_thing<World>(), random_thing<Particle>());
  }
}

// Forces of the joint on two bodies: their sum, and the sum of their moments about the origin.
template <class Rows>
Vector3d total_wrench(const Rows& rows, const Body& first, const Body& second) {
  Vector3d total = Vector3d::Zero();
  const VectorXd lambda = VectorXd::Random(rows.C.size());
  const auto add = [&](const Body& body, const Vector3d& f) {
    total += Vector3d(f.x(), f.y(), f.z() + body.x.x() * f.y() - body.x.y() * f.x());
  };
  add(first, rows.J1.transpose() * lambda);
  add(second, rows.J2.transpose() * lambda);
  return total;
}

}  // namespace

TEST_CASE("a point of a body turns with it") {
  // A quarter turn takes +x to +y (down): u = (1, 0) of a body at (1, 2) is at (1, 3).
  const double right = std::acos(-1.0) / 2;
  const Body body{{1, 2}, {0, 0}, right, 2, rotation(right)};
  const auto p = point(body, {1, 0});
  CHECK((p.r - Vector2d(1, 3)).norm() < 1e-15);
  CHECK((p.rdot - Vector2d(-2, 0)).norm() < 1e-15);    // omega S A u
  CHECK((p.Jdot_v - Vector2d(0, -4)).norm() < 1e-15);  // -omega^2 A u, towards the centre
}

TEST_CASE("revolute: J and Jdot_v are the derivatives of C") {
  for_pairs([](const auto& first, const auto& second) {
    check_derivatives(Revolute{random_vector(), random_vector()}, first, second);
  });
}

TEST_CASE("distance: J and Jdot_v are the derivatives of C") {
  for_pairs([](const auto& first, const auto& second) {
    check_derivatives(Distance{1.5, random_vector(), random_vector()}, first, second);
  });
}

TEST_CASE("prismatic: J and Jdot_v are the derivatives of C") {
  for (int i = 0; i < 200; ++i) {
    const Prismatic joint{random_vector(), random_vector(), rotation(random_number(4)).col(0),
                          random_number()};
    check_derivatives(joint, random_thing<Body>(), random_thing<Body>());
    check_derivatives(joint, World(), random_thing<Body>());
  }
}

TEST_CASE("prismatic: a rail in the world is a rail in a body that does not move") {
  for (int i = 0; i < 50; ++i) {
    const Prismatic joint{random_vector(), random_vector(), rotation(random_number(4)).col(0),
                          random_number()};
    const Body still{Vector2d::Zero(), Vector2d::Zero(), 0, 0, rotation(0)};
    const Body block = random_thing<Body>();
    const auto a = joint.rows(still, block);
    const auto b = joint.rows(World(), block);
    CHECK((a.C - b.C).norm() < 1e-14);
    CHECK((a.J2 - b.J2).norm() < 1e-14);
    CHECK((a.Jdot_v - b.Jdot_v).norm() < 1e-13);
  }
}

TEST_CASE("ground: J and Jdot_v are the derivatives of C") {
  for (int i = 0; i < 50; ++i) {
    check_derivatives(Ground{random_vector(), random_number()}, random_thing<Body>(), World());
    check_derivatives(Ground{random_vector()}, random_thing<Particle>(), World());
  }
}

namespace {
// A curve whose Hessian has all its entries: a tilted ellipse with a cubic term.
struct Cubic {
  static constexpr const char* unit = "m^3";
  double f(const Vector2d& r) const {
    return r.x() * r.x() * r.y() + 0.5 * r.x() * r.y() + r.y() * r.y() - 1;
  }
  Vector2d gradient(const Vector2d& r) const {
    return {2 * r.x() * r.y() + 0.5 * r.y(), r.x() * r.x() + 0.5 * r.x() + 2 * r.y()};
  }
  Matrix2d hessian(const Vector2d& r) const {
    Matrix2d H;
    H << 2 * r.y(), 2 * r.x() + 0.5, 2 * r.x() + 0.5, 2;
    return H;
  }
};

template <class Curve>
void check_curve(const Curve& curve) {
  for (int i = 0; i < 50; ++i) {
    const OnCurve<Curve> joint{curve, random_vector()};
    const auto check = [&](const auto& thing) {
      const auto rows = joint.rows(thing, World());
      const VectorXd v = velocity(thing);
      const double h = 1e-5;
      for (int k = 0; k < v.size(); ++k) {
        const VectorXd dq = h * VectorXd::Unit(v.size(), k);
        const auto C = [&](const VectorXd& d) { return joint.rows(moved(thing, d), World()).C[0]; };
        CHECK(std::abs(rows.J1[k] - (C(dq) - C(-dq)) / (2 * h)) < 1e-7);
      }
      const auto Jv = [&](double t) { return joint.rows(moved(thing, t * v), World()).J1.dot(v); };
      CHECK(std::abs(rows.Jdot_v[0] - (Jv(h) - Jv(-h)) / (2 * h)) < 1e-5);
    };
    check(random_thing<Particle>());
    check(random_thing<Body>());
  }
}
}  // namespace

TEST_CASE("on a curve: J and Jdot_v are the derivatives of C") {
  check_curve(Parabola{50});
  check_curve(Cubic{});
  // x^2 + 2 p y with p = 50: (10, -1) is on the curve, (10, 0) is 100 off it.
  const auto C = [](const Vector2d& x) {
    return OnCurve<Parabola>{{50}}.rows(Particle{x, Vector2d::Zero()}, World()).C[0];
  };
  CHECK(C({10, -1}) == 0);
  CHECK(C({10, 0}) == 100);
}

TEST_CASE("a rigid motion of the whole scene changes nothing but the axes") {
  for (int i = 0; i < 30; ++i) {
    const Motion motion{random_number(4), random_vector(5)};
    const Vector2d u1 = random_vector(), u2 = random_vector(),
                   n = rotation(random_number(4)).col(0);
    // R_C: what the motion does to the rows themselves.
    const auto check = [&](const Dynamic& a, const Dynamic& b, const MatrixXd& R_C) {
      CHECK((b.C - R_C * a.C).norm() < 1e-12);
      CHECK((b.Jdot_v - R_C * a.Jdot_v).norm() < 1e-11);
      CHECK((b.J1 * motion.columns(int(a.J1.cols())) - R_C * a.J1).norm() < 1e-12);
      CHECK((b.J2 * motion.columns(int(a.J2.cols())) - R_C * a.J2).norm() < 1e-12);
    };
    const auto check_pair = [&](const auto& first, const auto& second) {
      const Vector2d w1 = motion.anchor(first, u1), w2 = motion.anchor(second, u2);
      check(Revolute{u1, u2}.rows(first, second),
            Revolute{w1, w2}.rows(motion(first), motion(second)), motion.R);
      check(Distance{1.5, u1, u2}.rows(first, second),
            Distance{1.5, w1, w2}.rows(motion(first), motion(second)), MatrixXd::Identity(1, 1));
      // Exchanging the two things changes the sign of a revolute and nothing of a distance.
      const Dynamic r = Revolute{u1, u2}.rows(first, second);
      const Dynamic r_swapped = Revolute{u2, u1}.rows(second, first);
      CHECK((r.C + r_swapped.C).norm() + (r.J1 + r_swapped.J2).norm() +
                (r.J2 + r_swapped.J1).norm() + (r.Jdot_v + r_swapped.Jdot_v).norm() <
            1e-13);
      const Dynamic d = Distance{1.5, u1, u2}.rows(first, second);
      const Dynamic d_swapped = Distance{1.5, u2, u1}.rows(second, first);
      CHECK((d.C - d_swapped.C).norm() + (d.J1 - d_swapped.J2).norm() +
                (d.J2 - d_swapped.J1).norm() + (d.Jdot_v - d_swapped.Jdot_v).norm() <
            1e-12);
    };
    for_pairs(check_pair);
    const Body first = random_thing<Body>(), second = random_thing<Body>();
    check(Prismatic{u1, u2, n, 0.3}.rows(first, second),
          Prismatic{u1, u2, n, 0.3}.rows(motion(first), motion(second)), MatrixXd::Identity(2, 2));
    check(Prismatic{u1, u2, n, 0.3}.rows(World(), second),
          Prismatic{motion.point(u1), u2, motion.R * n, 0.3 + motion.phi}.rows(World(),
                                                                               motion(second)),
          MatrixXd::Identity(2, 2));
  }
}

TEST_CASE("between two bodies the forces and their moments about the origin sum to zero") {
  for (int i = 0; i < 100; ++i) {
    const Body first = random_thing<Body>();
    Body second = random_thing<Body>();
    const Vector2d u1 = random_vector(), u2 = random_vector();
    CHECK(total_wrench(Distance{1.5, u1, u2}.rows(first, second), first, second).norm() < 1e-12);
    const Prismatic prismatic{u1, u2, rotation(random_number(4)).col(0), 0.3};
    CHECK(total_wrench(prismatic.rows(first, second), first, second).norm() < 1e-12);
    // The two ends of a revolute act at one point when it is closed.
    second.x += first.x + first.A * u1 - second.x - second.A * u2;
    const auto rows = Revolute{u1, u2}.rows(first, second);
    REQUIRE(rows.C.norm() < 1e-14);
    CHECK(total_wrench(rows, first, second).norm() < 1e-12);
  }
}

namespace {
// The words with which a System refuses a joint of a body or of a particle.
template <class Joint>
std::string refusal(const Joint& joint, bool particle = false) {
  System s;
  const auto body = s.add_body("body", 1, 1, {1, 2}, 0.3);
  const auto bead = s.add_particle("bead", 1, {3, 4});
  try {
    if constexpr (std::is_same_v<Joint, Prismatic>)
      s.add("it", joint, System::world, body);
    else if (particle)
      s.add("it", joint, bead);
    else
      s.add("it", joint, body);
  } catch (const std::invalid_argument& error) {
    CHECK(s.rows() == 0);
    return error.what();
  }
  return "";
}
}  // namespace

TEST_CASE("a joint that could not hold anything is refused when it is added") {
  const double nan = std::nan(""), inf = INFINITY;
  const std::string rows =
      "it: where its things start, C or J W J^T is not finite, or too small to be computed with";
  for (const bool particle : {false, true}) {
    for (const double length : {0.0, -0.0, -1.0, 1e-160, 5e-324, 1e160, inf, -inf, nan})
      CHECK(refusal(Distance{length}, particle) ==
            "it: its length must be positive, and its square neither too large nor too small");
    for (const double length : {1e-150, 1e-3, 1.0, 1e150})
      CHECK(refusal(Distance{length}, particle) == "");
    for (const double p : {0.0, -0.0, 1e-160, 1e160, inf, nan})
      CHECK(refusal(OnCurve<Parabola>{{p}}, particle) ==
            "it: p must not be 0, and its square neither too large nor too small");
    CHECK(refusal(OnCurve<Parabola>{{-50}}, particle) == "");
    CHECK(refusal(OnCurve<Cubic>{}, particle) == "");
    for (const double bad : {nan, inf, -inf}) {
      CHECK(refusal(Distance{1, {bad, 0}}, particle) == rows);
      CHECK(refusal(Distance{1, {0, 0}, {0, bad}}, particle) == rows);
      CHECK(refusal(Revolute{{0, bad}, {0, 0}}, particle) == rows);
      CHECK(refusal(Revolute{{0, 0}, {bad, 0}}, particle) == rows);
      CHECK(refusal(Ground{{bad, 0}}, particle) == rows);
      CHECK(refusal(OnCurve<Parabola>{{50}, {0, bad}}, particle) == rows);
    }
    // 1e-150 m apart, and so heavy that nothing but rounding to 0 is left of J W J^T.
    System s;
    const auto a = s.add_particle("a", 1e100, {0, 0}), b = s.add_particle("b", 1e100, {1e-150, 0});
    CHECK_THROWS_AS(s.add("it", Distance{1e-150}, a, b), std::invalid_argument);
  }
  const std::string normal = "it: its normal n_hat must be of length 1";
  for (const Vector2d& n : {Vector2d(0, 0), Vector2d(0, 2), Vector2d(1, 1), Vector2d(0, 1e-200),
                            Vector2d(0, nan), Vector2d(inf, 0), Vector2d(0.707, 0.707)})
    CHECK(refusal(Prismatic{.n_hat = n}) == normal);
  for (const double angle : {0.0, 0.3, 1.0, 2.0, 4.0})
    CHECK(refusal(Prismatic{.n_hat = rotation(angle).col(0)}) == "");
  for (const double bad : {nan, inf, -inf}) {
    CHECK(refusal(Ground{{0, 0}, bad}) == rows);
    CHECK(refusal(Prismatic{.theta21 = bad}) == rows);
    CHECK(refusal(Prismatic{.u1 = {bad, 0}}) == rows);
    CHECK(refusal(Prismatic{.u2 = {0, bad}}) == rows);
  }
}
