#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "allocations.hpp"
#include "catch.hpp"
#include "exact.hpp"
#include "instruments/measure/ladder.hpp"
#include "instruments/pictures/stage.hpp"
#include "main_check.hpp"
#include "mechanism.hpp"
#include "orders.hpp"
#include "picture_check.hpp"
#include "stability_check.hpp"
#include "study.hpp"

using ground::decay;
using ground::make_mechanism;
using ground::make_pendulum;
using ground::Scene;
using mechanics::Method;
using mechanics::Stabilization;

namespace {

using Motion = mechanics::Motion<mechanics::Mechanism>;

Motion motion(const Scene& scene, const Method& method = {}) {
  return {make_mechanism(scene, method), method};
}

const Scene displaced{.offset_x = 0.05, .offset_y = -0.03, .offset_theta = 0.2};

Method feedback(integrators::Scheme name, double ks, double kd) {
  return {name, Stabilization::feedback, ks, kd};
}

}  // namespace

TEST_CASE("the loop in main holds the plate where the exact answer does") {
  const std::string text = printed_by("04_ground");
  const ground::Scene off{.offset_x = 0.05, .offset_y = -0.03, .offset_theta = 0.2};
  const Eigen::Vector3d exact = ground::exact(off, ground::decay(25.0, 10.0, 1.0), 1.0).q;
  CHECK(std::abs(number_after(text, "the plate is at (") - exact.x()) < 1e-7);
  CHECK(number_after(text, "error") < 1e-7);
}

TEST_CASE("the reaction is minus weight and load and minus their moment, to rounding") {
  const Scene scene{.load = 7.0};
  Motion plate = motion(scene);
  for (int i = 0; i < 50; ++i) {
    const mechanics::Row row = plate.row();
    const double load = 7.0 * std::sin(2.0 * row.t);
    CHECK(std::abs(row.reactions[0]) < 1e-14);
    CHECK(row.reactions[1] == Approx(-(2.0 * 9.81 + load)).epsilon(1e-15));
    CHECK(row.reactions[2] == Approx(-0.3 * load).epsilon(1e-14).margin(1e-14));  // arm 0.3 m
    plate.advance(1, 0.1);
  }
}

TEST_CASE("the closed form of the decay satisfies its equation and its start") {
  for (const auto& [ks, kd] : {std::pair{25.0, 3.0},
                               {25.0, 10.0},
                               {25.0, 30.0},
                               {25.0, 10.0 + 1e-7},
                               {25.0, 0.0},
                               {0.0, 4.0}}) {
    INFO("ks " << ks << " kd " << kd);
    CHECK(decay(ks, kd, 0.0).e == 1.0);
    CHECK(decay(ks, kd, 0.0).rate == 0.0);
    const double h = 1e-4;
    for (const double t : {0.1, 0.5, 1.3}) {
      const auto before = decay(ks, kd, t - h), at = decay(ks, kd, t), after = decay(ks, kd, t + h);
      CHECK(at.rate == Approx((after.e - before.e) / (2 * h)).margin(1e-6));
      CHECK((after.rate - before.rate) / (2 * h) + kd * at.rate + ks * at.e ==
            Approx(0.0).margin(1e-5));
    }
  }
  const auto late = decay(25.0, 1e6, 100.0);  // nothing overflows far into an overdamped decay
  CHECK(late.e == Approx(std::exp(-25e-6 * 100.0)).epsilon(1e-6));
}

TEST_CASE("every coordinate goes back by the closed form, whatever the load") {
  for (const double load : {0.0, 50.0})
    for (const double kd : {3.0, 10.0, 30.0}) {
      Scene scene = displaced;
      scene.load = load;
      Motion plate = motion(scene, feedback(integrators::Scheme::rk4, 25.0, kd));
      plate.advance(700, 1e-3);
      const double e = decay(25.0, kd, 0.7).e;
      CHECK(plate.q()[0] == Approx(0.05 * e).epsilon(1e-9));
      CHECK(plate.q()[1] == Approx(-0.03 * e).epsilon(1e-9));
      CHECK(plate.q()[2] == Approx(0.2 * e).epsilon(1e-9));
    }
}

TEST_CASE(
    "without stabilization the plate stays where it was put, with projection it is in its place at "
    "once") {
  Motion left = motion(displaced);
  left.advance(100, 0.01);
  CHECK((left.q() - displaced.offset()).lpNorm<Eigen::Infinity>() < 1e-13);
  Motion projected = motion(displaced, {integrators::Scheme::rk4, Stabilization::projection});
  projected.advance(1, 0.01);
  CHECK(projected.q().lpNorm<Eigen::Infinity>() < 1e-15);
}

TEST_CASE("position, angle and reaction converge with the order of the integrator") {
  Method current;
  const measure::Start start = [&](const Method& method) {
    current = method;
    return std::make_unique<Motion>(motion(displaced, method));
  };
  const measure::Errors errors = [&](const mechanics::Row& row) {
    return ground::errors(displaced, current, row);
  };
  std::vector<Method> methods = measure::every_integrator(Stabilization::feedback, 25.0, 10.0);
  const auto dop853 = std::find_if(methods.begin(), methods.end(), [](const Method& method) {
    return method.integrator == integrators::Scheme::dop853;
  });
  const Method eighth_order = *dop853;
  methods.erase(dop853);
  CHECK(check_orders({.methods = methods, .duration = 0.5, .coarsest = 1.0 / 64, .rungs = 8}, start,
                     errors, [](const measure::Rung& rung, std::size_t k) {
                       return rung.errors[k] > 1e-12 && rung.step < 1.0 / 250;
                     }) > 40);
  check_order(eighth_order, 1.0, 14, start, errors);
}

