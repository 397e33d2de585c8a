#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "allocations.hpp"
#include "catch.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "mechanics/integrators/integrator.hpp"

using integrators::Integrator;
using integrators::Scheme;

namespace {

// q(t) = sin 3t + e⁻ᵗ, written so that the acceleration depends on t, q and v.
double exact_q(double t) { return std::sin(3 * t) + std::exp(-t); }
double exact_v(double t) { return 3 * std::cos(3 * t) - std::exp(-t); }
const auto acceleration = [](double t, const auto& q, const auto& v, auto& a) {
  a = -9.0 * q - v;
  if constexpr (std::is_same_v<std::decay_t<decltype(a)>, double>)
    a += 10.0 * std::exp(-t) + exact_v(t);
  else
    a.array() += 10.0 * std::exp(-t) + exact_v(t);
};

template <class Vector>
std::pair<Vector, Vector> run(Scheme name, Vector q, Vector v, int steps) {
  Integrator<Vector> integrator(name, q);
  const double h = 2.0 / steps;
  for (int i = 0; i < steps; ++i) integrator.step(acceleration, i * h, q, v, h);
  return {q, v};
}

}  // namespace

TEST_CASE("every integrator converges with its order") {
  for (const auto& scheme : integrators::schemes) {
    INFO(scheme.text);
    const auto error = [&](int steps) {
      const auto [q, v] = run(scheme.id, exact_q(0), exact_v(0), steps);
      return std::hypot(q - exact_q(2), v - exact_v(2));
    };
    const int steps = scheme.order == 8 ? 12 : 320;  // an order of 8 soon meets rounding
    CHECK(std::log2(error(steps) / error(2 * steps)) == Approx(scheme.order).margin(0.15));
  }
}

TEST_CASE("scalar, fixed-size and dynamic vectors take the same steps") {
  for (const auto& scheme : integrators::schemes) {
    INFO(scheme.text);
    const auto scalar = run(scheme.id, exact_q(0), exact_v(0), 50);
    const auto fixed = run<Eigen::Vector2d>(scheme.id, Eigen::Vector2d::Constant(exact_q(0)),
                                            Eigen::Vector2d::Constant(exact_v(0)), 50);
    const auto dynamic = run<Eigen::VectorXd>(scheme.id, Eigen::VectorXd::Constant(5, exact_q(0)),
                                              Eigen::VectorXd::Constant(5, exact_v(0)), 50);
    // Where the processor fuses products and sums, each of the three loops rounds otherwise.
    constexpr double rounding = 50 * std::numeric_limits<double>::epsilon();  // one each step
    for (int i = 0; i < 2; ++i) CHECK(std::abs(fixed.first[i] - scalar.first) < rounding);
    for (int i = 0; i < 5; ++i) CHECK(std::abs(dynamic.first[i] - scalar.first) < rounding);
    for (int i = 0; i < 5; ++i) CHECK(std::abs(dynamic.second[i] - scalar.second) < rounding);
  }
}

