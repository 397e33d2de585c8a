// The global solver against a dense reference in long double, closed forms, and conservation laws.
#include "evaluated.hpp"

#include <Eigen/Dense>
#include <chrono>

#include "allocations.hpp"
#include "catch.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/ground.hpp"
#include "mechanics/joints/on_curve.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "random.hpp"

using namespace dynamics;
using namespace joints;
using Eigen::MatrixXd;

namespace {

const double pi = std::acos(-1.0);

double random_number(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(generator);
}
Vector2d random_vector(double size = 1) {
  return {random_number(-size, size), random_number(-size, size)};
}

using MatrixXld = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using VectorXld = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

// A System that also keeps what a dense reference needs. It assembles nothing in blocks: it asks
// each joint for its rows and solves [M, -J^T; J, 0] [a; lambda] = [F; -Jdot_v - ks C - kd J v].
struct Scene {
  Evaluated system;
  Vector2d g = Vector2d::Zero();
  double ks = 0, kd = 0;
  VectorXd F_constant;

  template <class Joint, class First, class Second = World>
  JointHandle add(const std::string& name, const Joint& joint, Handle<First> first,
                  Handle<Second> second = System::world) {
    fill_.push_back([=](Evaluated& s, const VectorXd& q, const VectorXd& v, VectorXd& C,
                        MatrixXd& J, VectorXd& Jdot_v) {
      const auto rows = joint.rows(thing(s, first, q, v), thing(s, second, q, v));
      const Eigen::Index r = rows.C.size(), row = C.size();
      C.conservativeResize(row + r);
      C.tail(r) = rows.C;
      Jdot_v.conservativeResize(row + r);
      Jdot_v.tail(r) = rows.Jdot_v;
      J.conservativeResize(row + r, q.size());
      J.bottomRows(r).setZero();
      if (First::dof > 0) J.block(row, first.column, r, First::dof) = rows.J1;
      if (Second::dof > 0) J.block(row, second.column, r, Second::dof) = rows.J2;
    });
    return system.add(name, joint, first, second);
  }

  void rows(const VectorXd& q, const VectorXd& v, VectorXd& C, MatrixXd& J, VectorXd& Jdot_v) {
    C.resize(0);
    Jdot_v.resize(0);
    J.resize(0, q.size());
    for (const auto& fill : fill_) fill(system, q, v, C, J, Jdot_v);
  }

  VectorXd reference(const VectorXd& q, const VectorXd& v, VectorXd* lambda = nullptr) {
    VectorXd C, Jdot_v;
    MatrixXd J;
    rows(q, v, C, J, Jdot_v);
    const Eigen::Index n = q.size(), s = C.size();
    MatrixXld A = MatrixXld::Zero(n + s, n + s);
    VectorXld b = VectorXld::Zero(n + s);
    // Scaled by the square roots of the masses, so that a mass of 1e8 is not mistaken for rank.
    const VectorXld root = system.W().cast<long double>().cwiseSqrt();
    const MatrixXld Jr = J.cast<long double>() * root.asDiagonal();
    A.topLeftCorner(n, n).setIdentity();
    A.topRightCorner(n, s) = -Jr.transpose();
    A.bottomLeftCorner(s, n) = Jr;
    for (const ThingInfo& thing : system.things())
      b.segment(thing.column, 2) = (g / system.W()[thing.column]).cast<long double>();
    if (F_constant.size() > 0) b.head(n) += F_constant.cast<long double>();
    b.head(n) = b.head(n).cwiseProduct(root).eval();
    b.tail(s) = (-Jdot_v - ks * C - kd * J * v).cast<long double>();
    Eigen::CompleteOrthogonalDecomposition<MatrixXld> decomposition(A);
    decomposition.setThreshold(1e-14L);
    const VectorXld x = decomposition.solve(b);
    if (lambda) *lambda = x.tail(s).cast<double>();
    return x.head(n).cwiseProduct(root).cast<double>();
  }

 private:
  template <class Thing>
  static Thing thing(Evaluated& s, Handle<Thing> h, const VectorXd& q, const VectorXd& v) {
    if constexpr (Thing::dof == 0)
      return {};
    else
      return s.state(h, q, v);
  }
  std::vector<std::function<void(Evaluated&, const VectorXd&, const VectorXd&, VectorXd&, MatrixXd&,
                                 VectorXd&)>>
      fill_;
};

double relative(const VectorXd& a, const VectorXd& b) {
  return (a - b).lpNorm<Eigen::Infinity>() / std::max(1e-300, b.lpNorm<Eigen::Infinity>());
}

VectorXd acceleration(Evaluated& s, const VectorXd& q, const VectorXd& v, double t = 0) {
  VectorXd a(q.size());
  s.acceleration(t, q, v, a);
  return a;
}

// One step of the classical Runge-Kutta method.
void rk4(Evaluated& s, double h, VectorXd& q, VectorXd& v) {
  const VectorXd a1 = acceleration(s, q, v);
  const VectorXd v2 = v + h / 2 * a1, a2 = acceleration(s, q + h / 2 * v, v2);
  const VectorXd v3 = v + h / 2 * a2, a3 = acceleration(s, q + h / 2 * v2, v3);
  const VectorXd v4 = v + h * a3, a4 = acceleration(s, q + h * v3, v4);
  q += h / 6 * (v + 2 * v2 + 2 * v3 + v4);
  v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
}

// A random mechanism: bodies and particles, each joined to an earlier one or to the world, and
// some loops closed by rods. Its joints are not closed, which equation 1 does not ask for.
void random_mechanism(Scene& scene, int n, int loops) {
  std::vector<Handle<Body>> bodies;
  const auto body = [&] {
    return bodies[std::size_t(random_number(0, double(bodies.size()) - 1e-9))];
  };
  scene.g = {0.3, 9.81};
  scene.system.set_gravity(scene.g);
  for (int i = 0; i < n; ++i) {
    const std::string number = std::to_string(i);
    const double m = random_number(0.5, 3), inertia = random_number(0.2, 2);
    const double theta = random_number(-3, 3), omega = random_number(-2, 2);
    const Vector2d x = random_vector(2), v = random_vector(2);
    const auto b = scene.system.add_body("body" + number, m, inertia, x, theta, v, omega);
    const Vector2d u1 = random_vector(), u2 = random_vector();
    const double kind = random_number(0, 4);
    if (i == 0) {
      scene.add("pin" + number, Revolute{u1, u2}, b, System::world);
    } else if (kind < 2) {
      scene.add("pin" + number, Revolute{u1, u2}, b, body());
    } else if (kind < 3) {
      scene.add("rail" + number, Prismatic{u1, u2, rotation(kind).col(0), 0.1}, body(), b);
    } else {
      const Vector2d x_bead = random_vector(2), v_bead = random_vector(2);
      const auto p = scene.system.add_particle("bead" + number, m / 2, x_bead, v_bead);
      scene.add("rod_to" + number, Distance{0.7, u1}, body(), p);
      scene.add("rod_from" + number, Distance{0.9, u2}, b, p);
      if (kind < 3.5) scene.add("curve" + number, OnCurve<Parabola>{{0.5}}, p);
    }
    bodies.push_back(b);
  }
  for (int i = 0; i < loops; ++i) {
    const auto a = body(), b = body();
    if (a.index != b.index)
      scene.add("loop" + std::to_string(i), Distance{0.5, random_vector()}, a, b);
  }
  // From outside: a couple on one body, a force on another.
  scene.F_constant = VectorXd::Zero(scene.system.initial_q().size());
  scene.F_constant.segment<3>(bodies[0].column) = Vector3d(1, -2, 3);
  scene.system.apply(bodies[0], {1, -2, 3});
}

// The slider-crank, its lengths and masses in any unit, turned and moved as a whole.
struct SliderCrank {
  double crank = 0.3, rod = 1, theta = pi / 4, length = 1, mass = 1, phi = 0;
  Vector2d shift = Vector2d::Zero();
  bool folded = false;  // the slider on the near side of the crank pin
  bool simulated_frame = false;
  bool second_rail = false;

  struct Handles {
    Handle<Body> frame, wheel, rod, slider;
    JointHandle wheel_frame, rod_wheel, slider_rod, slider_frame;
  };

