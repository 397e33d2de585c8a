#include "mechanism.hpp"

#include <cmath>
#include <stdexcept>
#include <type_traits>

#include "05_revolute/turned_off.hpp"
#include "mechanics/joints/ground.hpp"
#include "mechanics/joints/prismatic.hpp"
#include "mechanics/joints/revolute.hpp"

namespace slider_crank {
namespace {

/// A rod shorter than the crank does not let the wheel turn.
void check(const Scene& scene) {
  if (scene.rod < scene.crank)
    throw std::invalid_argument("rod " + mechanics::in_digits(scene.rod, 6) +
                                ": allowed is the crank, " + mechanics::in_digits(scene.crank, 6) +
                                " m, or more: a shorter rod does not let the wheel turn");
}

}  // namespace

mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method,
                                    Bodies* bodies) {
  using Eigen::Vector2d;
  using Eigen::VectorXd;
  check(scene);
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  const double theta = scene.theta0, phi = scene.rod_angle(theta);
  const Vector2d crank_pin = scene.crank * Vector2d(std::cos(theta), std::sin(theta));
  const Vector2d along(std::cos(phi), std::sin(phi));  // the rod, from crank pin to slider

  const auto join = [&](const std::string& name, auto joint, auto first, auto second) {
    return scene.without_jdotv ? system.add(name, revolute::WithoutJdotV(joint), first, second)
                               : system.add(name, joint, first, second);
  };
  const auto build = [&](auto frame) {
    const auto wheel =
        system.add_body("wheel", scene.wheel_mass, scene.wheel_inertia(), Vector2d::Zero(), theta);
    const auto rod = system.add_body("rod", scene.rod_mass, scene.rod_inertia(),
                                     crank_pin + scene.rod / 2 * along, phi);
    const auto slider = system.add_body("slider", scene.slider_mass, scene.slider_inertia(),
                                        {scene.slider_x(theta), 0.0});

    const auto wheel_frame = join("wheel_frame", joints::Revolute{}, wheel, frame);
    const auto rod_wheel =
        join("rod_wheel", joints::Revolute{.u1 = {-scene.rod / 2, 0}, .u2 = {scene.crank, 0}}, rod,
             wheel);
    const auto slider_rod =
        join("slider_rod", joints::Revolute{.u2 = {scene.rod / 2, 0}}, slider, rod);
    const auto slider_frame = join("slider_frame", joints::Prismatic{}, frame, slider);

    system.set_gravity({0, scene.gravity});
    system.apply(wheel, {0, 0, scene.torque});
    if constexpr (std::is_same_v<decltype(frame), dynamics::Handle<dynamics::World>>) {
      // What does not move needs no coordinates. Its reaction is what the others leave it to carry:
      // its weight, the wheel's pin at its centre, and the slider's push on the rail at the
      // slider's place.
      mechanism.report_fixed("frame");
      mechanism.report("frame_ground", [=, weight = scene.frame_mass * scene.gravity](
                                           const dynamics::Evaluation& e, const VectorXd& q) {
        const Eigen::Vector3d pin = e.determined_reaction(wheel_frame, wheel);
        const Eigen::Vector3d rail = e.determined_reaction(slider_frame, slider);
        const Vector2d x = q.segment<2>(slider.column);
        return Eigen::Vector3d(pin.x() + rail.x(), pin.y() + rail.y() - weight,
                               rail.z() + x.x() * rail.y() - x.y() * rail.x());
      });
    } else {
      const auto frame_ground = system.add("frame_ground", joints::Ground{}, frame);
      mechanism.report("frame_ground", frame_ground, frame);
    }
    mechanism.report("wheel_frame", wheel_frame, wheel);
    mechanism.report("rod_wheel", rod_wheel, rod);
    mechanism.report("slider_rod", slider_rod, slider);
    mechanism.report("slider_frame", slider_frame, slider);
    mechanism.work = [=, torque = scene.torque](const VectorXd& q) {
      return torque * (q[wheel.column + 2] - theta);
    };
    Bodies all{wheel, rod, slider, {}};
    if constexpr (!std::is_same_v<decltype(frame), dynamics::Handle<dynamics::World>>)
      all.frame = frame;
    return all;
  };

  const Bodies all =
      scene.simulate_frame
          ? build(system.add_body("frame", scene.frame_mass, scene.frame_inertia, Vector2d::Zero()))
          : build(dynamics::System::world);
  if (bodies != nullptr) *bodies = all;

  // The wheel's rate is given, and the others follow. Where a rod as long as the crank stands
  // upright two ways lead on: it is on the one that momentum keeps, phi = -theta.
  std::vector<dynamics::Rate> rates{{all.wheel, 2, scene.omega0}};
  if (scene.rod == scene.crank) rates.push_back({all.rod, 2, -scene.omega0});
  mechanism.assemble(rates);
  return mechanism;
}

}  // namespace slider_crank
