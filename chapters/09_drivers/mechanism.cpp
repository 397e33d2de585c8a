#include "mechanism.hpp"

#include <cmath>
#include <stdexcept>

namespace drivers {

mechanics::Mechanism make_mechanism(const slider_crank::Scene& machine, const Function& f,
                                    const mechanics::Method& method, slider_crank::Bodies* bodies) {
  const joints::Given start = f(0.0);
  slider_crank::Scene told = machine;
  told.theta0 = start.f;
  told.omega0 = start.f_dot;
  slider_crank::Bodies all;
  mechanics::Mechanism mechanism = slider_crank::make_mechanism(told, method, &all);
  const auto driver = mechanism.system.add("wheel_driver", joints::Driver{f}, all.wheel);
  mechanism.report("wheel_driver", driver, all.wheel);
  if (bodies != nullptr) *bodies = all;
  return mechanism;
}

eases::Move move(const Scene& scene) {
  return {eases::named(scene.ease), scene.machine.theta0, scene.turn, scene.delay, scene.move};
}

mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method,
                                    slider_crank::Bodies* bodies) {
  const eases::Move f = move(scene);
  const slider_crank::Scene& machine = scene.machine;
  if (machine.rod == machine.crank && std::abs(std::cos(machine.theta0)) < 1e-6)
    throw std::invalid_argument(
        "theta0 " + mechanics::in_digits(machine.theta0, 6) +
        ": a rod as long as the crank lies on it there, and from rest the slider may stay in the "
        "centre or leave it; allowed is another angle, or another rod");
  mechanics::Mechanism mechanism = make_mechanism(scene.machine, f, method, bodies);
  if (scene.end_at_jumps) {
    const auto jumps = f.jumps();
    mechanism.jumps.assign(jumps.begin(), jumps.end());
  }
  return mechanism;
}

}  // namespace drivers
