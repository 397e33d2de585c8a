// Rows that nearly depend on others: redundant joints, singular poses, light things beside heavy
// ones. The truths are those of one rigid body, of one angle, of statics.
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>

#include "catch.hpp"
#include "evaluated.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "mechanics/motion/mechanism.hpp"
#include "random.hpp"

using namespace dynamics;
using integrators::Scheme;
using joints::Distance;
using joints::Prismatic;
using joints::Revolute;
using mechanics::Mechanism;
using mechanics::Method;
using mechanics::Motion;
using mechanics::Stabilization;

namespace {

constexpr double g = 9.81, pi = 3.14159265358979323846;

// A frame in which a scene is told again: turned about the origin, then moved.
struct Frame {
  double angle = 0;
  Vector2d shift = {0, 0};

  Vector2d operator()(const Vector2d& x) const { return rotation(angle) * x + shift; }
  Vector2d turned(const Vector2d& x) const { return rotation(angle) * x; }
};
const Frame frames[] = {{}, {2.5, {0, 0}}, {-1, {100, -300}}, {0.7, {1e4, 1e4}}};

// Body a, pinned to the world at the origin, and body b, pinned to a at two points: one rigid body.
// Turned by e about the first pin, at omega. `swapped`: each joint names its things the other way
// round, and comes in the opposite order.
void two_pins(System& system, double e, double omega, const Frame& frame = {},
              bool swapped = false) {
  system.set_gravity(frame.turned({0, g}));
  const auto body = [&](const char* name, double mass, double inertia, const Vector2d& x) {
    const Vector2d at = rotation(e) * x;
    return system.add_body(name, mass, inertia, frame(at), e + frame.angle,
                           frame.turned(omega * Vector2d(-at.y(), at.x())), omega);
  };
  const auto a = body("a", 1, 1. / 12, {0.5, 0}), b = body("b", 2, 0.5, {0.5, 0.2});
  const Vector2d world = frame({0, 0});
  if (swapped) {
    system.add("two", Revolute{{0.3, -0.1}, {0.3, 0.1}}, b, a);
    system.add("one", Revolute{{-0.3, -0.1}, {-0.3, 0.1}}, b, a);
    system.add("pin", Revolute{world, {-0.5, 0}}, System::world, a);
  } else {
    system.add("pin", Revolute{{-0.5, 0}, world}, a, System::world);
    system.add("one", Revolute{{-0.3, 0.1}, {-0.3, -0.1}}, a, b);
    system.add("two", Revolute{{0.3, 0.1}, {0.3, -0.1}}, a, b);
  }
}
// Its angular acceleration: the weights' moment over the inertia about the pin.
double two_pins_acceleration(double e) {
  const double x_a = 0.5 * std::cos(e), x_b = 0.5 * std::cos(e) - 0.2 * std::sin(e);
  return g * (x_a + 2 * x_b) / (1. / 12 + 0.25 + 0.5 + 2 * (0.25 + 0.04));
}

// A rod of 1 m and 1 kg, pinned at its end and let go from horizontal: its angle by its one
// equation, theta'' = 3/2 g cos(theta), in steps so short that they do not count.
double pendulum(double duration) {
  const int steps = 40000;
  const double h = duration / steps;
  double theta = 0, omega = 0;
  const auto a = [](double angle) { return 1.5 * g * std::cos(angle); };
  for (int i = 0; i < steps; ++i) {
    const double k1 = a(theta), k2 = a(theta + h / 2 * omega),
                 k3 = a(theta + h / 2 * (omega + h / 2 * k1)),
                 k4 = a(theta + h * (omega + h / 2 * k2));
    theta += h * omega + h * h / 6 * (k1 + k2 + k3);
    omega += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return theta;
}

template <class Build>
Motion<Mechanism> start(const Method& method, Build&& build) {
  Mechanism mechanism(method);
  build(mechanism.system);
  mechanism.start_as_given();
  return {std::move(mechanism), method};
}

// The largest change of energy over `seconds`.
double energy_error(Motion<Mechanism>& motion, double seconds, double step) {
  const double before = motion.measures().energy;
  double largest = 0;
  for (int i = 0; i < 100; ++i) {
    motion.advance(std::lround(seconds / step / 100), step);
    largest = std::max(largest, std::abs(motion.measures().energy - before));
  }
  return largest;
}

}  // namespace

TEST_CASE("two pins instead of a weld are one rigid body, in every pose and frame") {
  for (const Frame& frame : frames)
    for (const bool swapped : {false, true})
      for (const double omega : {0., 2.})
        for (int i = 0; i <= 200; ++i) {
          const double e = i <= 100 ? i * 1e-8 : std::pow(10, -6 + 6. * (i - 100) / 100);
          Evaluated scene;
          two_pins(scene, e, omega, frame, swapped);
          const auto& evaluation = scene.at(scene.initial_q());
          INFO("e " << e << " omega " << omega << " frame " << frame.angle << " swapped "
                    << swapped);
          const double truth = two_pins_acceleration(e);
          REQUIRE(evaluation.counts().rank == 5);
          REQUIRE(std::abs(evaluation.a()[2] - truth) < 1e-11 * truth);
          REQUIRE(std::abs(evaluation.a()[5] - truth) < 1e-11 * truth);
        }
}

TEST_CASE("two pins instead of a weld keep their energy over 5 s") {
  const auto error = [](const Method& method, double step) {
    auto motion = start(method, [](System& system) { two_pins(system, 0, 0); });
    return energy_error(motion, 5, step);
  };
  CHECK(error({Scheme::rk4, Stabilization::projection}, 1e-3) < 1e-10);
  CHECK(error({Scheme::rk4}, 1e-3) < 1e-8);  // the joints drift
  CHECK(error({Scheme::dop853, Stabilization::projection}, 1e-3) < 1e-11);
  CHECK(error({Scheme::implicit_midpoint, Stabilization::projection}, 1e-3) < 3e-3);
}

TEST_CASE("a tie that adds nothing changes nothing") {
  const double truth = pendulum(5);
  CHECK(std::abs(truth - 2.937510900035) < 1e-11);
  const auto off = [&](const Method& method, double step, bool tied, const Frame& frame = {}) {
    auto motion = start(method, [&](System& system) {
      system.set_gravity(frame.turned({0, g}));
      const auto rod = system.add_body("rod", 1, 1. / 12, frame({0.5, 0}), frame.angle);
      system.add("pin", Revolute{{-0.5, 0}, frame({0, 0})}, rod, System::world);
      if (tied) system.add("tie", Distance{0.5, {0, 0}, frame({0, 0})}, rod, System::world);
    });
    motion.advance(std::lround(5 / step), step);
    return std::abs(motion.q()[2] - frame.angle - truth);
  };
  const Stabilization projection = Stabilization::projection;
  for (const Frame& frame : frames) {
    INFO("frame " << frame.angle);
    CHECK(off({Scheme::rk4, projection}, 0.005, true, frame) <
          3 * off({Scheme::rk4, projection}, 0.005, false, frame));
    CHECK(off({Scheme::rk4}, 0.005, true, frame) < 1e-6);
    CHECK(off({Scheme::dop853, projection}, 0.005, true, frame) < 1e-10);
  }
  // Steps so coarse that the joints gape between two projections, or for want of one.
  CHECK(off({Scheme::rk4, projection}, 0.05, true) < 1e-2);
  CHECK(off({Scheme::semi_implicit_euler, projection}, 0.001, true) <
        1.01 * off({Scheme::semi_implicit_euler, projection}, 0.001, false));
  CHECK(off({Scheme::semi_implicit_euler}, 0.001, true) < 0.1);
}

TEST_CASE("of redundant joints the reactions are told apart: what is determined, and what is not") {
  Evaluated scene;
  two_pins(scene, 0.3, 0);
  const auto& e = scene.at(scene.initial_q());
  const auto a = scene.thing<Body>("a");
  CHECK(e.determined_reaction(scene.joint(0), a).allFinite());
  CHECK(e.determined_reaction(scene.joint(1), a).allFinite());
  // Of the last pin the force along the line between the two is a row that depends on the others.
  CHECK(e.dependent_rows().size() == 1);
  CHECK(e.dependent_rows()[0].joint == "two");
  const auto two = e.determined_reaction(scene.joint(2), a);
  CHECK((std::isnan(two.x()) && std::isnan(two.y())));
  // Together they carry b: m (a - g), and its moment.
  const auto b = scene.thing<Body>("b");
  const Vector3d both = e.reaction(scene.joint(1), b) + e.reaction(scene.joint(2), b);
  CHECK(std::abs(both.x() - 2 * e.a()[3]) < 1e-12);
  CHECK(std::abs(both.y() - 2 * (e.a()[4] - g)) < 1e-12);
  CHECK(std::abs(both.z() - 0.5 * e.a()[5]) < 1e-12);
}

namespace {

// A slider-crank of equal crank and rod, 0.3 m, as it passes the pose in which J loses rank.
struct Crank {
  Handle<Body> wheel, rod, slider;
};
Crank equal_crank(System& system, double theta, double omega, const Frame& frame = {},
                  double rod_inertia = 0.0075, const std::string& one_of = "") {
  system.set_gravity(frame.turned({0, g}));
  const double l = 0.3, c = std::cos(theta), s = std::sin(theta);
  const auto turned = [&](double x, double y) { return frame.turned({x, y}); };
  Crank crank;
  crank.wheel =
      system.add_body(one_of + "wheel", 2, 0.16, frame({0, 0}), theta + frame.angle, {0, 0}, omega);
  crank.rod = system.add_body(one_of + "rod", 1, rod_inertia, frame({1.5 * l * c, 0.5 * l * s}),
                              -theta + frame.angle,
                              turned(-1.5 * l * s * omega, 0.5 * l * c * omega), -omega);
  crank.slider = system.add_body(one_of + "slider", 1.5, 0.01, frame({2 * l * c, 0}), frame.angle,
                                 turned(-2 * l * s * omega, 0));
  system.add(one_of + "wheel_frame", Revolute{{0, 0}, frame({0, 0})}, crank.wheel, System::world);
  system.add(one_of + "rod_wheel", Revolute{{-l / 2, 0}, {l, 0}}, crank.rod, crank.wheel);
  system.add(one_of + "slider_rod", Revolute{{0, 0}, {l / 2, 0}}, crank.slider, crank.rod);
  system.add(one_of + "slider_frame",
             Prismatic{frame({0, 0}), {0, 0}, frame.turned({0, 1}), frame.angle}, System::world,
             crank.slider);
  return crank;
}
// Its one equation, M(theta) theta'' + M'/2 theta'^2 = Q, with a torque on the wheel, from the
// energies of its three bodies.
double equal_crank_acceleration(double theta, double omega, double rod_inertia = 0.0075,
                                double torque = 0) {
  const double l = 0.3, c = std::cos(theta), s = std::sin(theta);
  const double M =
      0.16 + rod_inertia + l * l * (2.25 * s * s + 0.25 * c * c) + 1.5 * 4 * l * l * s * s;
  const double M_prime = l * l * (4.5 - 0.5) * s * c + 1.5 * 8 * l * l * s * c;
  return (torque + 0.5 * l * c * g - M_prime / 2 * omega * omega) / M;
}

}  // namespace

TEST_CASE("at a singular pose that is passed, accelerations and forces are the limits on the way") {
  for (const Frame& frame : frames)
    for (const double omega : {5., -5., 0.5})
      for (const double beside : {0., 1e-9, -1e-7, 1e-6, 1e-5, -1e-4, 1e-3, 1e-2}) {
        const double theta = pi / 2 + beside;
        Evaluated scene;
        const Crank crank = equal_crank(scene, theta, omega, frame);
        const auto& e = scene.at(scene.initial_q());
        INFO("frame " << frame.angle << " omega " << omega << " beside " << beside);
        const double alpha = equal_crank_acceleration(theta, omega);
        const double size = omega * omega + g;
        // Of what is known of a state far from the origin, less is left.
        const double known = 1e-9 * std::max(10., std::sqrt(frame.shift.norm() / 1e-2));
        CHECK(std::abs(e.a()[2] - alpha) < known * size);
        CHECK(std::abs(e.a()[5] + alpha) < known * size);
        // The rod pushes the slider along the rail as its acceleration asks: x = 2 l cos(theta).
        const double x = -0.6 * (std::sin(theta) * alpha + std::cos(theta) * omega * omega);
        const Vector3d push = e.determined_reaction(scene.joint(2), crank.slider);
        const Vector2d along = frame.turned({1, 0});
        CHECK(std::abs(along.dot(push.head<2>()) - 1.5 * x) < 10 * known * size);
      }
}

TEST_CASE("two mechanisms in their singular poses at once do not disturb each other") {
  constexpr double torque = 3;
  for (const double slow : {5., 0.5, 5e-3, 5e-6})
    for (const bool fast_first : {true, false}) {
      Evaluated scene;
      const auto add = [&](double omega, double x) {
        const auto wheel =
            equal_crank(scene, pi / 2, omega, {0, {x, 1}}, 0.0075, std::to_string(x)).wheel;
        scene.apply(wheel, {0, 0, torque});
      };
      add(fast_first ? 5 : slow, 0);
      add(fast_first ? slow : 5, 3);
      const auto& e = scene.at(scene.initial_q());
      INFO("slow " << slow << " fast first " << fast_first);
      const double alpha = equal_crank_acceleration(pi / 2, 5, 0.0075, torque);
      CHECK(std::abs(e.a()[2] - alpha) < 1e-8 * alpha);
      CHECK(std::abs(e.a()[11] - alpha) < 1e-8 * alpha);
    }
}

TEST_CASE("at rest in a singular pose the way is not known, and it is said") {
  Evaluated scene;
  const Crank crank = equal_crank(scene, pi / 2, 0);
  const auto& e = scene.at(scene.initial_q());
  CHECK(e.dependent_rows().size() == 1);
  CHECK(!e.is_limit());
  CHECK(e.a().allFinite());
  CHECK(!e.determined_reaction(scene.joint(2), crank.slider).allFinite());
}

TEST_CASE("through a singular pose a motion converges like any other") {
  // Loaded by gravity alone the energy judges; the pose is passed about ten times in 2 s.
  const auto error = [](const Method& method, double step) {
    auto motion = start(method, [](System& system) { equal_crank(system, pi / 4, 8); });
    const double kinetic = motion.measures().kinetic;
    return energy_error(motion, 2, step) / kinetic;
  };
  for (const double step : {2e-3, 1e-3, 5e-4, 2.5e-4})
    CHECK(error({Scheme::dop853, Stabilization::projection}, step) < 1e-10);
  double before = error({Scheme::rk4, Stabilization::projection}, 4e-3);
  for (const double step : {2e-3, 1e-3, 5e-4}) {
    const double now = error({Scheme::rk4, Stabilization::projection}, step);
    CHECK(before / now > 12);
    before = now;
  }
  for (const double tolerance : {1e-6, 1e-8, 1e-10})
    CHECK(error({Scheme::dop853, Stabilization::projection, 0, 0, tolerance}, 0.1) <
          100 * tolerance);
}

TEST_CASE("started in a singular pose, a motion is as good as one that passes it") {
  const auto error = [](double theta, double omega) {
    const Method method{Scheme::dop853, Stabilization::projection};
    auto motion = start(method, [&](System& system) { equal_crank(system, theta, omega); });
    return energy_error(motion, 0.5, 1e-3);
  };
  CHECK(error(pi / 2, 5) < 1e-10);
  CHECK(error(pi / 2 + 1e-3, 5) < 1e-10);
}

TEST_CASE("a light chain carries a heavy thing") {
  for (const double M : {1., 1e3, 1e6, 1e9, 1e12, 1e15, 1e20}) {
    const double m = 1e-3, l = 0.1;
    const int n = 10;
    Evaluated scene;
    scene.set_gravity({0, g});
    std::vector<Handle<Body>> links;
    for (int i = 0; i < n; ++i) {
      links.push_back(scene.add_body("link" + std::to_string(i), m, m * l * l / 12,
                                     {0, (i + 0.5) * l}, pi / 2));
      if (i == 0)
        scene.add("top", Revolute{{-l / 2, 0}, {0, 0}}, links[0], System::world);
      else
        scene.add("pin" + std::to_string(i), Revolute{{-l / 2, 0}, {l / 2, 0}}, links.back(),
                  links[std::size_t(i) - 1]);
    }
    const auto weight = scene.add_particle("weight", M, {0, n * l});
    scene.add("end", Revolute{{0, 0}, {l / 2, 0}}, weight, links.back());
    const auto& e = scene.at(scene.initial_q());
    INFO("M " << M);
    CHECK(e.counts().rank == e.counts().rows);
    const double top = e.determined_reaction(scene.joint(0), links[0]).y();
    CHECK(std::abs(top / (-g * (M + n * m)) - 1) < 1e-12);
    CHECK(e.a().cwiseAbs().maxCoeff() < 1e-6 * g);
  }
}

TEST_CASE("a rod of next to no inertia keeps the energy") {
  for (const double inertia : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15}) {
    Evaluated scene;
    equal_crank(scene, 1, 5, {}, inertia);
    INFO("inertia " << inertia);
    const double alpha = equal_crank_acceleration(1, 5, inertia);
    CHECK(std::abs(scene.at(scene.initial_q()).a()[2] - alpha) < 1e-9 * 25);
    auto motion = start({Scheme::rk4, Stabilization::projection},
                        [&](System& system) { equal_crank(system, 1, 5, {}, inertia); });
    CHECK(energy_error(motion, 0.2, 1e-3) < 1e-7 * motion.measures().kinetic);
  }
}

