// The global solver against a dense reference in long double, closed forms, and conservation laws.
#include "dynamics/system.hpp"

#include <Eigen/Dense>
#include <chrono>

#include "allocations.hpp"
#include "catch.hpp"
#include "joints/distance.hpp"
#include "joints/ground.hpp"
#include "joints/on_curve.hpp"
#include "joints/prismatic.hpp"
#include "joints/revolute.hpp"
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
  System system;
  Vector2d g = Vector2d::Zero();
  double ks = 0, kd = 0;
  VectorXd F_constant;

  template <class Joint, class First, class Second = World>
  JointHandle add(const std::string& name, const Joint& joint, Handle<First> first,
                  Handle<Second> second = System::world) {
    fill_.push_back([=](System& s, const VectorXd& q, const VectorXd& v, VectorXd& C, MatrixXd& J,
                        VectorXd& Jdot_v) {
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
  static Thing thing(System& s, Handle<Thing> h, const VectorXd& q, const VectorXd& v) {
    if constexpr (Thing::dof == 0)
      return {};
    else
      return s.state(h, q, v);
  }
  std::vector<std::function<void(System&, const VectorXd&, const VectorXd&, VectorXd&, MatrixXd&,
                                 VectorXd&)>>
      fill_;
};

double relative(const VectorXd& a, const VectorXd& b) {
  return (a - b).lpNorm<Eigen::Infinity>() / std::max(1e-300, b.lpNorm<Eigen::Infinity>());
}

VectorXd acceleration(System& s, const VectorXd& q, const VectorXd& v, double t = 0) {
  VectorXd a(q.size());
  s.acceleration(t, q, v, a);
  return a;
}

// One step of the classical Runge-Kutta method.
void rk4(System& s, double h, VectorXd& q, VectorXd& v) {
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
    const double m = random_number(0.5, 3), inertia = random_number(0.2, 2);
    const double theta = random_number(-3, 3), omega = random_number(-2, 2);
    const Vector2d x = random_vector(2), v = random_vector(2);
    const auto b = scene.system.add_body("body", m, inertia, x, theta, v, omega);
    const Vector2d u1 = random_vector(), u2 = random_vector();
    const double kind = random_number(0, 4);
    if (i == 0) {
      scene.add("pin", Revolute{u1, u2}, b, System::world);
    } else if (kind < 2) {
      scene.add("pin", Revolute{u1, u2}, b, body());
    } else if (kind < 3) {
      scene.add("rail", Prismatic{u1, u2, rotation(kind).col(0), 0.1}, body(), b);
    } else {
      const Vector2d x_bead = random_vector(2), v_bead = random_vector(2);
      const auto p = scene.system.add_particle("bead", m / 2, x_bead, v_bead);
      scene.add("rod", Distance{0.7, u1}, body(), p);
      scene.add("rod", Distance{0.9, u2}, b, p);
      if (kind < 3.5) scene.add("curve", OnCurve<Parabola>{{0.5}}, p);
    }
    bodies.push_back(b);
  }
  for (int i = 0; i < loops; ++i) {
    const auto a = body(), b = body();
    if (a.index != b.index) scene.add("loop", Distance{0.5, random_vector()}, a, b);
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
    System& s = scene.system;
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
    const auto link = scene.system.add_body("link", m, m * l * l / 12, (i + 0.5) * l * e, angle);
    if (i == 0)
      scene.add("pin", Revolute{{-l / 2, 0}, {0, 0}}, link, System::world);
    else
      scene.add("pin", Revolute{{-l / 2, 0}, {l / 2, 0}}, link, last);
    last = link;
  }
  if (both_ends) scene.add("end", Revolute{{l / 2, 0}, e}, last, System::world);
}

VectorXd random_velocity(System& s) {
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
      const VectorXd part = scene.system.lambda({j});
      lambda_system.segment(row, part.size()) = part;
      row += int(part.size());
    }
    CHECK(relative(lambda_system, lambda) < 2e-12);
    CHECK((scene.system.jacobian(q) - J).norm() == 0);
    // Each row obeys Cddot + kd Cdot + ks C = 0.
    const VectorXd Cddot = J * a + Jdot_v;
    CHECK((Cddot + scene.kd * J * v + scene.ks * C).lpNorm<Eigen::Infinity>() <
          1e-12 * std::max(Jdot_v.lpNorm<Eigen::Infinity>(), (J * a).lpNorm<Eigen::Infinity>()) +
              1e-11);
    CHECK(scene.system.counts().rank == C.size());
    CHECK(scene.system.dependent_rows().empty());
  }
}