TEST_CASE("a step of a dynamic vector allocates nothing") {
  for (const auto& scheme : integrators::schemes) {
    INFO(scheme.text);
    Eigen::VectorXd q = Eigen::VectorXd::Ones(40), v = q;
    Integrator<Eigen::VectorXd> integrator(scheme.id, q);
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

// A Runge–Kutta method has order p when b·Φ(τ) = 1/γ(τ) for every rooted tree τ of up to p nodes.
// Trees are grown leaf by leaf: Φ of a tree is the product of A Φ over its branches, γ the number
// of its nodes times the γ of its branches.
TEST_CASE("the coefficients of dop853 satisfy the conditions of order 8, its estimates 5 and 3") {
  using namespace integrators::dop853;
  using Stage = std::array<double, stages>;
  struct Tree {
    Stage Phi;  // without the root's own A
    double gamma;
  };
  const auto dot = [](const Stage& w, const Stage& x) {
    double sum = 0;
    for (std::size_t i = 0; i < stages; ++i) sum += w[i] * x[i];
    return sum;
  };
  for (std::size_t i = 0; i < stages; ++i) {
    double sum = 0;
    for (const double w : weights[i]) sum += w;
    CHECK(sum == Approx(c[i]).margin(1e-14));
  }
  std::vector<std::vector<Tree>> trees(9);  // by their number of nodes
  Stage one;
  one.fill(1.0);
  trees[1] = {{one, 1.0}};
  for (std::size_t nodes = 2; nodes <= 8; ++nodes) {
    // A tree is a multiset of branches, taken in the order in which they were found.
    std::vector<std::pair<std::size_t, std::size_t>> branches;  // (nodes, which)
    for (std::size_t n = 1; n < nodes; ++n)
      for (std::size_t k = 0; k < trees[n].size(); ++k) branches.emplace_back(n, k);
    const auto grow = [&](const auto& self, std::size_t first, std::size_t left,
                          const Tree& tree) -> void {
      if (left == 0) {
        trees[nodes].push_back({tree.Phi, tree.gamma * double(nodes)});
        return;
      }
      for (std::size_t i = first; i < branches.size() && branches[i].first <= left; ++i) {
        const Tree& branch = trees[branches[i].first][branches[i].second];
        Tree next = tree;
        for (std::size_t s = 0; s < stages; ++s) next.Phi[s] *= dot(weights[s], branch.Phi);
        next.gamma *= branch.gamma;
        self(self, i, left - branches[i].first, next);
      }
    };
    grow(grow, 0, nodes - 1, {one, 1.0});
  }
  const std::size_t rooted_trees[] = {0, 1, 1, 2, 4, 9, 20, 48, 115};  // Cayley's numbers
  double violated_by_3 = 0, violated_by_5 = 0;
  for (std::size_t nodes = 1; nodes <= 8; ++nodes) {
    CHECK(trees[nodes].size() == rooted_trees[nodes]);
    for (const Tree& tree : trees[nodes]) {
      INFO(nodes << " nodes, gamma " << tree.gamma);
      CHECK(dot(weights[whole_step], tree.Phi) == Approx(1 / tree.gamma).margin(2e-14));
      const double three = std::abs(dot(weights[error_3], tree.Phi));
      const double five = std::abs(dot(weights[error_5], tree.Phi));
      if (nodes <= 3) CHECK(three < 1e-13);
      if (nodes <= 5) CHECK(five < 1e-13);
      if (nodes == 4) violated_by_3 = std::max(violated_by_3, three);
      if (nodes == 6) violated_by_5 = std::max(violated_by_5, five);
    }
  }
  CHECK(violated_by_3 > 1e-3);
  CHECK(violated_by_5 > 1e-5);
}

TEST_CASE("with a tolerance dop853 takes the steps that the error needs, and no short last one") {
  double evaluations_before = 0;
  for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
    double q = exact_q(0), v = exact_v(0), evaluations = 0, shortest = 2.0;
    Integrator<double> integrator(Scheme::dop853, q, tolerance);
    const auto counted = [&](double t, const double& x, const double& w, double& a) {
      ++evaluations;
      acceleration(t, x, w, a);
    };
    double t = 0.0;
    while (t < 2.0) {
      const double taken = integrator.step(counted, t, q, v, 2.0 - t);
      if (t > 0.0) shortest = std::min(shortest, taken);
      t += taken;
    }
    INFO("tolerance " << tolerance << ", evaluations " << evaluations);
    CHECK(std::abs(q - exact_q(2)) < 10 * tolerance);
    CHECK(evaluations >= evaluations_before);
    CHECK(evaluations < 500);
    evaluations_before = evaluations;
  }
}

TEST_CASE("dop853 says when no step is short enough") {
  double q = 0.0, v = 0.0;
  Integrator<double> integrator(Scheme::dop853, q, 1e-6);
  const auto never_finite = [](double, double, double, double& a) { a = std::nan(""); };
  CHECK_THROWS_AS(integrator.step(never_finite, 1.0, q, v, 1.0), integrators::NoStep);
}

TEST_CASE("the implicit midpoint rule holds the stiffest spring at any step, and its energy") {
  // One step of length h of x'' = −k x turns (√k x, v) by the angle 2 atan(h√k/2), exactly.
  for (const double k : {1e-6, 1.0, 1e4, 1e10})
    for (const double h : {1e-3, 1.0}) {
      INFO("k = " << k << ", h = " << h);
      Integrator<double> integrator(Scheme::implicit_midpoint, 1.0);
      double q = 1.0, v = 0.0;
      const int steps = 1000;
      for (int i = 0; i < steps; ++i)
        integrator.step([&](double, double x, double, double& a) { a = -k * x; }, i * h, q, v, h);
      const double turned = steps * 2.0 * std::atan(0.5 * h * std::sqrt(k));
      CHECK(q == Approx(std::cos(turned)).margin(1e-11 * steps));
      CHECK(q * q + v * v / k == Approx(1.0).epsilon(1e-11));
    }
}

TEST_CASE("the implicit midpoint rule solves its equation however many steps a slow motion takes") {
  // The slow motion of q'' = -k q - c v, v = -r q, is multiplied by (1 - r h/2) / (1 + r h/2).
  const double k = 1e4, c = 1e5, r = 2 * k / (c + std::sqrt(c * c - 4 * k));
  for (const int steps : {8, 1000, 32768, 65536, 131072}) {
    INFO(steps << " steps");
    const double h = 2.0 / steps;
    Integrator<double> integrator(Scheme::implicit_midpoint, 0.1);
    double q = 0.1, v = -r * q;
    for (int i = 0; i < steps; ++i)
      integrator.step([&](double, double x, double u, double& a) { a = -k * x - c * u; }, i * h, q,
                      v, h);
    CHECK(std::abs(q - 0.1 * std::exp(-2 * steps * std::atanh(r * h / 2))) < 1e-13);
  }
}

TEST_CASE("the implicit midpoint rule solves stiff and soft parts together") {
  // A chain of springs whose stiffnesses spread over ten decades, with a nonlinear one among them.
  const int n = 6;
  const auto springs = [](double, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                          Eigen::VectorXd& a) {
    a = -0.1 * v;
    for (int i = 0; i < n; ++i) {
      const double d = q[i] - (i > 0 ? q[i - 1] : 0.0);
      const double f = -std::pow(10.0, 2 * i) * d - d * d * d;
      a[i] += f;
      if (i > 0) a[i - 1] -= f;
    }
  };
  Eigen::VectorXd q = Eigen::VectorXd::LinSpaced(n, 0.1, 1.0), v = Eigen::VectorXd::Zero(n), a = v;
  Integrator<Eigen::VectorXd> integrator(Scheme::implicit_midpoint, q);
  const double h = 0.05;
  for (int i = 0; i < 100; ++i) {
    const Eigen::VectorXd q0 = q, v0 = v;
    integrator.step(springs, 0.0, q, v, h);
    const Eigen::VectorXd q_mid = 0.5 * (q0 + q), v_mid = 0.5 * (v0 + v);
    springs(0.0, q_mid, v_mid, a);
    REQUIRE((q - q0 - h * v_mid).norm() < 1e-14);
    REQUIRE((v - v0 - h * a).norm() < 1e-5 * h);  // 1e10 N/m times the rounding of q
    REQUIRE(q.norm() < 2.0);
  }
}

TEST_CASE("a step that cannot be solved is an exception, not a wrong state") {
  double q = 1.0, v = 0.0;
  Integrator<double> integrator(Scheme::implicit_midpoint, q);
  long calls = 0;
  const auto restless = [&](double, double, double, double& a) { a = ++calls % 2 ? 1.0 : -1.0; };
  CHECK_THROWS_AS(integrator.step(restless, 0.0, q, v, 1.0), integrators::NoStep);
}

TEST_CASE("the largest stable step of critically damped feedback is the textbook number") {
  // RK4: the real root of 1 + z + z²/2 + z³/6 + z⁴/24 = 1 is z = −2.78529…; Euler: z = −2;
  // semi-implicit Euler at kd = 2√ks: the characteristic polynomial passes −1 at s = 2√2 − 2.
  const double ks = 9.0, kd = 6.0, rate = 3.0;
  const auto limit = [&](Scheme name) {
    return rate * integrators::largest_stable_step(name, ks, kd);
  };
  CHECK(limit(Scheme::rk4) == Approx(2.785293563405282).epsilon(1e-6));
  CHECK(limit(Scheme::explicit_euler) == Approx(2.0).epsilon(1e-6));
  CHECK(limit(Scheme::semi_implicit_euler) == Approx(2.0 * std::sqrt(2.0) - 2.0).epsilon(1e-6));
}