namespace {

// Bodies and a bead at random places, joined at random so that all joints are closed, some of them
// twice. On a grid, at right angles, more of them are redundant than at places of all kinds.
void random_scene(System& system, bool on_grid, double most_mass) {
  const auto whole = [](int below) { return static_cast<int>(generator() % unsigned(below)); };
  const auto real = [](double from, double to) {
    return from + (to - from) * static_cast<double>(generator()) / 4294967296.;
  };
  const auto place = [&] {
    return on_grid ? Vector2d(whole(4), whole(3)) : Vector2d(real(-1, 1), real(-1, 1));
  };
  const auto angle = [&] { return on_grid ? pi / 2 * whole(4) : real(-3, 3); };
  const auto mass = [&] { return std::pow(most_mass, real(-1, 1)); };
  struct Placed {
    Handle<Body> handle;
    Vector2d x;
    double theta;
    Vector2d own(const Vector2d& d) const { return rotation(theta).transpose() * d; }
    Vector2d in(const Vector2d& p) const { return own(p - x); }
  };
  std::vector<Placed> bodies(std::size_t(1 + whole(4)));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double m = mass();
    const Vector2d x = place();
    const double theta = angle();
    bodies[i] = {system.add_body(std::to_string(i), m, m * real(0.05, 1), x, theta), x, theta};
  }
  const Vector2d at = place() + Vector2d(0.1, 0.3);
  const auto bead = system.add_particle("bead", mass(), at);
  system.set_gravity({3, g});
  system.apply(bodies[0].handle, {real(-1, 1), real(-1, 1), real(-1, 1)});