  Handles build(Scene& scene) const {
    const Matrix2d R = rotation(phi);
    const auto place = [&](double x, double y) {
      return Vector2d(R * (length * Vector2d(x, y)) + shift);
    };
    const double height = crank * std::sin(theta);
    const double angle = folded ? pi + std::asin(height / rod) : -std::asin(height / rod);
    const double x_pin = crank * std::cos(theta), x_slider = x_pin + rod * std::cos(angle);
    const double inertia = mass * length * length;
    Evaluated& s = scene.system;
    Handles h;
    h.wheel = s.add_body("wheel", 2 * mass, 0.16 * inertia, place(0, 0), phi + theta);
    h.rod = s.add_body("rod", mass, inertia * rod * rod / 12,
                       place(x_pin + rod / 2 * std::cos(angle), height + rod / 2 * std::sin(angle)),
                       phi + angle);
    h.slider = s.add_body("slider", 1.5 * mass, 0.01625 * inertia, place(x_slider, 0), phi);
    const Vector2d u_rod(length * rod / 2, 0), u_crank(length * crank, 0);
    h.rod_wheel = scene.add("rod_wheel", Revolute{-u_rod, u_crank}, h.rod, h.wheel);
    h.slider_rod = scene.add("slider_rod", Revolute{{0, 0}, u_rod}, h.slider, h.rod);
    if (simulated_frame) {
      h.frame = s.add_body("frame", 10 * mass, inertia, place(0, 0), phi);
      scene.add("frame_ground", Ground{place(0, 0), phi}, h.frame);
      h.wheel_frame = scene.add("wheel_frame", Revolute{}, h.wheel, h.frame);
      h.slider_frame = scene.add("slider_frame", Prismatic{}, h.frame, h.slider);
    } else {
      h.wheel_frame = scene.add("wheel_frame", Revolute{{0, 0}, place(0, 0)}, h.wheel, s.world);
      h.slider_frame = scene.add("slider_frame", Prismatic{place(0, 0), {0, 0}, R.col(1), phi},
                                 s.world, h.slider);
      if (second_rail)
        scene.add("second_rail", Prismatic{place(2, 0), {0, 0}, R.col(1), phi}, s.world, h.slider);
    }
    scene.g = R * Vector2d(0, 9.81 * length);
    s.set_gravity(scene.g);
    s.apply(h.wheel, {0, 0, 2 * inertia});
    scene.F_constant = VectorXd::Zero(s.initial_q().size());
    scene.F_constant[h.wheel.column + 2] = 2 * inertia;
    return h;
  }
};

// N links in a row from the origin along x, pinned at one end or at both, at rest.
void chain(Scene& scene, int n, bool both_ends, double angle = 0) {
  const double l = 1.0 / n, m = 1.0 / n;
  scene.g = {0, 9.81};
  scene.system.set_gravity(scene.g);
  Handle<Body> last;
  const Vector2d e = rotation(angle).col(0);
  for (int i = 0; i < n; ++i) {
    const std::string number = std::to_string(i);
    const auto link =
        scene.system.add_body("link" + number, m, m * l * l / 12, (i + 0.5) * l * e, angle);
    if (i == 0)
      scene.add("pin" + number, Revolute{{-l / 2, 0}, {0, 0}}, link, System::world);
    else
      scene.add("pin" + number, Revolute{{-l / 2, 0}, {l / 2, 0}}, link, last);
    last = link;
  }
  if (both_ends) scene.add("end", Revolute{{l / 2, 0}, e}, last, System::world);
}

VectorXd random_velocity(Evaluated& s) {
  VectorXd v(s.initial_q().size());
  for (double& x : v) x = random_number(-1, 1);
  return v;
}

}  // namespace

TEST_CASE("accelerations and lambda are those of a dense reference") {
  for (int i = 0; i < 200; ++i) {
    Scene scene;
    random_mechanism(scene, 2 + i % 12, i % 3);
    if (i % 2) {
      scene.ks = 100;
      scene.kd = 20;
      scene.system.set_feedback(scene.ks, scene.kd);
    }
    const VectorXd q = scene.system.initial_q(), v = scene.system.initial_v();
    VectorXd C, Jdot_v, lambda, lambda_system;
    MatrixXd J;
    scene.rows(q, v, C, J, Jdot_v);
    // Only mechanisms that are far from singular, so that rounding is not the subject.
    const MatrixXd K = J * scene.system.W().asDiagonal() * J.transpose();
    const VectorXd eigenvalues = K.selfadjointView<Eigen::Lower>().eigenvalues();
    if (eigenvalues.minCoeff() < 4e-4 * eigenvalues.maxCoeff()) continue;

    const VectorXd a = acceleration(scene.system, q, v);
    const VectorXd a_reference = scene.reference(q, v, &lambda);
    CHECK(relative(a, a_reference) < 2e-12);
    lambda_system.resize(lambda.size());
    for (int j = 0, row = 0; row < lambda.size(); ++j) {
      const VectorXd part = scene.system.lambda(scene.system.joint(j));
      lambda_system.segment(row, part.size()) = part;
      row += int(part.size());
    }
    CHECK(relative(lambda_system, lambda) < 2e-12);
    // Each row obeys Cddot + kd Cdot + ks C = 0.
    const VectorXd Cddot = J * a + Jdot_v;
    CHECK((Cddot + scene.kd * J * v + scene.ks * C).lpNorm<Eigen::Infinity>() <
          1e-12 * std::max(Jdot_v.lpNorm<Eigen::Infinity>(), (J * a).lpNorm<Eigen::Infinity>()) +
              1e-11);
    CHECK(scene.system.counts().rank == C.size());
    CHECK(scene.system.dependent_rows().empty());
    CHECK((scene.system.jacobian(q) - J).norm() == 0);
  }
}

TEST_CASE("one particle on the parabola has chapter 1's lambda") {
  const double p = 50, m = 1.3, x = 40, vx = 7, fx = 3, g = 9.81;
  Evaluated s;
  s.set_gravity({0, g});
  const auto bead = s.add_particle("bead", m, {x, -x * x / (2 * p)}, {vx, -x * vx / p});
  s.apply(bead, {fx, 0});
  const auto curve = s.add("curve", OnCurve<Parabola>{{p}}, bead);
  const VectorXd a = acceleration(s, s.initial_q(), s.initial_v());
  const double lambda = -(2 * m * vx * vx + 2 * x * fx + 2 * p * m * g) / (4 * (x * x + p * p));
  CHECK(std::abs(s.lambda(curve)[0] / lambda - 1) < 1e-14);
  CHECK(std::abs(a[0] / ((fx + 2 * x * lambda) / m) - 1) < 1e-14);
  CHECK((s.reaction(curve, bead) - Vector3d(2 * x * lambda, 2 * p * lambda, 0)).norm() < 1e-12);
}

