// Rates to start with: closed forms, least kinetic energy, redundant joints, and what is refused.
#include <Eigen/Dense>
#include <cmath>

#include "catch.hpp"
#include "evaluated.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/ground.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"
#include "random.hpp"

using namespace dynamics;
using namespace joints;
using Eigen::MatrixXd;

namespace {

double random_number(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(generator);
}

/// A slider-crank with its crank at theta; the slider's mass is free.
struct SliderCrank {
  double crank, rod, theta, phi;
  Evaluated s;
  Handle<Body> wheel, bar, slider;

  SliderCrank(double r, double l, double angle, double slider_mass = 1.5, double rod_mass = 1)
      : crank(r), rod(l), theta(angle), phi(r == l ? -angle : -std::asin(r * std::sin(angle) / l)) {
    const Vector2d pin = crank * rotation(theta).col(0), along = rotation(phi).col(0);
    wheel = s.add_body("wheel", 2, 0.16, {0, 0}, theta);
    bar = s.add_body("rod", rod_mass, rod_mass * l * l / 12, pin + rod / 2 * along, phi);
    slider = s.add_body("slider", slider_mass, 0.01 * slider_mass, pin + rod * along);
    s.add("wheel_world", Revolute{}, wheel);
    s.add("rod_wheel", Revolute{{-rod / 2, 0}, {crank, 0}}, bar, wheel);
    s.add("slider_rod", Revolute{{0, 0}, {rod / 2, 0}}, slider, bar);
    s.add("slider_world", Prismatic{}, System::world, slider);
  }
  /// By hand: the slider does not move across the rail.
  VectorXd rates(double omega) const {
    const Vector2d pin = omega * S(crank * rotation(theta).col(0)), along = rotation(phi).col(0);
    const double phi_rate = -pin.y() / (rod * along.x());
    const Vector2d middle = pin + phi_rate * rod / 2 * S(along);
    const Vector2d end = pin + phi_rate * rod * S(along);
    VectorXd v = VectorXd::Zero(9);
    v[2] = omega;
    v.segment<3>(3) << middle.x(), middle.y(), phi_rate;
    v[6] = end.x();
    return v;
  }
};

/// The largest difference, each thing's against its own size: a light one counts as a heavy one.
double relative(const VectorXd& v, const VectorXd& exact) {
  double error = 0;
  for (Eigen::Index i = 0; i < v.size(); i += 3)
    error = std::max(error, (v - exact).segment<3>(i).norm() / exact.segment<3>(i).norm());
  return error;
}

std::string refused(const std::function<void()>& f) {
  try {
    f();
  } catch (const AssemblyError& error) {
    return error.what();
  }
  return "nothing";
}

}  // namespace

TEST_CASE("a crank's rate turns the whole slider-crank as by hand, whatever the masses") {
  for (const double theta : {0.3, 1.0, 2.0, -2.5, 7.0})
    for (const double slider_mass : {1e-12, 1e-3, 1.5, 1e6, 1e12})
      for (const double rod_mass : {1e-15, 1.0, 1e9}) {
        const SliderCrank c(0.3, 1, theta, slider_mass, rod_mass);
        const VectorXd v = c.s.start_rates(c.s.initial_q(), {{c.wheel, 2, 10}});
        CHECK(v[2] == 10);
        CHECK(relative(v, c.rates(10)) < 1e-13);
      }
  for (const double omega : {1e-300, 1e300}) {
    const SliderCrank c(0.3, 1, 1);
    const VectorXd v = c.s.start_rates(c.s.initial_q(), {{c.wheel, 2, omega}});
    CHECK((v / omega - c.rates(1)).norm() < 1e-13);
  }
  for (const double size : {1e-6, 1e6}) {  // nor does the unit of length matter
    const SliderCrank small(0.3 * size, size, 1);
    const VectorXd v = small.s.start_rates(small.s.initial_q(), {{small.wheel, 2, 10}});
    const VectorXd exact = small.rates(10);
    for (Eigen::Index i = 0; i < 9; ++i)
      CHECK(std::abs(v[i] - exact[i]) < 1e-13 * (i % 3 == 2 ? 1 : size));
  }
  // The slider's rate gives the wheel's, and what assemble() does to the same start is no such
  // thing: it keeps the momentum of a heavy slider.
  const SliderCrank c(0.3, 1, 1, 1500);
  const VectorXd exact = c.rates(10);
  CHECK(relative(c.s.start_rates(c.s.initial_q(), {{c.slider, 0, exact[6]}}), exact) < 1e-13);
  VectorXd q = c.s.initial_q(), v = VectorXd::Zero(9);
  v[2] = 10;
  c.s.assemble(q, v);
  CHECK(v[2] < 0.1);
}