  for (int joint = 0, joints = 1 + whole(6); joint < joints; ++joint) {
    const Placed& a = bodies[std::size_t(whole(int(bodies.size())))];
    const Placed& b = bodies[std::size_t(whole(int(bodies.size())))];
    const bool fixed = a.handle.index == b.handle.index;
    const Vector2d p = place(), n = rotation(angle()) * Vector2d(0, 1);
    const int kind = whole(4);
    const double length = (p - at).norm();
    for (int copies = whole(3) == 0 ? 2 : 1; copies > 0; --copies) {
      const std::string name = std::to_string(joint) + "." + std::to_string(copies);
      if (kind == 0 && fixed) system.add(name, Revolute{a.in(p), p}, a.handle, System::world);
      if (kind == 0 && !fixed) system.add(name, Revolute{a.in(p), b.in(p)}, a.handle, b.handle);
      if (kind == 1 && fixed)
        system.add(name, Prismatic{p, a.in(p), n, a.theta}, System::world, a.handle);
      if (kind == 1 && !fixed)
        system.add(name, Prismatic{a.in(p), b.in(p), a.own(n), b.theta - a.theta}, a.handle,
                   b.handle);
      if (kind == 2) system.add(name, Distance{length, {0, 0}, p}, bead, System::world);
      if (kind == 3) system.add(name, Distance{length, {0, 0}, a.in(p)}, bead, a.handle);
    }
  }
}

}  // namespace