TEST_CASE("rows and columns equal the hand count") {
  Motion plate = motion({});
  plate.advance(1, 0.01);
  const dynamics::Counts counts = plate.model().evaluation().counts();
  CHECK(counts.coordinates == 3);
  CHECK(counts.rows == 3);
  CHECK(counts.rank == 3);
  CHECK(counts.degrees_of_freedom == 0);
  CHECK(counts.jacobian_blocks == 1);
  CHECK((plate.model().evaluation().jacobian() - Eigen::Matrix3d::Identity()).norm() == 0.0);
}

TEST_CASE("a joint to the world moves as one to a grounded plate, and needs less") {
  Motion with(make_pendulum(true), {}), without(make_pendulum(false), {});
  with.advance(1000, 1e-3);
  without.advance(1000, 1e-3);
  const auto big = with.model().evaluation().counts(),
             small = without.model().evaluation().counts();
  CHECK(big.coordinates == 6);
  CHECK(big.rows == 5);
  CHECK(big.jacobian_blocks == 1 + 2);
  CHECK(small.coordinates == 3);
  CHECK(small.rows == 2);
  CHECK(small.jacobian_blocks == 1);
  CHECK(big.degrees_of_freedom == small.degrees_of_freedom);
  CHECK((with.q().tail<3>() - without.q()).lpNorm<Eigen::Infinity>() < 1e-12);
  CHECK((with.v().tail<3>() - without.v()).lpNorm<Eigen::Infinity>() < 1e-12);
}

TEST_CASE("the stability boundary of each integrator is where theory has it") {
  // Along the axis of critical damping kd h = 2s, ks h² = s²: s < 2.785 (RK4), 2 (explicit Euler),
  // 0.828.
  const auto stays = [](integrators::Scheme name, double s) {
    Motion plate = motion({.load = 0.0, .offset_x = 1.0}, feedback(name, s * s * 1e4, 2 * s * 1e2));
    plate.advance(2000, 0.01);
    return std::abs(plate.q()[0]) < 1.0;
  };
  CHECK(stays(integrators::Scheme::rk4, 2.75));
  CHECK_FALSE(stays(integrators::Scheme::rk4, 2.82));
  CHECK(stays(integrators::Scheme::explicit_euler, 1.97));
  CHECK_FALSE(stays(integrators::Scheme::explicit_euler, 2.03));
  CHECK(stays(integrators::Scheme::semi_implicit_euler, 0.81));
  CHECK_FALSE(stays(integrators::Scheme::semi_implicit_euler, 0.85));
}

TEST_CASE("a step allocates nothing") {
  for (const auto stabilization :
       {Stabilization::none, Stabilization::feedback, Stabilization::projection}) {
    Motion plate = motion(displaced, {integrators::Scheme::rk4, stabilization, 25.0, 10.0});
    plate.advance(1, 0.01);
    const long before = allocations();
    plate.advance(100, 0.01);
    CHECK(allocations() == before);
  }
}

TEST_CASE("solution 1: the load of a turned plate has a shorter arm") {
  Scene scene = displaced;
  scene.offset_theta = 1.0;
  Motion plate = motion(scene);
  plate.advance(50, 0.01);
  const mechanics::Row row = plate.row();
  CHECK(row.reactions[2] == Approx(-0.3 * std::cos(1.0) * 5.0 * std::sin(1.0)).epsilon(1e-12));
}

TEST_CASE(
    "solution 2: critical damping leaves (1 + 5t) exp(−5t) of the error, 4 % after one second") {
  CHECK(decay(25.0, 10.0, 1.0).e == Approx(6.0 * std::exp(-5.0)).epsilon(1e-14));
  CHECK(decay(25.0, 10.0, 1.0).e == Approx(0.04).margin(0.001));
}

TEST_CASE("solution 3: at 0.01 s semi-implicit Euler takes gains up to 6863 1/s²") {
  const auto left = [](double ks) {  // of an error of 1 m, after 20 s
    Motion plate =
        motion({.load = 0.0, .offset_x = 1.0},
               feedback(integrators::Scheme::semi_implicit_euler, ks, 2 * std::sqrt(ks)));
    plate.advance(2000, 0.01);
    return std::abs(plate.q()[0]);
  };
  const double limit = std::pow((2 * std::sqrt(2.0) - 2) / 0.01, 2);
  CHECK(limit == Approx(6863).margin(1));
  CHECK(left(0.995 * limit) < 1e-3);
  CHECK(left(1.005 * limit) > 1e3);
}

namespace {
const measure::RunOptions defaults{.duration = 5.0, .step = 0.01};
}

TEST_CASE("the pictures of the lesson are those that the program draws") {
  picture_check::compare_all("04_ground", ground::pictures({}, defaults));
}

TEST_CASE("pictures can be drawn of every scene the options allow") {
  for (const Scene& scene :
       {Scene{.load = 0.0}, Scene{.load = 1e12}, Scene{.offset_x = 1e6, .offset_theta = -1e6}}) {
    const measure::RunOptions run{.duration = 0.5, .step = 0.05};
    for (const auto& picture : ground::pictures(scene, run))
      CHECK_NOTHROW(draw::render({.scale = 0.5}, picture.draw));
    CHECK_NOTHROW(draw::render({.width = 480, .height = 300},
                               pictures::picture_at(ground::stage(scene, run), 0.2).draw));
  }
}

TEST_CASE("every stiff and extreme case ends as expected, and the map is that of theory") {
  check_stability(ground::stability());
}