TEST_CASE("near a dead centre the rates are as exact as the pose tells them") {
  for (const double d : {1e-2, 1e-4, 1e-6, 1e-8}) {  // a rod as long as the crank, almost upright
    const double theta = std::acos(-1.0) / 2 - d;
    SliderCrank c(0.3, 0.3, theta);
    VectorXd exact = VectorXd::Zero(9);
    exact << 0, 0, 5, -0.45 * std::sin(theta) * 5, 0.15 * std::cos(theta) * 5, -5,
        -0.6 * std::sin(theta) * 5, 0, 0;
    const VectorXd q = c.s.initial_q();
    const VectorXd v = c.s.start_rates(q, {{c.wheel, 2, 5}});
    CHECK((v - exact).norm() < 1e-14 / d);
    CHECK((c.s.at(q).jacobian() * v).norm() < 1e-14);
    // With both rates no error is left that the pose could magnify.
    CHECK((c.s.start_rates(q, {{c.wheel, 2, 5}, {c.bar, 2, -5}}) - exact).norm() < 1e-7 * d);
  }
}

TEST_CASE("on a dead centre two ways lead on, and a second rate must choose") {
  SliderCrank c(0.3, 0.3, std::acos(-1.0) / 2);
  const VectorXd q = c.s.initial_q();
  const VectorXd v = c.s.start_rates(q, {{c.wheel, 2, 5}, {c.bar, 2, -5}});
  VectorXd exact = VectorXd::Zero(9);
  exact << 0, 0, 5, -0.45 * 5, 0, -5, -0.6 * 5, 0, 0;
  CHECK((v - exact).norm() < 1e-14);
  // With one rate the joints leave a mixture of both, which is the start of no motion.
  CHECK_THROWS_AS(c.s.start_rates(q, {{c.wheel, 2, 5}}), AssemblyError);
  CHECK_THROWS_AS(c.s.start_rates(q, {}), AssemblyError);
}

TEST_CASE("what the given rates leave open has the least kinetic energy") {
  for (int i = 0; i < 20; ++i) {  // a chain of five links, of which two rates are given
    Evaluated s;
    std::vector<Handle<Body>> links;
    Vector2d from(0, 0);
    for (int k = 0; k < 5; ++k) {
      const double angle = random_number(-3, 3);
      const Vector2d half = 0.5 * rotation(angle).col(0);
      const double m = std::pow(10, random_number(-3, 3));
      links.push_back(s.add_body("link" + std::to_string(k), m, m / 12, from + half, angle));
      if (k == 0)
        s.add("pin0", Revolute{{-0.5, 0}, {0, 0}}, links[0]);
      else
        s.add("pin" + std::to_string(k), Revolute{{-0.5, 0}, {0.5, 0}}, links[std::size_t(k)],
              links[std::size_t(k) - 1]);
      from += 2 * half;
    }
    const VectorXd q = s.initial_q(), v = s.start_rates(q, {{links[1], 2, 3}, {links[4], 0, -2}});
    CHECK(v[links[1].column + 2] == 3);
    CHECK(v[links[4].column] == -2);
    const MatrixXd J = s.at(q).jacobian();
    CHECK((J * v).norm() < 1e-12);
    // M v is a sum of what joints and given coordinates can bring: v^T M dv = 0 for all dv that
    // keep them.
    MatrixXd A = MatrixXd::Zero(J.rows() + 2, J.cols());
    A.topRows(J.rows()) = J;
    A(J.rows(), links[1].column + 2) = A(J.rows() + 1, links[4].column) = 1;
    const MatrixXd free = A.fullPivLu().kernel();
    REQUIRE(free.cols() == 3);
    const VectorXd p = v.cwiseQuotient(s.W());
    for (Eigen::Index k = 0; k < free.cols(); ++k)
      CHECK(std::abs(p.dot(free.col(k))) < 1e-10 * p.norm() * free.col(k).norm());
  }
  // Without joints nothing follows; without rates nothing moves.
  Evaluated free;
  const auto p = free.add_particle("p", 2, {1, 1});
  CHECK(free.start_rates(free.initial_q(), {{p, 1, 4}}) == Vector2d(0, 4));
  CHECK(free.start_rates(free.initial_q(), {}) == Vector2d(0, 0));
  CHECK(Evaluated().start_rates(VectorXd(0), {}).size() == 0);
}

