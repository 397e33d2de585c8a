// What a scene that is put together wrongly says: docs/your_own_scene.md shows these lines.

#include "catch.hpp"
#include "mechanics/dynamics/system.hpp"
#include "mechanics/joints/distance.hpp"
#include "mechanics/joints/revolute.hpp"

namespace {

/// What is thrown at a mistake.
template <class Mistake>
std::string says(const Mistake& mistake) {
  try {
    mistake();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing";
}

}  // namespace

TEST_CASE("a scene that is put together wrongly says what is wrong, and names it") {
  using joints::Revolute;
  dynamics::System system, other;
  const auto rod = system.add_body("rod", 1, 1, {0, 0});
  const auto wheel = other.add_body("wheel", 1, 1, {0, 0});
  Eigen::VectorXd q = system.initial_q(), v = system.initial_v();

  // [messages]
  CHECK(says([&] {
          system.add_body("plate", -1, 1, {0, 0});
        }) == "plate: mass and inertia must be positive and finite, and so must be their inverses");
  CHECK(says([&] { system.add_body("rod", 1, 1, {0, 0}); }) == "rod: another thing has this name");
  CHECK(says([&] { system.add("loop", Revolute{}, rod, rod); }) == "loop: joins a thing to itself");
  CHECK(says([&] { system.add("pin", Revolute{}, rod, wheel); }) ==
        "pin: a handle of another System, or of none");

  // A rod that is held at both ends, by pins further apart than its ends are.
  system.add("left", Revolute{.u1 = {-0.5, 0}, .u2 = {-0.5, 0}}, rod);
  system.add("right", Revolute{.u1 = {0.5, 0}, .u2 = {0.7, 0}}, rod);
  CHECK(says([&] { system.assemble(0, q, v); }) ==
        "cannot assemble: left row 1 (m) stays open by 0.1");

  // A thing that comes after q was taken has no place in it.
  system.add_particle("bead", 1, {1, 0});
  dynamics::Evaluation e(system);
  CHECK(says([&] { system.evaluate(0, q, v, e); }) ==
        "q and v must have one entry for each coordinate");
  // [messages]
}