TEST_CASE("a pinned rod, a block on an incline and a held plate have their known reactions") {
  const double g = 9.81;
  SECTION("compound pendulum at any angle") {
    const double L = 1, m = 1, theta = 0.4, omega = 1.7;
    Evaluated s;
    s.set_gravity({0, g});
    const Vector2d e(std::cos(theta), std::sin(theta)), t(-e.y(), e.x());
    const auto rod =
        s.add_body("rod", m, m * L * L / 12, L / 2 * e, theta, omega * L / 2 * t, omega);
    const auto pin = s.add("pin", Revolute{{-L / 2, 0}, {0, 0}}, rod, s.world);
    const VectorXd a = acceleration(s, s.initial_q(), s.initial_v());
    const double alpha = 1.5 * g / L * std::cos(theta);
    CHECK(std::abs(a[2] - alpha) < 1e-13);
    const Vector2d force = m * (alpha * L / 2 * t - omega * omega * L / 2 * e - Vector2d(0, g));
    const Vector3d reaction = s.reaction(pin, rod);
    CHECK((reaction.head<2>() - force).norm() < 1e-13);
    CHECK(std::abs(reaction[2] - m * L * L / 12 * alpha) < 1e-13);
    CHECK(s.reaction(pin, s.world).norm() == 0);
  }
  SECTION("incline") {
    const double incline = pi / 6, m = 1;
    Evaluated s;
    s.set_gravity({0, g});
    const Matrix2d R = rotation(incline);
    const auto block = s.add_body("block", m, m * 0.05 / 12, {0, 0}, incline);
    const auto rail = s.add("rail", Prismatic{{0, 0}, {0, 0}, R.col(1), incline}, s.world, block);
    const VectorXd a = acceleration(s, s.initial_q(), s.initial_v());
    CHECK((a.head<2>() - g * std::sin(incline) * R.col(0)).norm() < 1e-14);
    CHECK(a[2] == 0);
    CHECK((s.reaction(rail, block).head<2>() + m * g * std::cos(incline) * R.col(1)).norm() <
          1e-14);
    CHECK(std::abs(s.reaction(rail, block)[2]) < 1e-15);
  }
  SECTION("plate: the reaction is minus the load and its moment, at any time") {
    Evaluated s;
    s.set_gravity({0, g});
    const auto plate = s.add_body("plate", 2, 2 * 0.52 / 12, {0.1, 0.2});
    const auto ground = s.add("ground", Ground{{0.1, 0.2}, 0}, plate);
    s.apply(plate, [](double t, const Body& b) {
      const double fy = 5 * std::sin(2 * t);
      return Vector3d(0, fy, 0.3 * std::cos(b.theta) * fy);
    });
    for (double t : {0.0, 0.7, 3.1}) {
      const VectorXd a = acceleration(s, s.initial_q(), s.initial_v(), t);
      const double fy = 5 * std::sin(2 * t);
      CHECK(a.norm() < 1e-14);
      CHECK((s.reaction(ground, plate) + Vector3d(0, 2 * g + fy, 0.3 * fy)).norm() < 1e-14);
    }
  }
}

TEST_CASE("energy is kinetic plus the potentials, and constraint forces do no work on it") {
  const double k = 40;
  Scene scene;
  const auto h = SliderCrank{}.build(scene);
  Evaluated& s = scene.system;
  s.apply(h.wheel, {0, 0, -2});  // takes the torque away again
  s.apply(
      h.slider, [k](double, const Body& b) { return Vector3d(-k * (b.x.x() - 1), 0, 0); },
      [k](const Body& b) { return k / 2 * (b.x.x() - 1) * (b.x.x() - 1); });
  VectorXd q = s.initial_q(), v = s.initial_v();
  const Vector2d rod = q.segment<2>(h.rod.column);
  const double stretch = q[h.slider.column] - 1;
  const double E = s.energy(q, v);
  CHECK(std::abs(E - (-9.81 * rod.y() + k / 2 * stretch * stretch)) < 1e-14);
  for (int i = 0; i < 500; ++i) rk4(s, 1e-3, q, v);
  CHECK(std::abs(s.energy(q, v) - E) < 1e-9);
  CHECK(std::abs(v[h.wheel.column + 2]) > 0.1);
  // At every instant the reactions' power is zero, to rounding.
  s.project(q, v);
  acceleration(s, q, v);
  double power = 0, size = 0;
  const auto add = [&](JointHandle joint, Handle<Body> body) {
    const double p = s.reaction(joint, body).dot(v.segment<3>(body.column));
    power += p;
    size += std::abs(p);
  };
  add(h.wheel_frame, h.wheel);
  add(h.rod_wheel, h.wheel);
  add(h.rod_wheel, h.rod);
  add(h.slider_rod, h.rod);
  add(h.slider_rod, h.slider);
  add(h.slider_frame, h.slider);
  CHECK(std::abs(power) < 1e-13 * size);
}

TEST_CASE("a chain of N links stores and costs O(N)") {
  for (int n : {1, 2, 10, 100, 1000}) {
    Scene scene;
    chain(scene, n, false, 0.3);
    acceleration(scene.system, scene.system.initial_q(), scene.system.initial_v());
    const Counts counts = scene.system.counts();
    CHECK(counts.factor_blocks == 2 * n - 1);
    CHECK(counts.jacobian_blocks == 2 * n - 1);
    CHECK(counts.rows == 2 * n);
  }
  const auto best = [](int n) {  // [s] of an acceleration
    Scene scene;
    chain(scene, n, false, 0.3);
    const VectorXd q = scene.system.initial_q(), v = scene.system.initial_v();
    VectorXd a(q.size());
    double least = 1e300;
    for (int i = 0; i < 50; ++i) {
      const auto start = std::chrono::steady_clock::now();
      scene.system.acceleration(0, q, v, a);
      const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
      least = std::min(least, time.count());
    }
    return least;
  };
  CHECK(best(1000) < 30 * best(100));  // 100 times with N², 1000 with N³
}

TEST_CASE("a long chain agrees with the dense reference") {
  Scene scene;
  chain(scene, 40, false, 0.3);
  VectorXd q = scene.system.initial_q(), v = scene.system.initial_v();
  CHECK(relative(acceleration(scene.system, q, v), scene.reference(q, v)) < 1e-11);
}

TEST_CASE("the slider-crank by hand count, and the ground left out") {
  Scene with, without;
  SliderCrank crank;
  const auto h0 = crank.build(without);
  crank.simulated_frame = true;
  const auto h1 = crank.build(with);
  VectorXd q0 = without.system.initial_q(), v0 = without.system.initial_v();
  VectorXd q1 = with.system.initial_q(), v1 = with.system.initial_v();
  acceleration(without.system, q0, v0);
  acceleration(with.system, q1, v1);

  const Counts c1 = with.system.counts(), c0 = without.system.counts();
  CHECK((c1.rows == 11 && c1.coordinates == 12 && c1.rank == 11 && c1.degrees_of_freedom == 1));
  CHECK((c0.rows == 8 && c0.coordinates == 9 && c0.rank == 8 && c0.degrees_of_freedom == 1));
  // frame_ground 1, the others 2 each; on the world's side of a joint stands nothing.
  CHECK(c1.jacobian_blocks == 9);
  CHECK(c0.jacobian_blocks == 6);
  // 4 joints in a row: 4 blocks on the diagonal, 3 beside it, no fill.
  CHECK(c0.factor_blocks == 7);
  // Joints in a ring (4) and the ground, which shares the frame with two of them: 5 + 6, and one
  // fill-in when the ring is cut (or none, as ground couples these two already).
  CHECK(c1.factor_blocks >= 11);
  CHECK(c1.factor_blocks <= 12);
  CHECK(c0.state_bytes == 2 * 9 * sizeof(double));

  for (int i = 0; i < 500; ++i) {
    rk4(without.system, 1e-3, q0, v0);
    rk4(with.system, 1e-3, q1, v1);
  }
  CHECK((q0 - q1.head(9)).norm() < 1e-12);
  CHECK((v0 - v1.head(9)).norm() < 1e-11);
  CHECK(q1.tail(3).norm() < 1e-14);
  acceleration(without.system, q0, v0);
  acceleration(with.system, q1, v1);
  CHECK((without.system.reaction(h0.wheel_frame, h0.wheel) -
         with.system.reaction(h1.wheel_frame, h1.wheel))
            .norm() < 1e-10);
}

TEST_CASE("the whole scene turned and moved gives turned accelerations") {
  Scene straight, turned;
  SliderCrank crank;
  crank.build(straight);
  crank.phi = 0.8;
  crank.shift = {3, -2};
  crank.build(turned);
  VectorXd v = random_velocity(straight.system), q = straight.system.initial_q();
  straight.system.project(q, v);
  VectorXd v_turned = v;
  const auto turn = [&](VectorXd& x) {
    for (int i = 0; i < x.size(); i += 3) x.segment<2>(i) = rotation(0.8) * x.segment<2>(i);
  };
  turn(v_turned);
  VectorXd a = acceleration(straight.system, q, v);
  turn(a);
  CHECK(relative(acceleration(turned.system, turned.system.initial_q(), v_turned), a) < 1e-12);
}

