#include <cmath>

#include "catch.hpp"
#include "mechanics/motion/motion.hpp"
#include "scene.hpp"

TEST_CASE("four-bar: the rocker is where Freudenstein's equation puts it, and work is energy") {
  const four_bar::Scene scene{.theta0 = 0.4};
  const mechanics::Method method{.stabilization = mechanics::Stabilization::projection};
  mechanics::Motion motion(four_bar::make_mechanism(scene, method), method);
  const double balance = motion.measures().balance();
  for (int i = 0; i < 20; ++i) {
    motion.advance(50, 1e-3);
    CHECK(motion.q()[8] == Approx(scene.rocker_angle(motion.q()[2])).margin(1e-12));
    CHECK(motion.measures().balance() == Approx(balance).margin(1e-3));
  }
}

TEST_CASE("four-bar: a crank that cannot go round is refused") {
  CHECK_THROWS_WITH(four_bar::make_mechanism({.crank = 0.7}, {}), ContainsSubstring("crank 0.7"));
}