TEST_CASE("random scenes, redundant joints or not, move as a singular value decomposition says") {
  using Eigen::MatrixXd;
  int judged = 0, with_redundant = 0;
  for (int i = 0; i < 600; ++i) {
    Evaluated scene;
    const bool on_grid = i % 2 == 1;
    random_scene(scene, on_grid, i % 3 == 0 ? 1 : 1e4);
    const VectorXd q = scene.initial_q();
    MatrixXd J = scene.jacobian(q);
    const VectorXd per_row = J.rowwise().norm().cwiseInverse();
    if (J.rows() == 0 || !per_row.allFinite()) continue;
    const Eigen::JacobiSVD<MatrixXd> svd(per_row.asDiagonal() * J,
                                         Eigen::ComputeFullU | Eigen::ComputeFullV);
    const auto& sigma = svd.singularValues().array();
    const Eigen::Index rank = (sigma > 1e-3).count();
    if ((sigma > 1e-12).count() > rank) continue;  // near a singular pose: known to fewer digits
    ++judged;
    with_redundant += rank < J.rows();

    const MatrixXd N = svd.matrixV().rightCols(q.size() - rank);  // J N = 0
    VectorXd z(N.cols());
    for (double& x : z) x = static_cast<double>(generator()) / 4294967296. - 0.5;
    // On the grid a pose may be singular, and not all that it lets move can go on moving.
    const VectorXd v = (on_grid ? 0 : 1) * N * z;
    constexpr double h = 1e-5;
    const VectorXd Jdot_v = (scene.jacobian(q + h * v) - scene.jacobian(q - h * v)) * v / (2 * h);
    // Of all a with J a = -Jdot_v the one that is nearest to W F (Gauss).
    const VectorXd particular =
        -svd.matrixV().leftCols(rank) *
        (svd.matrixU().leftCols(rank).transpose() * per_row.cwiseProduct(Jdot_v))
            .cwiseQuotient(sigma.head(rank).matrix());
    const VectorXd root_M = scene.W().cwiseSqrt().cwiseInverse();
    const VectorXd free = scene.W().cwiseProduct(scene.forces(0, q, v));
    VectorXd a = particular;
    if (N.cols() > 0)
      a += N * (root_M.asDiagonal() * N)
                   .colPivHouseholderQr()
                   .solve(root_M.cwiseProduct(free - particular));

    const auto& e = scene.at(q, v);
    INFO("scene " << i << ", rows " << J.rows() << ", rank " << rank);
    CHECK(e.counts().rank == rank);
    CHECK((e.a() - a).cwiseAbs().maxCoeff() < 1e-7 * std::max(g, a.cwiseAbs().maxCoeff()));
  }
  CHECK(judged > 500);
  CHECK(with_redundant > 250);
}

TEST_CASE("what is not finite stays that, and redundant joints that contradict each other end") {
  Evaluated scene;
  two_pins(scene, 0, 0);
  VectorXd q = scene.initial_q(), v = scene.initial_v();
  q[0] = std::nan("");
  CHECK(std::isnan(scene.at(q, v).a().sum()));
  q = scene.initial_q();
  v[1] = INFINITY;
  CHECK(!std::isfinite(scene.at(q, v).a().sum()));

  System apart;  // b's pins 1 mm further from each other than a's
  const auto a = apart.add_body("a", 1, 1, {0, 0}), b = apart.add_body("b", 1, 1, {0, 0});
  apart.add("one", Revolute{{-0.3, 0}, {-0.3, 0}}, a, b);
  apart.add("two", Revolute{{0.3, 0}, {0.301, 0}}, a, b);
  Evaluation e(apart);
  apart.evaluate(0, apart.initial_q(), apart.initial_v(), e);
  CHECK(e.a().allFinite());
  q = apart.initial_q();
  v = apart.initial_v();
  CHECK(!apart.project(0, q, v, e).converged);
  CHECK_THROWS_AS(apart.assemble(0, q, v), AssemblyError);
}