TEST_CASE("rows given twice and singular sets: the motion is right, the rows are named") {
  const auto check = [](Scene& scene, std::size_t dependent, VectorXd v = {}) {
    const VectorXd q = scene.system.initial_q();
    if (v.size() == 0) v = scene.system.initial_v();
    const VectorXd a = acceleration(scene.system, q, v);
    CHECK(relative(a, scene.reference(q, v)) < 1e-11);
    CHECK(scene.system.dependent_rows().size() == dependent);
    CHECK(scene.system.counts().rank == scene.system.counts().rows - int(dependent));
    return a;
  };
  SECTION("a joint given twice") {
    Scene once, twice;
    for (Scene* scene : {&once, &twice}) {
      scene->g = {0, 9.81};
      scene->system.set_gravity(scene->g);
      const auto rod =
          scene->system.add_body("rod", 1, 1.0 / 12, {0.5, 0}, 0, {0, 0.5}, 1);  // turning
      const Revolute pin{{-0.5, 0}, {0, 0}};
      scene->add("pin", pin, rod, System::world);
      if (scene == &twice) scene->add("again", pin, rod, System::world);
    }
    const VectorXd a = check(twice, 2);
    CHECK(relative(a, check(once, 0)) < 1e-14);
    // Of redundant rows, the one eliminated last gets none of the load.
    CHECK(twice.system.dependent_rows()[0].joint == "again");
    CHECK(twice.system.dependent_rows()[0].row == 1);
    CHECK(twice.system.dependent_rows()[1].row == 2);
    CHECK(twice.system.lambda(twice.system.joint(1)).norm() == 0);
    CHECK(relative(twice.system.lambda(twice.system.joint(0)),
                   once.system.lambda(once.system.joint(0))) < 1e-14);
  }
  SECTION("a second rail") {
    Scene scene, single;
    SliderCrank crank;
    crank.build(single);
    crank.second_rail = true;
    crank.build(scene);
    VectorXd q = single.system.initial_q(), v = random_velocity(single.system);
    single.system.project(q, v);
    check(scene, 2, v);
    CHECK(relative(acceleration(scene.system, q, v), acceleration(single.system, q, v)) < 1e-12);
  }
  SECTION("a grounded body that is also pinned and on a rail") {
    Scene scene;
    scene.g = {0, 9.81};
    scene.system.set_gravity(scene.g);
    const auto b = scene.system.add_body("plate", 2, 0.1, {0.3, 0.4});
    scene.add("ground", Ground{{0.3, 0.4}, 0}, b);
    scene.add("pin", Revolute{{0, 0}, {0.3, 0.4}}, b, System::world);
    scene.add("rail", Prismatic{{0, 0.4}}, System::world, b);
    const VectorXd a =
        acceleration(scene.system, scene.system.initial_q(), scene.system.initial_v());
    CHECK(a.norm() < 1e-14);
    CHECK(scene.system.dependent_rows().size() == 4);
  }
  SECTION("crank = rod, folded: 7 of 8 rows") {
    Scene scene;
    SliderCrank crank;
    crank.rod = 0.3;
    crank.theta = pi / 2;
    crank.folded = true;
    crank.build(scene);
    check(scene, 1);
    // A little aside the rank is full.
    Scene aside;
    crank.theta = pi / 2 - 0.01;
    crank.build(aside);
    check(aside, 0);
  }
  SECTION("a straight chain pinned at both ends") {
    for (int n : {2, 5, 20}) {
      Scene scene;
      chain(scene, n, true);
      check(scene, 1);
    }
    Scene scene;
    chain(scene, 1000, true);
    const VectorXd a =
        acceleration(scene.system, scene.system.initial_q(), scene.system.initial_v());
    CHECK(a.allFinite());
    CHECK(scene.system.dependent_rows().size() == 1);
  }
  SECTION("rows that contradict each other do not harm the rest") {
    // Two rails, one of them moving on: no motion satisfies both. Nothing is NaN.
    Scene scene;
    const auto b = scene.system.add_body("block", 1, 1, {0, 0}, 0, {3, 1}, 2);
    scene.add("rail", Prismatic{{0, 0}, {0.2, 0}}, System::world, b);
    scene.add("second", Prismatic{{0, 1}, {-0.1, 0}}, System::world, b);
    scene.system.set_feedback(100, 20);
    CHECK(
        acceleration(scene.system, scene.system.initial_q(), scene.system.initial_v()).allFinite());
    VectorXd q = scene.system.initial_q(), v = scene.system.initial_v();
    CHECK(!scene.system.project(q, v).converged);
    CHECK((q.allFinite() && v.allFinite()));
  }
  SECTION("a row whose J is zero") {
    Scene scene;
    const auto p = scene.system.add_particle("p", 1, {1, 2});
    scene.add("rod", Distance{1, {0, 0}, {1, 2}}, p, System::world);  // d = 0
    CHECK(acceleration(scene.system, scene.system.initial_q(), scene.system.initial_v()).norm() ==
          0);
    CHECK(scene.system.dependent_rows().size() == 1);
  }
}

TEST_CASE("a change of units changes nothing") {
  for (bool folded : {false, true}) {
    SliderCrank crank;
    if (folded) {
      crank.rod = 0.3;
      crank.theta = pi / 2;
      crank.folded = true;
    }
    Scene metre;
    crank.build(metre);
    VectorXd q = metre.system.initial_q(),
             v = folded ? metre.system.initial_v() : random_velocity(metre.system);
    metre.system.project(q, v);
    const VectorXd a = acceleration(metre.system, q, v);
    const std::size_t dependent = metre.system.dependent_rows().size();
    CHECK(dependent == (folded ? 1 : 0));
    for (double length : {1e-6, 1.0, 1e6})
      for (double mass : {1e-6, 1.0, 1e6}) {
        crank.length = length;
        crank.mass = mass;
        Scene scene;
        crank.build(scene);
        const auto scaled = [&](VectorXd x) {
          for (int i = 0; i < x.size(); i += 3) x.segment<2>(i) *= length;
          return x;
        };
        VectorXd q_scaled = scaled(q), v_scaled = scaled(v);
        VectorXd b = acceleration(scene.system, q_scaled, v_scaled);
        for (int i = 0; i < b.size(); i += 3) b.segment<2>(i) /= length;
        CHECK(relative(b, a) < 1e-12);
        CHECK(scene.system.dependent_rows().size() == dependent);
        CHECK(scene.system.project(q_scaled, v_scaled).converged);
      }
  }
  // Distances and curves have rows in m^2.
  VectorXd a[3];
  for (int i = 0; i < 3; ++i) {
    const double length = std::pow(1e6, i - 1);
    Scene scene;
    scene.system.set_gravity({0, 9.81 * length});
    const auto p1 = scene.system.add_particle("p1", 1, length * Vector2d(20, -4));
    const auto p2 = scene.system.add_particle("p2", 2, length * Vector2d(60, -36));
    scene.add("c1", OnCurve<Parabola>{{50 * length}}, p1);
    scene.add("c2", OnCurve<Parabola>{{50 * length}}, p2);
    scene.add("rod", Distance{length * Vector2d(40, 32).norm()}, p1, p2);
    a[i] = acceleration(scene.system, scene.system.initial_q(), scene.system.initial_v()) / length;
    CHECK(scene.system.dependent_rows().empty());
  }
  CHECK(relative(a[0], a[1]) < 1e-12);
  CHECK(relative(a[2], a[1]) < 1e-12);
}

TEST_CASE("mass ratios of 1e-8 to 1e8") {
  for (double ratio : {1e-8, 1e-4, 1e4, 1e8}) {
    Scene scene;
    scene.g = {0, 9.81};
    scene.system.set_gravity(scene.g);
    const auto upper = scene.system.add_body("upper", 1, 1.0 / 12, {0.5, 0}, 0, {0, 0.5}, 1);
    const double c = std::cos(1), s = std::sin(1);
    const auto lower =
        scene.system.add_body("lower", ratio, ratio / 12, {1 + c / 2, s / 2}, 1, {0, 1}, 0);
    scene.add("pin", Revolute{{-0.5, 0}, {0, 0}}, upper, System::world);
    scene.add("elbow", Revolute{{-0.5, 0}, {0.5, 0}}, lower, upper);
    const VectorXd q = scene.system.initial_q(), v = scene.system.initial_v();
    const VectorXd a = acceleration(scene.system, q, v);
    CHECK(scene.system.dependent_rows().empty());
    // The light link's acceleration is the small difference of two large forces, over its mass.
    CHECK(relative(a, scene.reference(q, v)) < 1e-15 * std::max(100.0, 10 * ratio));
  }
}

