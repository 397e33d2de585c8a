#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>
#include <string>

#include "catch.hpp"
#include "mechanics/paths/by_length.hpp"
#include "mechanics/paths/path.hpp"

using namespace paths;
using std::numbers::pi;

namespace {

const Points five{{0, 0}, {1, 1}, {2, 0.4}, {3, 1.5}, {4, 0.2}};

/// Three pieces at uneven cues, the middle one three pieces itself.
Path nested() {
  const Path inner = sequence({{0, line({1, 1}, {2, 0.5})},
                               {0.2, cubic({{2, 0.5}, {2.5, 0.25}, {2.5, -1}, {3, -1}})},
                               {0.7, cosine_spline({{3, -1}, {4, 0}, {4.5, 0}})}});
  return sequence({{0, quadratic({{0, 0}, {0, 1}, {1, 1}})},
                   {0.3, inner},
                   {0.9, catmull_rom({{4.5, 0}, {5, 1}, {6, 1}})}});
}

std::map<std::string, Path> all() {
  return {{"line", line({1, 2}, {-3, 0.5})},
          {"circle", circle(1.5)},
          {"cycloid", cycloid(0.7)},
          {"spiral", spiral(1, 0.2, 4)},
          {"sine", sine(3, 0.3, 3)},
          {"quadratic", quadratic({{0, 0}, {1, 2}, {2, -1}})},
          {"cubic", cubic({{0, 0}, {1, 2}, {2, -1}, {3, 0.5}})},
          {"linear_spline", linear_spline(five)},
          {"cosine_spline", cosine_spline(five)},
          {"hermite_spline", hermite_spline(five, {{1, 0}, {0, 2}, {1, 1}, {3, 0}, {0, -1}})},
          {"catmull_rom", catmull_rom(five)},
          {"projectile", projectile({2, -3}, 9.81, 2.0)},
          {"sequence", nested()}};
}

std::vector<double> ends_of(const Path& path) {
  std::vector<double> ends{path.first};
  ends.insert(ends.end(), path.knots.begin(), path.knots.end());
  ends.push_back(path.last);
  return ends;
}

bool near(const Vector2d& a, const Vector2d& b, double most = 1e-13) {
  return (a - b).norm() <= most * (1.0 + a.norm());
}

std::string refusal(const std::function<void()>& make) {
  try {
    make();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("x' and x'' are the derivatives of x, by finite differences inside every piece") {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> part(0.05, 0.95);
  for (const auto& [name, path] : all()) {
    const std::vector<double> ends = ends_of(path);
    for (std::size_t i = 1; i < ends.size(); ++i)
      for (int trial = 0; trial < 20; ++trial) {
        const double width = ends[i] - ends[i - 1], q = ends[i - 1] + part(generator) * width;
        const double h = 5e-4 * width;
        INFO(name << " at " << q);
        const auto x = [&, &path = path](int k) { return path(q + k * h).x; };
        const Vector2d d = (8 * (x(1) - x(-1)) - (x(2) - x(-2))) / (12 * h);
        const Vector2d dd = (16 * (x(1) + x(-1)) - (x(2) + x(-2)) - 30 * x(0)) / (12 * h * h);
        const double size = path(q).d.norm() + path(q).dd.norm() * width;
        CHECK((path(q).d - d).norm() <= 1e-8 * size);
        CHECK((path(q).dd - dd).norm() * width <= 1e-7 * size);
      }
  }
}

TEST_CASE("paths begin, end and lie where their definitions say, y down") {
  CHECK(near(circle(2)(0).x, {0, 2}));
  CHECK(near(circle(2)(pi / 2).x, {2, 0}));
  CHECK(near(cycloid(2)(0).x, {0, 4}));
  CHECK(near(cycloid(2)(pi).x, {2 * pi, 0}));
  CHECK(near(spiral(1, 0.2, 4)(1).x, {0.2 * std::cos(4), 0.2 * std::sin(4)}));
  CHECK(near(sine(3, 0.3, 3)(0.25 / 3).x, {0.25, 0.3}));
  CHECK(near(quadratic({{0, 0}, {1, 2}, {2, -1}})(0.5).x, {1, 0.75}));
  const Path cubic_path = cubic({{0, 0}, {1, 2}, {2, -1}, {3, 0.5}});
  CHECK(near(cubic_path(0).d, {3, 6}));
  CHECK(near(cubic_path(1).x, {3, 0.5}));
  CHECK(near(cubic_path(1).d, {3, 4.5}));
  CHECK(near(projectile({2, -3}, 9.81)(0.5).x, {1, -1.5 + 9.81 / 8}));
  CHECK(near(cosine_spline({{0, 0}, {2, 1}})(0.25).x, {0.5, (1 - std::sqrt(0.5)) / 2}));
}

TEST_CASE("splines go through their points, and as smoothly as they promise") {
  const auto jump = [](const Path& path, double knot, int derivative) {
    const Place after = path(knot), before = path(std::nextafter(knot, 0.0));
    return derivative == 1 ? (after.d - before.d).norm() : (after.dd - before.dd).norm();
  };
  const Points tangents{{1, 0}, {0, 2}, {1, 1}, {3, 0}, {0, -1}};
  for (const Path& path : {linear_spline(five), cosine_spline(five), hermite_spline(five, tangents),
                           catmull_rom(five)})
    for (std::size_t i = 0; i < 5; ++i) CHECK(near(path(static_cast<double>(i)).x, five[i]));
  for (std::size_t i = 0; i < 5; ++i)
    CHECK(near(hermite_spline(five, tangents)(static_cast<double>(i)).d, tangents[i]));
  for (const double knot : {1.0, 2.0, 3.0}) {
    CHECK(jump(linear_spline(five), knot, 1) > 0.5);
    CHECK(jump(cosine_spline(five), knot, 1) < 1e-12);  // of points evenly spaced in x
    CHECK(jump(catmull_rom(five), knot, 1) < 1e-12);
    CHECK(jump(catmull_rom(five), knot, 2) > 0.5);
  }
  // The curvature on both sides of knot 2, from the definition of the spline by other means.
  const auto curvature = [](const Place& p) {
    return std::abs(p.d.x() * p.dd.y() - p.d.y() * p.dd.x()) / std::pow(p.d.norm(), 3);
  };
  CHECK(curvature(catmull_rom(five)(std::nextafter(2.0, 0.0))) == Approx(4.56537647127215));
  CHECK(curvature(catmull_rom(five)(2.0)) == Approx(5.29583670667569));
  CHECK(near(catmull_rom(five)(0).d, {0.5, 0.5}));  // the first point stands for the one before
}

TEST_CASE("a sequence runs its pieces between their cues, two levels deep") {
  const Path path = nested();
  // q of the whole at the inner cues: 0.3 + 0.6 · 0.2 and so on.
  const std::vector<double> cues{0.3, 0.42, 0.72, 0.81, 0.9, 0.95};
  REQUIRE(path.knots.size() == cues.size());
  for (std::size_t i = 0; i < cues.size(); ++i) CHECK(path.knots[i] == Approx(cues[i]));
  const Points places{{1, 1}, {2, 0.5}, {3, -1}, {4, 0}, {4.5, 0}, {5, 1}};
  // x′ before and after each, by the chain rule from the pieces: their x′ over the width in q.
  const Points before{{2 / 0.3, 0},  {1 / 0.12, -0.5 / 0.12}, {1.5 / 0.3, 0},
                      {1 / 0.09, 0}, {0.5 / 0.09, 0},         {0.75 / 0.05, 0.5 / 0.05}},
      after{{1 / 0.12, -0.5 / 0.12}, {1.5 / 0.3, -0.75 / 0.3},  {1 / 0.09, 0},
            {0.5 / 0.09, 0},         {0.25 / 0.05, 0.5 / 0.05}, {0.75 / 0.05, 0.5 / 0.05}};
  for (std::size_t i = 0; i < cues.size(); ++i) {
    INFO("cue " << cues[i]);
    const double little = 1e-12;
    CHECK(near(path(cues[i] - little).x, places[i], 1e-10));
    CHECK(near(path(cues[i] + little).x, places[i], 1e-10));
    CHECK(near(path(cues[i] - little).d, before[i], 1e-9));
    CHECK(near(path(cues[i] + little).d, after[i], 1e-9));
  }
  CHECK(near(path(0.0).x, {0, 0}));
  CHECK(near(path(1.0).x, {6, 1}));
  CHECK_FALSE(path.closed);
}

TEST_CASE("the length is that of the closed forms, and q(s) its inverse, in any order") {
  const auto length = [](const Path& path) { return ByLength(path).length(); };
  CHECK(length(line({1, 2}, {4, 6})) == Approx(5).epsilon(1e-15));
  CHECK(length(circle(1.5)) == Approx(3 * pi).epsilon(1e-14));
  CHECK(length(cycloid(0.7)) == Approx(8 * 0.7).epsilon(1e-14));
  CHECK(length(linear_spline({{0, 0}, {3, 4}, {3, 6}})) == Approx(7).epsilon(1e-15));
  const ByLength arch(cycloid(1));
  for (const double q : {-3.0, -0.1, 0.4, 2.0, pi})
    CHECK(arch.s(q) == Approx(4 + 4 * std::sin(q / 2)).epsilon(1e-14));

  const double r0 = 1, r1 = 0.2, A = 4, k = (r1 - r0) / A;
  const auto G = [&](double r) {
    const double root = std::hypot(r, k);
    return (r * root + k * k * std::asinh(r / std::abs(k))) / (2 * std::abs(k));
  };
  CHECK(length(spiral(r0, r1, A)) == Approx(G(r0) - G(r1)).epsilon(1e-14));
  CHECK(length(spiral(r0, r1, A)) == Approx(2.55119487598440).epsilon(1e-14));

  const double b = 2 * pi * 3 * 0.3 / 3, m = b * b / (1 + b * b);
  CHECK(length(sine(3, 0.3, 3)) ==
        Approx(4 * 3 * std::sqrt(1 + b * b) * std::comp_ellint_2(std::sqrt(m)) * 3 / (6 * pi))
            .epsilon(1e-14));
  CHECK(length(cubic({{0, 0}, {1, 2}, {2, -1}, {3, 0.5}})) ==
        Approx(3.65062828317175).epsilon(1e-14));
  // A parabola x = 2q, y = 4q(1 − q): ∫ √(4 + 16 (1 − 2q)²) dq with u = 2(1 − 2q).
  CHECK(length(quadratic({{0, 0}, {1, 2}, {2, 0}})) ==
        Approx(std::sqrt(5) + std::asinh(2) / 2).epsilon(1e-14));
  // With u = vy/vx the way is vx²/g ∫ √(1 + u²) du.
  const auto way = [](double u) { return (u * std::hypot(1.0, u) + std::asinh(u)) / 2; };
  CHECK(ByLength(projectile({2, -3}, 9.81)).s(1.5) ==
        Approx(4 / 9.81 * (way((9.81 * 1.5 - 3) / 2) - way(-1.5))).epsilon(1e-13));

  std::mt19937 generator(2);
  for (const auto& [name, path] : all()) {
    INFO(name);
    ByLength by_length(path);
    for (int trial = 0; trial < 200; ++trial) {
      const double q = std::uniform_real_distribution<double>(path.first, path.last)(generator);
      CHECK(std::abs(by_length.q(by_length.s(q)) - q) <= 1e-12 * (path.last - path.first));
    }
  }
}

TEST_CASE("a closed path counts on, in q and in s") {
  ByLength ring{circle(2)};
  for (const int turns : {-3, 0, 5}) {
    CHECK(near(circle(2)(0.5 + 2 * pi * turns).x, circle(2)(0.5).x));
    CHECK(ring.s(0.5 + 2 * pi * turns) == Approx(2 * (0.5 + pi) + 4 * pi * turns).epsilon(1e-13));
    CHECK(ring.q(2 * (0.5 + pi) + 4 * pi * turns) == Approx(0.5 + 2 * pi * turns).epsilon(1e-13));
  }
  CHECK(linear_spline({{0, 0}, {1, 0}, {1, 1}, {0, 0}}).closed);
  CHECK(sequence({{0, line({0, 0}, {1, 0})}, {0.5, line({1, 0}, {0, 0})}}).closed);
}

TEST_CASE("where x' is zero there is a tangent, that of the way on or, at an end, there") {
  const ByLength arch(cycloid(1));
  CHECK(near(arch.tangent(pi), {0, -1}));
  CHECK(near(arch.tangent(-pi), {0, 1}));
  const ByLength bent(cubic({{0, 0}, {0, 0}, {1, 2}, {2, 0}}));
  CHECK(near(bent.tangent(0), Vector2d(1, 2).normalized()));
  const double s = 1e-10, q = bent.q(s);  // s = |x″| q²/2 there, x″ = 6 (1, 2)
  CHECK(q == Approx(std::sqrt(2 * s / (6 * std::sqrt(5)))).epsilon(1e-4));
}

TEST_CASE("beyond an open end q goes on") {
  ByLength straight{line({0, 0}, {2, 0})};
  CHECK(straight.q(3) == Approx(1.5));
  CHECK(straight.q(-1) == Approx(-0.5));
}

TEST_CASE("what makes no path is refused in words") {
  CHECK(refusal([] { line({1, 2}, {1, 2}); }) == "points: all of a line are (1, 2)");
  CHECK(refusal([] { cubic({{0, 0}, {1, 1}}); }) == "points: a cubic needs 4, not 2");
  CHECK(refusal([] {
          quadratic({{0, 0}, {1, 1}, {2, 2}, {3, 3}});
        }) == "points: a quadratic needs 3, not 4");
  CHECK(refusal([] { catmull_rom({{0, 0}}); }) == "points: a catmull_rom needs 2 to 10000, not 1");
  CHECK(refusal([] { linear_spline({{0, 0}, {1, 1}, {1, 1}}); }).starts_with("points: two in a"));
  CHECK(refusal([] {
          hermite_spline({{0, 0}, {1, 1}}, {{1, 0}});
        }) == "tangents: a hermite_spline needs one at each point, 2, not 1");
  CHECK(refusal([] { spiral(1, 1, 0); }).starts_with("turns: "));
  CHECK(refusal([] { projectile({0, -1}, 9.81); }).starts_with("launch: "));
  CHECK(refusal([] { sequence({}); }) == "sequence: it has no piece");
  const Path a = line({0, 0}, {1, 0}), b = line({1, 0.5}, {2, 0});
  CHECK(refusal([&] {
          sequence({{0, a}, {0.5, b}});
        }) == "sequence: pieces 1 and 2 do not meet: (1, 0), (1, 0.5)");
  for (const auto& cues : {std::pair{0.1, 0.5}, std::pair{0.0, 0.0}, std::pair{0.0, 1.0}})
    CHECK(refusal([&] {
            sequence({{cues.first, a}, {cues.second, a}});
          }) == "sequence: cues begin with 0, grow by 1e-6 and stay below 1");
  CHECK(refusal([] {
          ByLength(cubic({{0, 0}, {0, 0}, {0, 0}, {1, 1}}));
        }) == "path: no tangent at q = 0, where x' and x'' are zero");
  CHECK(refusal([] {
          ByLength(hermite_spline({{1, 1}, {1, 1}, {2, 2}}, {{0, 0}, {0, 0}, {1, 1}}));
        }).starts_with("path: no length between q = 0 and "));
  CHECK(refusal([] {
          quadratic({{1, 1}, {1, 1}, {1, 1}});
        }) == "points: all of a quadratic are (1, 1)");
}

TEST_CASE("whether pieces meet is a matter of their size, wherever they lie, and told in digits") {
  for (const double size : {1e-6, 1.0, 1e6})
    for (const Vector2d& at : {Vector2d(0, 0), Vector2d(-30 * size, 50 * size)})
      for (const double gap : {1e-10, 1e-8}) {
        INFO(size << " at " << at.x() << ", gap " << gap);
        const auto place = [&](double x) { return Vector2d(at + Vector2d(x * size, 0)); };
        const std::string text = refusal([&] {
          sequence({{0, line(place(0), place(1))}, {0.5, line(place(1 + gap), place(2))}});
        });
        REQUIRE((text == "accepted") == (gap < 1e-9));
        REQUIRE((refusal([&] {
                   linear_spline({place(0), place(1), place(1 + gap), place(2)});
                 }) == "accepted") == (gap > 1e-9));
        REQUIRE(linear_spline({place(0), at + Vector2d(0, size), place(1), place(gap)}).closed ==
                (gap < 1e-9));
        if (text == "accepted") continue;
        const std::size_t one = text.find('('), other = text.rfind('(');
        REQUIRE(text.substr(one, text.find(')') - one) !=
                text.substr(other, text.rfind(')') - other));
      }
}

TEST_CASE("at a knot a path has a tangent of what begins and one of what ends") {
  const Path corner = linear_spline({{0, 0}, {1, 0}, {1, 2}, {0, 0}});
  CHECK(near(corner(1).d, {0, 2}));
  CHECK(near(corner.behind(1).d, {1, 0}));
  CHECK(near(corner.behind(0).d, {-1, -2}));  // closed
  for (const double q : {0.0, 1.0, 2.0, 3.0, -5.0}) CHECK(corner.is_knot(q));
  for (const double q : {0.1, 1.5, 1 + 1e-9}) CHECK_FALSE(corner.is_knot(q));
  CHECK_FALSE(line({0, 0}, {1, 0}).is_knot(1));
  // A cusp, where x turns back: x' is zero on both sides, and the way on is the way there.
  const Path cusp = hermite_spline({{0, 0}, {1, 0}, {0, 1}}, {{1, 0}, {0, 0}, {0, 1}});
  const ByLength by(cusp);
  CHECK(near(by.tangent(1, true), {1, 0}));
  CHECK(by.tangent(1).x() < -0.1);
}