TEST_CASE("redundant joints and rates given twice do no harm") {
  SliderCrank c(0.3, 1, 1);
  c.s.add("again", Revolute{}, c.wheel);
  c.s.add("second_rail", Prismatic{{5, 0}}, System::world, c.slider);
  const VectorXd exact = c.rates(10), q = c.s.initial_q();
  CHECK(relative(c.s.start_rates(q, {{c.wheel, 2, 10}}), exact) < 1e-13);
  // What follows may be given too, and a locked coordinate may be told to rest.
  const std::vector<Rate> all{{c.wheel, 2, 10},     {c.wheel, 2, 10}, {c.slider, 0, exact[6]},
                              {c.bar, 2, exact[5]}, {c.wheel, 0, 0},  {c.slider, 1, 0},
                              {c.slider, 2, 0}};
  CHECK(relative(c.s.start_rates(q, all), exact) < 1e-13);
}

TEST_CASE("rates that cannot be had are refused, and the first of them is named") {
  for (const double slider_mass : {1e-9, 1.5, 1e9}) {
    SliderCrank c(0.3, 1, 1, slider_mass);
    const VectorXd q = c.s.initial_q(), exact = c.rates(10);
    const auto says = [&](const std::vector<Rate>& given) {
      return refused([&] { c.s.start_rates(q, given); });
    };
    CHECK(says({{c.slider, 1, 1}}) ==
          "cannot start: the joints do not leave slider this rate of y");
    CHECK(
        says({{c.wheel, 2, 10}, {c.slider, 2, 1e-3}}) ==
        "cannot start: the joints and the rates before it do not leave slider this rate of theta");
    CHECK(says({{c.wheel, 2, 10}, {c.wheel, 2, 5}}) ==
          "cannot start: the joints and the rates before it do not leave wheel this rate of theta");
    CHECK(says({{c.wheel, 2, 10}, {c.bar, 2, exact[5]}, {c.slider, 0, exact[6] * (1 + 1e-6)}}) ==
          "cannot start: the joints and the rates before it do not leave slider this rate of x");
    CHECK(says({{c.wheel, 2, 0}, {c.bar, 2, 1}}) ==
          "cannot start: the joints and the rates before it do not leave rod this rate of theta");
  }
  // At a dead centre the slider stands still however the wheel turns.
  SliderCrank dead(0.3, 1, 0);
  CHECK(refused([&] {
          dead.s.start_rates(dead.s.initial_q(), {{dead.slider, 0, 1}});
        }) == "cannot start: the joints do not leave slider this rate of x");
  Evaluated held;  // no freedom at all
  const auto b = held.add_body("b", 1, 1, {0, 0});
  held.add("ground", Ground{}, b);
  CHECK(refused([&] {
          held.start_rates(held.initial_q(), {{b, 2, 1}});
        }) == "cannot start: the joints do not leave b this rate of theta");
  CHECK(held.start_rates(held.initial_q(), {{b, 2, 0}}).norm() == 0);
}

TEST_CASE("start rates: misuse") {
  SliderCrank c(0.3, 1, 1), other(0.3, 1, 1);
  VectorXd q = c.s.initial_q();
  CHECK_THROWS_WITH(c.s.start_rates(q, {{other.wheel, 2, 1}}),
                    "start_rates: a handle of another System, or of none");
  CHECK_THROWS_AS(c.s.start_rates(q, {{System::world, 0, 1}}), std::invalid_argument);
  for (const int coordinate : {-1, 3})
    CHECK_THROWS_WITH(c.s.start_rates(q, {{c.wheel, coordinate, 1}}),
                      "wheel: has no coordinate " + std::to_string(coordinate));
  CHECK_THROWS_WITH(c.s.start_rates(q, {{c.wheel, 2, std::nan("")}}),
                    "wheel: its start rates must be finite");
  CHECK_THROWS_WITH(c.s.start_rates(VectorXd::Zero(3), {{c.wheel, 2, 1}}),
                    "q and v must have one entry for each coordinate");
  q[4] = INFINITY;
  CHECK(refused([&] {
          c.s.start_rates(q, {{c.wheel, 2, 1}});
        }) == "cannot start: q must be finite");
}