TEST_CASE("nothing is allocated after the first call") {
  Scene scene;
  const auto h = SliderCrank{}.build(scene);
  scene.system.set_feedback(100, 20);
  scene.system.apply(h.slider, [](double t, const Body&) { return Vector3d(std::sin(t), 0, 0); });
  VectorXd q = scene.system.initial_q(), v = scene.system.initial_v(), a(9);
  scene.system.acceleration(0, q, v, a);
  const long before = allocations();
  for (int i = 0; i < 10; ++i) scene.system.acceleration(0.1 * i, q, v, a);
  CHECK(allocations() == before);
  q.array() += 1e-4;
  v.array() += 1e-2;
  const long before_projection = allocations();
  const Projection projection = scene.system.project(q, v);
  const double E = scene.system.energy(q, v) + scene.system.constraint_error(q);
  CHECK(allocations() == before_projection);
  CHECK((projection.converged && std::isfinite(E)));
}

TEST_CASE("projection brings positions and velocities to rounding") {
  for (double size : {1e-9, 1e-6, 1e-3, 3e-2}) {
    Scene scene;
    SliderCrank{}.build(scene);
    Evaluated& s = scene.system;
    for (int i = 0; i < 20; ++i) {
      VectorXd q = s.initial_q() + size * random_velocity(s);
      VectorXd v = random_velocity(s);
      CHECK(s.project(q, v).converged);
      CHECK(s.constraint_error(q) < 1e-15);
      CHECK(s.velocity_error(q, v) < 1e-14);
      // Once more changes nothing but rounding.
      VectorXd q2 = q, v2 = v;
      CHECK(s.project(q2, v2).converged);
      CHECK((q - q2).norm() < 1e-15);
      CHECK((v - v2).norm() < 1e-14);
    }
  }
}

TEST_CASE("velocities whose energy is too small for a number are projected") {
  for (double size : {1e-150, 1e-160, 1e-170, 1e-300})
    for (int i = 0; i < 20; ++i) {
      INFO(size);
      Scene scene;
      SliderCrank{}.build(scene);
      VectorXd q = scene.system.initial_q(), v = size * random_velocity(scene.system);
      CHECK(scene.system.project(q, v).converged);
    }
}

TEST_CASE("projection is the least change in the mass metric") {
  Scene scene;
  SliderCrank crank;
  crank.phi = 0.8;
  crank.shift = {3, -2};
  crank.build(scene);
  Evaluated& s = scene.system;
  VectorXd q = s.initial_q(), v;
  // M dq and M dv lie in the range of J^T.
  const auto outside = [&](const VectorXd& d) {
    const VectorXd root = s.W().cwiseSqrt();
    const MatrixXd B = (s.jacobian(q) * root.asDiagonal()).transpose();
    const VectorXd scaled = d.cwiseQuotient(root);
    return (scaled - B * B.colPivHouseholderQr().solve(scaled)).norm() / scaled.norm();
  };
  const VectorXd v_random = random_velocity(s);
  v = v_random;
  VectorXd q_before = q;
  s.project(q, v);
  CHECK(outside(v - v_random) < 1e-12);
  CHECK((s.jacobian(q) * v).norm() < 1e-13);
  for (double size : {1e-3, 1e-5}) {
    q_before = q + size * random_velocity(s);
    VectorXd q_after = q_before;
    CHECK(s.project(q_after, v).converged);
    const VectorXd d = q_after - q_before;
    q = q_after;
    CHECK(outside(d) < 100 * size);  // J turns by as much as the correction
  }
}

TEST_CASE("projection of redundant sets, of extreme masses and of large angles") {
  SECTION("redundant") {
    Scene scene;
    SliderCrank crank;
    crank.second_rail = true;
    crank.build(scene);
    VectorXd q = scene.system.initial_q() + 1e-4 * random_velocity(scene.system);
    VectorXd v = random_velocity(scene.system);
    CHECK(scene.system.project(q, v).converged);
    CHECK(scene.system.constraint_error(q) < 1e-15);
    CHECK(scene.system.velocity_error(q, v) < 1e-14);
  }
  SECTION("a light chain with a heavy end") {
    Scene scene;
    chain(scene, 20, false, 0.3);
    const auto load = scene.system.add_particle("load", 1e8, rotation(0.3).col(0));
    scene.add("hook", Revolute{{0, 0}, {0.025, 0}}, load, scene.system.thing<Body>("link19"));
    VectorXd q = scene.system.initial_q() + 1e-9 * random_velocity(scene.system);
    VectorXd v = random_velocity(scene.system);
    CHECK(scene.system.project(q, v).converged);
    CHECK(scene.system.constraint_error(q) < 1e-14);
    CHECK(scene.system.velocity_error(q, v) < 1e-10);  // epsilon, in the mass metric
  }
  SECTION("after 1e6 rad") {
    Scene scene;
    const auto h = SliderCrank{}.build(scene);
    VectorXd q = scene.system.initial_q(), v = scene.system.initial_v();
    q[h.wheel.column + 2] += std::round(1e6 / (2 * pi)) * 2 * pi;
    CHECK(scene.system.project(q, v).converged);
    CHECK(scene.system.constraint_error(q) < 1e-10);
  }
}

TEST_CASE("a mechanism passes its singular pose with its energy") {
  Scene scene;
  SliderCrank crank;
  crank.rod = 0.3;
  const auto h = crank.build(scene);
  Evaluated& s = scene.system;
  s.apply(h.wheel, {0, 0, -2});
  s.set_gravity(Vector2d::Zero());
  VectorXd q = s.initial_q(), v = s.initial_v();
  v[h.wheel.column + 2] = 25;
  s.assemble(q, v);
  const double E = s.energy(q, v);
  double C = 0;
  for (int i = 0; i < 2000; ++i) {
    rk4(s, 1e-3, q, v);
    s.project(q, v);
    C = std::max(C, s.constraint_error(q));
  }
  CHECK(q[h.wheel.column + 2] > 2 * pi);
  // How near a stage comes to the pose, and so what rounding does there, hangs on the last digit:
  // 1e-7, or 7e-6 where products and sums are fused.
  CHECK(std::abs(s.energy(q, v) / E - 1) < 1e-4);
  CHECK(C < 1e-12);
}

TEST_CASE("assembly: left alone, projected, or refused") {
  Scene scene;
  SliderCrank{}.build(scene);
  Evaluated& s = scene.system;
  SECTION("already closed: left as it is, bit for bit") {
    VectorXd q = s.initial_q(), v = s.initial_v();
    const Assembly report = s.assemble(q, v);
    CHECK(!report.projected);
    CHECK(report.moved == 0);
    CHECK((q - s.initial_q()).norm() == 0);
    CHECK(v.norm() == 0);
  }
  SECTION("off: projected, and told by how much") {
    for (double size : {1e-6, 1e-2, 0.1}) {
      const VectorXd start = s.initial_q() + size * VectorXd::Random(9);
      VectorXd q = start, v = random_velocity(s);
      const Assembly report = s.assemble(q, v);
      CHECK(report.projected);
      CHECK(report.moved == (q - start).lpNorm<Eigen::Infinity>());
      CHECK((report.moved > 0.1 * size && report.moved < 10 * size));
      CHECK((report.C_before > 1e-2 * size && s.constraint_error(q) < 1e-15));
      CHECK((report.Jv_before > 1e-2 && s.velocity_error(q, v) < 1e-14));
    }
  }
  SECTION("from far away") {
    for (int i = 0; i < 50; ++i) {
      VectorXd q = s.initial_q() + 2 * random_velocity(s), v = s.initial_v();
      try {
        s.assemble(q, v);
        CHECK(s.constraint_error(q) < 1e-13);
      } catch (const AssemblyError& error) {
        FAIL_CHECK("a slider-crank that can be closed was refused: " << error.what());
      }
    }
  }
}

