// Cases of which ctest has to say what house_test.cpp expects: all failed but the last ones.
#include <cstdlib>
#include <stdexcept>

#include "catch.hpp"
#include "random.hpp"

// By itself Catch2 2 would exit with the number of failed checks, 255 at most, Catch2 3 with 42.
TEMPLATE_TEST_CASE_SIG("failed checks", "", ((int N), N), 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 42, 77,
                       127, 128, 255, 256, 257, 512) {
  for (int i = 0; i < N; ++i) CHECK(i < 0);
}
TEST_CASE("a failed requirement") { REQUIRE(random_seed == 0); }
TEST_CASE("an exception") { throw std::runtime_error("thrown"); }
TEST_CASE("no assertion") {}
TEST_CASE("a crash") { std::abort(); }
#if CATCH_VERSION_MAJOR >= 3
TEST_CASE("a skip of Catch2's own") { SKIP("nothing"); }
#endif

TEST_CASE("random numbers") { CHECK(generator() == std::mt19937(random_seed)()); }
TEST_CASE("the same random numbers") { CHECK(generator() == std::mt19937(random_seed)()); }
