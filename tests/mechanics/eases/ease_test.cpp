#include "mechanics/eases/ease.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "catch.hpp"

namespace {

const eases::Ease& ease(const char* name) { return eases::named(name); }

/// One unit in one second.
eases::Move unit(const eases::Ease& ease) { return {ease, 0, 1, 0, 1}; }

}  // namespace

TEST_CASE("each ease goes from 0 to 1, is its own half turn about the middle, and rests outside") {
  for (const eases::Ease& one : eases::all) {
    INFO(std::string(one.name));
    const eases::Move f = unit(one);
    CHECK(f(0).f == 0);
    CHECK(f(0).f_dot == 0);
    CHECK(f(0.5).f == Approx(0.5).epsilon(1e-15));
    CHECK(f(1).f == 1);
    CHECK(f(std::nextafter(1.0, 0.0)).f == Approx(1).epsilon(1e-15));
    CHECK(f(std::nextafter(1.0, 0.0)).f_dot == Approx(0).margin(1e-14));
    for (const double s : {0.1, 0.3, 0.45}) {
      CHECK(f(1 - s).f == Approx(1 - f(s).f));
      CHECK(f(1 - s).f_dot == Approx(f(s).f_dot));
      CHECK(f(1 - s).f_ddot == Approx(-f(s).f_ddot));
    }
    for (const double outside : {-0.2, 1.0, 7.0}) {
      CHECK(f(outside).f == (outside < 0 ? 0 : 1));
      CHECK(f(outside).f_dot == 0);
      CHECK(f(outside).f_ddot == 0);
    }
  }
}

TEST_CASE("f' and f'' of a move are the slopes of f and f', on either side of its jumps") {
  for (const eases::Ease& one : eases::all) {
    const eases::Move f{one, 0.7, -4.0, 0.3, 2.0};
    INFO(std::string(one.name));
    for (const double t : {0.35, 0.6, 0.99, 1.25, 1.35, 1.7, 2.2}) {
      const double h = 1e-5;
      CHECK(f(t).f_dot == Approx((f(t + h).f - f(t - h).f) / (2 * h)).margin(1e-8));
      CHECK(f(t).f_ddot == Approx((f(t + h).f_dot - f(t - h).f_dot) / (2 * h)).margin(1e-7));
    }
    CHECK(f.jumps() == std::array<double, 3>{0.3, 1.3, 2.3});
    CHECK(f(0.29).f == 0.7);
    CHECK(f(2.31).f == -3.3);
  }
}

TEST_CASE("the eases are the curves of their names") {
  constexpr double pi = std::numbers::pi;
  for (const double s : {0.0, 0.13, 0.37, 0.49, 0.51, 0.8, 0.97}) {
    CHECK(unit(ease("smooth"))(s).f ==
          Approx(10 * std::pow(s, 3) - 15 * std::pow(s, 4) + 6 * std::pow(s, 5)).margin(1e-15));
    CHECK(unit(ease("sine_in_out"))(s).f == Approx((1 - std::cos(pi * s)) / 2).margin(1e-15));
    int p = 2;
    for (const char* name :
         {"quadratic_in_out", "cubic_in_out", "quartic_in_out", "quintic_in_out"}) {
      const double first = std::pow(2 * s, p) / 2, second = 1 - std::pow(2 - 2 * s, p) / 2;
      CHECK(unit(ease(name))(s).f == Approx(s < 0.5 ? first : second).margin(1e-15));
      ++p;
    }
  }
}

TEST_CASE("what jumps: nothing, both ends by pi^2 / 2, or the middle by -4 p (p - 1)") {
  const auto jump = [](const char* name, double at) {
    const eases::Move f = unit(ease(name));
    return f(at).f_ddot - f(std::nextafter(at, -1.0)).f_ddot;
  };
  constexpr double half_square = std::numbers::pi * std::numbers::pi / 2;
  for (const double at : {0.0, 0.5, 1.0}) CHECK(std::abs(jump("smooth", at)) < 1e-12);
  CHECK(jump("sine_in_out", 0) == Approx(half_square));
  CHECK(std::abs(jump("sine_in_out", 0.5)) < 1e-12);
  CHECK(jump("sine_in_out", 1) == Approx(half_square));
  CHECK(jump("quadratic_in_out", 0) == Approx(4));
  int p = 2;
  for (const char* name :
       {"quadratic_in_out", "cubic_in_out", "quartic_in_out", "quintic_in_out"}) {
    CHECK(jump(name, 0.5) == Approx(-4 * p * (p - 1)));
    if (p > 2) CHECK(std::abs(jump(name, 0)) + std::abs(jump(name, 1)) < 1e-12);
    ++p;
  }
}

TEST_CASE("a rate that jumps is refused with its reason, other names with those there are") {
  CHECK_THROWS_WITH(eases::named("linear"), ContainsSubstring("infinite force"));
  CHECK_THROWS_WITH(eases::named("bounce"), ContainsSubstring("ease bounce: there is none") &&
                                                ContainsSubstring("smooth, sine_in_out") &&
                                                ContainsSubstring("quintic_in_out"));
  CHECK_THROWS_WITH(eases::named(""), ContainsSubstring("ease ''"));
}