TEST_CASE("assembly: what cannot be closed is refused with the joint's name") {
  Scene scene;
  Evaluated& s = scene.system;
  // Pins 1 m apart on the world, a rod of 0.88 m between them: 0.12 m too short.
  const auto rod = s.add_body("rod", 1, 0.1, {0.5, 0.1}, 0.2);
  scene.add("left", Revolute{{-0.44, 0}, {0, 0}}, rod, System::world);
  scene.add("right", Revolute{{0.44, 0}, {1, 0}}, rod, System::world);
  VectorXd q = s.initial_q(), v = s.initial_v();
  try {
    s.assemble(q, v);
    FAIL("assembled a rod that is too short");
  } catch (const AssemblyError& error) {
    // The gap is shared equally between the two pins.
    const std::string message = error.what();
    CHECK((message == "cannot assemble: left row 1 (m) stays open by 0.06" ||
           message == "cannot assemble: right row 1 (m) stays open by 0.06"));
  }
  CHECK((q - s.initial_q()).norm() == 0);

  // A slider-crank whose rod is shorter than the crank, the crank held upright.
  Scene crank;
  SliderCrank short_rod;
  const auto h = short_rod.build(crank);
  crank.add("hold", Ground{{0, 0}, pi / 2}, h.wheel);
  crank.add("short", Distance{0.2}, h.slider, h.wheel);
  q = crank.system.initial_q();
  v = crank.system.initial_v();
  try {
    crank.system.assemble(q, v);
    FAIL("assembled a rod that is too short");
  } catch (const AssemblyError& error) {
    const std::string message = error.what();
    CHECK(message.find("cannot assemble: ") == 0);
    CHECK(message.find(" stays open by 0") != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
    CHECK(message.find("nan") == std::string::npos);
  }
}

TEST_CASE("unusable input is refused, and NaN neither crashes nor hangs") {
  Evaluated s;
  CHECK_THROWS_AS(s.add_particle("p", 0, {0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(s.add_body("b", 1, -1, {0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(s.add_body("b", std::nan(""), 1, {0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(s.add_body("b", INFINITY, 1, {0, 0}), std::invalid_argument);
  const auto b = s.add_body("b", 1, 1, {0, 0});
  CHECK_THROWS_AS(s.add("self", Revolute{}, b, b), std::invalid_argument);

  for (double bad : {std::nan(""), double(INFINITY), 1e300, -1e200}) {
    Scene scene;
    SliderCrank{}.build(scene);
    for (int k = 0; k < 9; ++k) {
      VectorXd q = scene.system.initial_q(), v = scene.system.initial_v();
      q[k] = bad;
      acceleration(scene.system, q, v);
      if (std::isfinite(bad)) {
        scene.system.project(q, v);
      } else {
        CHECK(!scene.system.project(q, v).converged);
        CHECK_THROWS_AS(scene.system.assemble(q, v), AssemblyError);
      }
      q = scene.system.initial_q();
      v[k] = bad;
      const bool converged = scene.system.project(q, v).converged;
      CHECK((std::isfinite(bad) || !converged));
    }
  }
}

TEST_CASE("a system without joints is free") {
  Evaluated s;
  s.set_gravity({0, 9.81});
  s.add_particle("p", 2, {0, 0});
  VectorXd q = s.initial_q(), v = s.initial_v();
  CHECK((acceleration(s, q, v) - Vector2d(0, 9.81)).norm() == 0);
  CHECK(s.project(q, v).converged);
  CHECK(!s.assemble(q, v).projected);
  CHECK(s.constraint_error(q) == 0);
}

// ---- Misuse: what is refused, and in which words ----

namespace {

// A pendulum, a bead on a rod at its end, and a block that nothing holds: all kinds of things.
struct Misused {
  Evaluated s;
  Handle<Body> rod = s.add_body("rod", 1, 1.0 / 12, {0.5, 0});
  Handle<Particle> bead = s.add_particle("bead", 2, {1, 1});
  Handle<Body> block = s.add_body("block", 1, 1, {3, 4});
  JointHandle pin = s.add("pin", Revolute{{-0.5, 0}, {0, 0}}, rod);
  JointHandle tie = s.add("tie", Distance{1, {0.5, 0}}, rod, bead);

  VectorXd q() const { return s.initial_q(); }
  VectorXd v() const { return s.initial_v(); }
};

// What f throws: its words, where it is an E.
template <class E, class F>
std::string refused(F&& f) {
  try {
    f();
  } catch (const E& error) {
    return error.what();
  } catch (const std::exception& error) {
    return std::string("of another type: ") + error.what();
  }
  return "nothing thrown";
}
template <class F>
std::string refused(F&& f) {
  return refused<std::invalid_argument>(f);
}
bool starts(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

// Every function of q and v, by name; each gives numbers that must show what is not finite.
using Query = std::function<VectorXd(Evaluated&, VectorXd&, VectorXd&)>;
const std::vector<std::pair<std::string, Query>> queries{
    {"acceleration", [](Evaluated& s, VectorXd& q, VectorXd& v) { return acceleration(s, q, v); }},
    {"energy", [](auto& s, auto& q, auto& v) { return VectorXd::Constant(1, s.energy(q, v)); }},
    {"forces", [](auto& s, auto& q, auto& v) { return s.forces(0, q, v); }},
    {"drive",
     [](auto& s, auto& q, auto& v) { return VectorXd::Constant(1, s.drive(s.forces(0, q, v))); }},
    {"velocity_error",
     [](auto& s, auto& q, auto& v) { return VectorXd::Constant(1, s.velocity_error(q, v)); }},
    {"state",
     [](auto& s, auto& q, auto& v) {
       VectorXd all(8);
       const auto rod = s.state(s.template thing<Body>("rod"), q, v),
                  block = s.state(s.template thing<Body>("block"), q, v);
       const auto bead = s.state(s.template thing<Particle>("bead"), q, v);
       all << rod.x + rod.v, rod.theta + rod.omega, bead.x + bead.v, block.x + block.v,
           block.theta + block.omega;
       return all;
     }},
};
const std::vector<std::pair<std::string, Query>> queries_of_q{
    {"distance", [](auto& s, auto& q, auto&) { return VectorXd::Constant(1, s.distance(q)); }},
    {"constraint_error",
     [](auto& s, auto& q, auto&) { return VectorXd::Constant(1, s.constraint_error(q)); }},
    {"jacobian",
     [](auto& s, auto& q, auto&) {
       const MatrixXd J = s.jacobian(q);
       return VectorXd(J.reshaped());
     }},
};
const std::vector<std::pair<std::string, Query>> queries_of_v{
    {"kinetic_energy",
     [](auto& s, auto&, auto& v) { return VectorXd::Constant(1, s.kinetic_energy(v)); }},
};

}  // namespace

TEST_CASE("misuse: a q or v of the wrong length is refused by every function") {
  Misused m;
  m.s.set_gravity({0, 9.81});
  std::vector<std::pair<std::string, Query>> all = queries, of_q = queries_of_q,
                                             of_v = queries_of_v;
  all.emplace_back("project", [](Evaluated& s, VectorXd& q, VectorXd& v) {
    s.project(q, v);
    return q;
  });
  all.emplace_back("assemble", [](Evaluated& s, VectorXd& q, VectorXd& v) {
    s.assemble(q, v);
    return q;
  });
  of_v.emplace_back("kinetic_energy of a thing", [](Evaluated& s, VectorXd&, VectorXd& v) {
    return VectorXd::Constant(1, s.kinetic_energy(s.things().back(), v));
  });
  const auto check = [&](const auto& functions, bool wrong_q, bool wrong_v) {
    for (const auto& function : functions)
      for (const int length : {0, 1, 7, 9, 1000})
        for (const double value : {0.0, std::nan("")}) {
          INFO(function.first << " of " << length << " numbers " << value);
          VectorXd q = wrong_q ? VectorXd::Constant(length, value) : m.q();
          VectorXd v = wrong_v ? VectorXd::Constant(length, value) : m.v();
          const VectorXd q_before = q, v_before = v;
          const std::string words = refused([&] { function.second(m.s, q, v); });
          CHECK(words == "q and v must have one entry for each coordinate");
          CHECK((q.size() == q_before.size() && v.size() == v_before.size()));
        }
  };
  check(all, true, false);
  check(all, false, true);
  check(of_q, true, false);
  check(of_v, false, true);
  // What is only written gets its length.
  VectorXd a(3);
  m.s.acceleration(0, m.q(), m.v(), a);
  CHECK(a.size() == 8);
}

TEST_CASE("misuse: what is not finite in q or v shows in every answer") {
  for (const double bad : {std::nan(""), double(INFINITY), -double(INFINITY)})
    for (int k = 0; k < 8; ++k) {  // also a coordinate that no joint and no force knows
      const auto check = [&](const auto& functions, bool in_q, bool in_v) {
        for (const auto& [name, ask] : functions) {
          INFO(name << ", entry " << k << (in_q ? " of q " : " of v ") << bad);
          Misused m;
          VectorXd q = m.q(), v = m.v();
          if (in_q) q[k] = bad;
          if (in_v) v[k] = bad;
          CHECK(!ask(m.s, q, v).allFinite());
          CHECK(ask(m.s, q = m.q(), v = m.v()).allFinite());  // and is gone with it
        }
      };
      check(queries, true, false);
      check(queries, false, true);
      check(queries_of_q, true, false);
      check(queries_of_v, false, true);
      Misused m;
      VectorXd q = m.q(), v = m.v();
      q[k] = bad;
      CHECK(!m.s.project(q, v).converged);
      CHECK(refused<AssemblyError>([&] { m.s.assemble(q, v); }) ==
            "cannot assemble: q and v must be finite");
      q = m.q();
      v[k] = bad;
      CHECK(!m.s.project(q, v).converged);
      CHECK(refused<AssemblyError>([&] { m.s.assemble(q, v); }) ==
            "cannot assemble: q and v must be finite");
    }
}

TEST_CASE("misuse: a handle of another System, or of none, is refused") {
  Misused m, other;
  acceleration(m.s, m.q(), m.v());
  acceleration(other.s, other.q(), other.v());
  const auto body_refused = [&](Evaluated& s, Handle<Body> body, JointHandle joint) {
    const std::string of_another = ": a handle of another System, or of none";
    CHECK(refused([&] { s.add("new", Revolute{}, body); }) == "new" + of_another);
    CHECK(refused([&] { s.add("new", Prismatic{}, System::world, body); }) == "new" + of_another);
    CHECK(refused([&] { s.apply(body, {1, 2, 3}); }) == "apply" + of_another);
    const auto law = [](double, const Body&) -> Vector3d { return {1, 2, 3}; };
    CHECK(refused([&] { s.apply(body, law); }) == "apply" + of_another);
    CHECK(refused([&] { s.state(body, s.initial_q(), s.initial_v()); }) == "state" + of_another);
    CHECK(refused([&] { s.reaction(s.joint(0), body); }) == "reaction" + of_another);
    CHECK(refused([&] { s.reaction(joint, System::world); }) == "reaction" + of_another);
    CHECK(refused([&] { s.lambda(joint); }) == "lambda" + of_another);
  };
  body_refused(m.s, other.rod, other.pin);
  body_refused(other.s, m.block, m.tie);
  body_refused(m.s, Handle<Body>{}, JointHandle{});
  body_refused(m.s, Handle<Body>{0, 0}, JointHandle{0});
  CHECK(refused([&] { m.s.joint(2); }) == "joint 2: there is none");
  CHECK(refused([&] { m.s.thing<Body>("bead"); }) == "bead: no thing of this kind has that name");
  CHECK(refused([&] { m.s.thing<Body>("no"); }) == "no: no thing of this kind has that name");
  CHECK(m.s.thing<Body>("block").column == m.block.column);
  CHECK(m.s.thing<Particle>("bead").index == m.bead.index);

  // A refused call leaves the scene as it was.
  CHECK(m.s.rows() == 3);
  CHECK(acceleration(m.s, m.q(), m.v()).norm() == 0);

  // Handles go along when their System is moved; what is left of it does not know them.
  m.s.set_gravity({0, 9.81});
  const VectorXd a = acceleration(m.s, m.q(), m.v());
  const Vector3d reaction = m.s.reaction(m.pin, m.rod);
  CHECK(reaction.norm() > 1);
  Evaluated moved = std::move(m.s);
  CHECK(acceleration(moved, moved.initial_q(), moved.initial_v()) == a);
  CHECK(moved.reaction(m.pin, m.rod) == reaction);
  m.s = Evaluated();
  m.s.add("pin", Revolute{}, m.s.add_body("rod", 1, 1, {0, 0}));
  acceleration(m.s, m.q(), m.v());
  body_refused(m.s, m.rod, m.pin);
  other.s = std::move(moved);
  acceleration(other.s, other.s.initial_q(), other.s.initial_v());
  CHECK(other.s.reaction(m.pin, m.rod) == reaction);
  body_refused(other.s, other.rod, other.pin);
}

TEST_CASE("misuse: what was not evaluated cannot be asked") {
  Misused m;
  m.s.set_gravity({0, 9.81});
  VectorXd q = m.q(), v = m.v(), there = q;
  there[2] += 0.3;
  Evaluation& e = m.s.e;
  const auto silent = [&] {
    for (const std::function<void()>& ask : std::vector<std::function<void()>>{
             [&] { e.a(); }, [&] { e.C(); }, [&] { e.lambda(m.pin); },
             [&] { e.reaction(m.pin, m.rod); }, [&] { e.dependent_rows(); }, [&] { e.worst_row(); },
             [&] { e.weakest_row(); }, [&] { e.counts(); }, [&] { e.constraint_error(); },
             [&] { e.velocity_error(v); }, [&] { e.distance(); }, [&] { e.opening(); },
             [&] { e.jacobian(); }})
      CHECK(starts(refused<std::logic_error>(ask), "asked of an evaluation"));
  };
  silent();  // before the first
  // Released level, the rod and what hangs on it: moments about the pin give the first pull.
  acceleration(m.s, q, v);
  const Vector3d reaction = e.reaction(m.pin, m.rod);
  CHECK(e.counts().rank == 3);
  m.s.project(there, v);  // borrows it
  silent();
  acceleration(m.s, q, v);
  CHECK((e.reaction(m.pin, m.rod) - reaction).norm() < 1e-12);
}

TEST_CASE("an evaluation keeps what it was told, whatever becomes of the scene") {
  Misused m;
  m.s.set_gravity({0, 9.81});
  const VectorXd q = m.q(), v = m.v();
  VectorXd there = q;
  there[2] += 0.3;
  const VectorXd a = acceleration(m.s, q, v);
  const Vector3d reaction = m.s.e.reaction(m.pin, m.rod);
  const Evaluation kept = m.s.e;
  const auto unchanged = [&] {
    CHECK(kept.a() == a);
    CHECK(kept.reaction(m.pin, m.rod) == reaction);
    CHECK(kept.counts().rank == 3);
    CHECK(kept.constraint_error() < 1e-15);
  };
  for (const std::function<void()>& change : std::vector<std::function<void()>>{
           [&] { m.s.energy(there, v); }, [&] { m.s.drive(m.s.forces(0, there, v)); },
           [&] { m.s.constraint_error(there); }, [&] { m.s.jacobian(there); },
           [&] {
             m.s.set_gravity({0, 1});
           },
           [&] {
             m.s.apply(m.rod, {0, 0, 1});
           },
           [&] {
             m.s.add("late", Ground{{3, 4}}, m.block);
           },
           [&] {
             m.s.add_particle("late", 1, {0, 0});
           }}) {
    change();
    unchanged();
  }
  CHECK(m.s.at(m.s.initial_q(), m.s.initial_v()).a().size() == q.size() + 2);  // laid out anew
  Evaluated other;
  other.add_particle("p", 1, {0, 0});
  CHECK(refused([&] {
          Evaluation e = kept;
          other.evaluate(0, other.initial_q(), other.initial_v(), e);
        }) == "an Evaluation of another System, or of none");
  m.s = Evaluated();
  unchanged();
}

TEST_CASE("misuse: a scene without joints has no rows") {
  Evaluated free;
  free.add_particle("p", 1, {0, 0});
  acceleration(free, free.initial_q(), free.initial_v());
  CHECK(refused<std::logic_error>([&] { free.worst_row(); }) ==
        "a scene without joints has no rows");
  CHECK(refused<std::logic_error>([&] { free.weakest_row(); }) ==
        "a scene without joints has no rows");
}

TEST_CASE("misuse: numbers that cannot be computed with are refused by the thing's name") {
  const double nan = std::nan(""), inf = INFINITY;
  const auto thing = [](double mass, double inertia, const Vector2d& x = {0, 0}, double theta = 0,
                        const Vector2d& v = {0, 0}, double omega = 0) {
    Evaluated s;
    const std::string before =
        refused([&] { s.add_body("plate", mass, inertia, x, theta, v, omega); });
    // Nothing of it is left, and the name is free.
    if (starts(before, "plate: ")) {
      s.add_body("plate", 1, 1, {0, 0});
      CHECK(s.things().size() == 1);
    }
    return before;
  };
  const std::string masses =
      "plate: mass and inertia must be positive and finite, and so must be their inverses";
  for (const double bad : {0.0, -0.0, -1.0, nan, inf, -inf, 1e-309, 5e-324, 1e308}) {
    CHECK(thing(bad, 1) == masses);
    CHECK(thing(1, bad) == masses);
  }
  for (const double good : {1e-300, 1e-8, 1.0, 1e300}) CHECK(thing(good, good) == "nothing thrown");
  const std::string places = "plate: must start at a finite place with a finite velocity";
  for (const double bad : {nan, inf, -inf}) {
    CHECK(thing(1, 1, {bad, 0}) == places);
    CHECK(thing(1, 1, {0, bad}) == places);
    CHECK(thing(1, 1, {0, 0}, bad) == places);
    CHECK(thing(1, 1, {0, 0}, 0, {0, bad}) == places);
    CHECK(thing(1, 1, {0, 0}, 0, {0, 0}, bad) == places);
  }

  const std::string loads = ": its weight and constant forces must be finite";
  Evaluated s;
  const auto heavy = s.add_body("heavy", 1e300, 1e300, {0, 0});
  const auto light = s.add_particle("light", 1, {0, 0});
  for (const double bad : {nan, inf, -inf}) {
    CHECK(refused([&] { s.set_gravity({0, bad}); }) == "gravity must be finite");
    CHECK(refused([&] { s.set_gravity({bad, 0}); }) == "gravity must be finite");
    CHECK(refused([&] { s.apply(light, {0, bad}); }) == "light" + loads);
    CHECK(refused([&] { s.apply(heavy, {0, 0, bad}); }) == "heavy" + loads);
    CHECK(refused([&] { s.set_feedback(bad, 0); }) == "the gains ks and kd must be finite");
    CHECK(refused([&] { s.set_feedback(0, bad); }) == "the gains ks and kd must be finite");
  }
  CHECK(refused([&] { s.set_gravity({0, 1e9}); }) == "heavy" + loads);
  s.set_gravity({0, 1e7});
  CHECK(refused([&] { s.add_particle("heavier", 1e302, {0, 0}); }) == "heavier" + loads);
  s.apply(heavy, {0, 1.6e308, 0});
  CHECK(refused([&] { s.apply(heavy, {0, 1.6e308, 0}); }) == "heavy" + loads);
  CHECK(refused([&] { s.set_gravity({0, 1e8}); }) == "heavy" + loads);
  CHECK(acceleration(s, s.initial_q(), s.initial_v()).allFinite());  // all as it was

  CHECK(refused([&] {
          s.add_body("light", 1, 1, {0, 0});
        }) == "light: another thing has this name");
  CHECK(refused([&] {
          s.add_particle("heavy", 1, {0, 0});
        }) == "heavy: another thing has this name");
  s.add("pin", Revolute{}, light);
  CHECK(refused([&] { s.add("pin", Ground{}, heavy); }) == "pin: another joint has this name");
  CHECK((s.things().size() == 2 && s.rows() == 2));
}

TEST_CASE("misuse: assemble never reports success over an open joint") {
  // gap: how far the joints are open in the state that it returns, relative to the scene's size,
  // which is known here by construction.
  long assembled = 0, refusals = 0;
  const auto closed_or_refused = [&](Evaluated& s, VectorXd q, const auto& gap) {
    VectorXd v = s.initial_v();
    const VectorXd before = q;
    try {
      s.assemble(q, v);
      ++assembled;
      CHECK(q.allFinite());
      CHECK(gap(q) <= 1e-6);
    } catch (const AssemblyError& error) {
      ++refusals;
      CHECK(starts(error.what(), "cannot assemble: "));
      CHECK(std::string(error.what()).find('\n') == std::string::npos);
      CHECK(q == before);
    }
  };
  for (int i = 0; i < 400; ++i) {
    const double far = std::pow(10, random_number(-300, 308)) * (i % 2 ? 1 : -1);
    const double size = i % 4 < 2 ? 1 : std::pow(10, random_number(-150, 150));
    const int entry = i % 3;
    INFO("entry " << entry << " at " << far << " in a scene of " << size << " m");
    const auto pushed = [&](const Evaluated& s) {
      VectorXd q = s.initial_q();
      q[entry] = far;
      return q;
    };
    const double I = size * size / 12;
    if (std::isnormal(I) && std::isnormal(1 / I)) {
      Evaluated pendulum;
      const auto rod = pendulum.add_body("rod", 1, I, {size / 2, 0});
      pendulum.add("pin", Revolute{{-size / 2, 0}, {0, 0}}, rod);
      closed_or_refused(pendulum, pushed(pendulum), [&](const VectorXd& q) {
        return (q.head<2>() - size / 2 * rotation(q[2]).col(0)).stableNorm() / size;
      });
      Evaluated rail;  // with an angle to hold
      const auto block = rail.add_body("block", 1, I, {0, 0});
      rail.add("rail", Prismatic{}, System::world, block);
      rail.add("rod", Distance{size, {0, 0}, {size, 0}}, block);
      closed_or_refused(rail, pushed(rail), [&](const VectorXd& q) {
        const double length = Vector2d(size - q[0], q[1]).stableNorm();
        return std::max({std::abs(length / size - 1), std::abs(q[1]) / size, std::abs(q[2])});
      });
    }
  }
  for (const double theta : {1e8, 1e10, 1e16, 1e100, 1e308}) {
    Evaluated s;
    s.add("pin", Revolute{{1, 0.7}, {0, 0}}, s.add_body("rod", 1, 1, {1, 0}, theta));
    VectorXd q = s.initial_q(), v = s.initial_v();
    CHECK(starts(refused<AssemblyError>([&] { s.assemble(q, v); }),
                 "cannot assemble: rod is turned by 1e+"));
  }
  for (const double x : {1e12, 1e17, 1e300}) {  // a rod of 1 m whose pins are 3 m apart
    Evaluated s;
    const auto rod = s.add_body("rod", 1, 1.0 / 12, {x, 0});
    s.add("left", Revolute{{-0.5, 0}, {x, 0}}, rod);
    s.add("right", Revolute{{0.5, 0}, {x, 3}}, rod);
    VectorXd q = s.initial_q(), v = s.initial_v();
    CHECK(refused<AssemblyError>([&] { s.assemble(q, v); }).find("stays open by") !=
          std::string::npos);
  }
  CHECK(assembled > 50);
  CHECK(refusals > 50);
}

TEST_CASE("misuse: a whole turn between two compared angles is told") {
  for (const int turns : {-2, 1, 3}) {
    Evaluated s;
    const auto block = s.add_body("block", 1, 1, {0, 0}, 0.1);
    s.add("rail", Prismatic{}, System::world, block);
    s.add("ground", Ground{{0, 0}, turns * 2 * pi}, block);
    VectorXd q = s.initial_q(), v = s.initial_v();
    const std::string words = refused<AssemblyError>([&] { s.assemble(q, v); });
    CHECK(words.find("(rad) stays open by") != std::string::npos);
    CHECK(words.find("whole turns apart, and are not wrapped") != std::string::npos);
  }
  // One that nothing else holds turns back, and half a turn is no turn.
  Evaluated s;
  const auto block = s.add_body("block", 1, 1, {0, 0}, 2 * pi);
  s.add("rail", Prismatic{}, System::world, block);
  VectorXd q = s.initial_q(), v = s.initial_v();
  CHECK(std::abs(s.assemble(q, v).moved - 2 * pi) < 1e-15);
  s.add("ground", Ground{{0, 0}, pi}, block);
  const std::string words = refused<AssemblyError>([&] { s.assemble(q, v); });
  CHECK(words.find("(rad) stays open by") != std::string::npos);
  CHECK(words.find("whole turns") == std::string::npos);
}
