#include <Eigen/Core>
#include <cmath>

#include "allocations.hpp"
#include "catch.hpp"
#include "integrators/amplification.hpp"
#include "integrators/integrator.hpp"

using integrators::Integrator;
using integrators::Name;

namespace {

// q(t) = sin t + e⁻ᵗ, written so that the acceleration depends on t, q and v.
double exact_q(double t) { return std::sin(t) + std::exp(-t); }
double exact_v(double t) { return std::cos(t) - std::exp(-t); }
const auto acceleration = [](double t, const auto& q, const auto& v, auto& a) {
  a = -q - v;
  if constexpr (std::is_same_v<std::decay_t<decltype(a)>, double>)
    a += 2.0 * std::exp(-t) + exact_v(t);
  else
    a.array() += 2.0 * std::exp(-t) + exact_v(t);
};

template <class Vector>
std::pair<Vector, Vector> run(Name name, Vector q, Vector v, int steps) {
  Integrator<Vector> integrator(name, q);
  const double h = 2.0 / steps;
  for (int i = 0; i < steps; ++i) integrator.step(acceleration, i * h, q, v, h);
  return {q, v};
}

}  // namespace

TEST_CASE("every integrator converges with its order in q and in v") {
  for (const auto& method : integrators::methods) {
    INFO(method.text);
    const int steps = 160;
    const auto [q1, v1] = run(method.name, exact_q(0), exact_v(0), steps);
    const auto [q2, v2] = run(method.name, exact_q(0), exact_v(0), 2 * steps);
    CHECK(std::log2(std::abs((q1 - exact_q(2)) / (q2 - exact_q(2)))) ==
          Approx(method.order).margin(0.15));
    CHECK(std::log2(std::abs((v1 - exact_v(2)) / (v2 - exact_v(2)))) ==
          Approx(method.order).margin(0.15));
  }
}

TEST_CASE("scalar, fixed-size and dynamic vectors take the same steps") {
  for (const auto& method : integrators::methods) {
    INFO(method.text);
    const auto scalar = run(method.name, exact_q(0), exact_v(0), 50);
    const auto fixed = run<Eigen::Vector2d>(method.name, Eigen::Vector2d::Constant(exact_q(0)),
                                            Eigen::Vector2d::Constant(exact_v(0)), 50);
    const auto dynamic = run<Eigen::VectorXd>(method.name, Eigen::VectorXd::Constant(5, exact_q(0)),
                                              Eigen::VectorXd::Constant(5, exact_v(0)), 50);
    for (int i = 0; i < 2; ++i) CHECK(fixed.first[i] == Approx(scalar.first).epsilon(1e-15));
    for (int i = 0; i < 5; ++i) CHECK(dynamic.first[i] == Approx(scalar.first).epsilon(1e-15));
    for (int i = 0; i < 5; ++i) CHECK(dynamic.second[i] == Approx(scalar.second).epsilon(1e-15));
  }
}

TEST_CASE("a step of a dynamic vector allocates nothing") {
  for (const auto& method : integrators::methods) {
    INFO(method.text);
    Eigen::VectorXd q = Eigen::VectorXd::Ones(40), v = q;
    Integrator<Eigen::VectorXd> integrator(method.name, q);
    const long before = allocations();
    for (int i = 0; i < 10; ++i) integrator.step(acceleration, 0.1 * i, q, v, 0.1);
    CHECK(allocations() == before);
  }
}

TEST_CASE("one RK4 step of an oscillator is the Taylor series up to h⁴") {
  double q = 1.0, v = 0.0;
  const double h = 0.3;
  integrators::Rk4<double>(0.0).step([](double, double x, double, double& a) { a = -x; }, 0, q, v,
                                     h);
  CHECK(q == Approx(1 - h * h / 2 + std::pow(h, 4) / 24).epsilon(1e-15));
  CHECK(v == Approx(-h + std::pow(h, 3) / 6).epsilon(1e-15));
}

TEST_CASE("the largest stable step of critically damped feedback is the textbook number") {
  // RK4: the real root of 1 + z + z²/2 + z³/6 + z⁴/24 = 1 is z = −2.78529…; Euler: z = −2;
  // semi-implicit Euler at kd = 2√ks: the characteristic polynomial passes −1 at s = 2√2 − 2.
  const double ks = 9.0, kd = 6.0, rate = 3.0;
  const auto limit = [&](Name name) {
    return rate * integrators::largest_stable_step(name, ks, kd);
  };
  CHECK(limit(Name::rk4) == Approx(2.785293563405282).epsilon(1e-6));
  CHECK(limit(Name::explicit_euler) == Approx(2.0).epsilon(1e-6));
  CHECK(limit(Name::semi_implicit_euler) == Approx(2.0 * std::sqrt(2.0) - 2.0).epsilon(1e-6));
}
