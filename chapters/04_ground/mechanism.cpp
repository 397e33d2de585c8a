#include "mechanism.hpp"

#include "mechanics/joints/ground.hpp"
#include "mechanics/joints/revolute.hpp"

namespace ground {

mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method) {
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  const auto plate = system.add_body("plate", scene.mass, scene.inertia(),
                                     {scene.offset_x, scene.offset_y}, scene.offset_theta);
  const auto plate_ground = system.add("plate_ground", joints::Ground{}, plate);

  system.set_gravity({0, scene.gravity});
  system.apply(plate, [scene](double t, const dynamics::Body& body) {
    const Eigen::Vector2d arm = body.A * Eigen::Vector2d(scene.width / 2, 0),
                          F(0, scene.load_at(t));
    return Eigen::Vector3d(F.x(), F.y(), arm.x() * F.y() - arm.y() * F.x());
  });
  mechanism.report("plate_ground", plate_ground, plate);
  mechanism.start_as_given();
  return mechanism;
}

mechanics::Mechanism make_pendulum(bool simulate_ground) {
  const Scene scene;
  mechanics::Mechanism mechanism({});
  dynamics::System& system = mechanism.system;
  // [left_out]
  const Eigen::Vector2d edge(scene.width / 2, 0), end(-0.5, 0);
  const auto hang = [&](auto base) {
    const auto rod = system.add_body("rod", 1.0, 1.0 / 12.0, edge - end);
    system.add("rod_base", joints::Revolute{.u1 = end, .u2 = edge}, rod, base);
  };
  if (simulate_ground) {
    const auto plate = system.add_body("plate", scene.mass, scene.inertia(), {0, 0});
    system.add("plate_ground", joints::Ground{}, plate);
    hang(plate);
  } else {
    hang(dynamics::System::world);
  }
  // [left_out]
  system.set_gravity({0, scene.gravity});
  mechanism.assemble();
  return mechanism;
}

}  // namespace ground