TEST_CASE("one particle on the parabola has chapter 1's lambda") {
  const double p = 50, m = 1.3, x = 40, vx = 7, fx = 3, g = 9.81;
  System s;
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
    System s;
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
    System s;
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
    System s;
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
  System& s = scene.system;
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
    const Counts counts = scene.system.counts();
    CHECK(counts.factor_blocks == 2 * n - 1);
    CHECK(counts.jacobian_blocks == 2 * n - 1);
    CHECK(counts.rows == 2 * n);
  }
#ifdef NDEBUG  // in an optimised build
  Scene scene;
  chain(scene, 1000, false, 0.3);
  const VectorXd q = scene.system.initial_q(), v = scene.system.initial_v();
  VectorXd a(q.size());
  double best = 1;
  for (int i = 0; i < 50; ++i) {
    const auto start = std::chrono::steady_clock::now();
    scene.system.acceleration(0, q, v, a);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    best = std::min(best, time.count());
  }
  CHECK(best < 1e-3);
#endif
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

TEST_CASE("redundant and singular sets: the motion is right, the rows are named") {
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
    CHECK(twice.system.lambda({1}).norm() == 0);
    CHECK(relative(twice.system.lambda({0}), once.system.lambda({0})) < 1e-14);
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
    scene.add("rail", Prismatic{{0, 1}, {-0.1, 0}}, System::world, b);
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
  const double E = scene.system.energy(q, v) + scene.system.constraint_error(q) +
                   scene.system.velocity_error(q, v);
  CHECK(allocations() == before_projection);
  CHECK((projection.converged && std::isfinite(E)));
}

TEST_CASE("projection brings positions and velocities to rounding") {
  for (double size : {1e-9, 1e-6, 1e-3, 3e-2}) {
    Scene scene;
    SliderCrank{}.build(scene);
    System& s = scene.system;
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

TEST_CASE("projection is the least change in the mass metric") {
  Scene scene;
  SliderCrank crank;
  crank.phi = 0.8;
  crank.shift = {3, -2};
  crank.build(scene);
  System& s = scene.system;
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
    scene.add("hook", Revolute{{0, 0}, {0.025, 0}}, load, Handle<Body>{19, 57});
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
  System& s = scene.system;
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
  CHECK(std::abs(s.energy(q, v) / E - 1) < 1e-6);
  CHECK(C < 1e-12);
}

TEST_CASE("assembly: left alone, projected, or refused") {
  Scene scene;
  SliderCrank{}.build(scene);
  System& s = scene.system;
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
      } catch (const AssemblyError&) {
        FAIL_CHECK("a slider-crank that can be closed was refused");
      }
    }
  }
}

TEST_CASE("assembly: what cannot be closed is refused with the joint's name") {
  Scene scene;
  System& s = scene.system;
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
  System s;
  CHECK_THROWS_AS(s.add_particle("p", 0, {0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(s.add_body("b", 1, -1, {0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(s.add_body("b", std::nan(""), 1, {0, 0}), std::invalid_argument);
  CHECK_THROWS_AS(s.add_body("b", INFINITY, 1, {0, 0}), std::invalid_argument);
  const auto b = s.add_body("b", 1, 1, {0, 0});
  CHECK_THROWS_AS(s.add("self", Revolute{}, b, b), std::invalid_argument);
  CHECK_THROWS_AS(acceleration(s, VectorXd::Zero(2), VectorXd::Zero(3)), std::invalid_argument);

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
  System s;
  s.set_gravity({0, 9.81});
  s.add_particle("p", 2, {0, 0});
  VectorXd q = s.initial_q(), v = s.initial_v();
  CHECK((acceleration(s, q, v) - Vector2d(0, 9.81)).norm() == 0);
  CHECK(s.project(q, v).converged);
  CHECK(!s.assemble(q, v).projected);
  CHECK(s.constraint_error(q) == 0);
}
