#include "exact.hpp"

#include <cmath>

namespace drivers {

Real torque(const slider_crank::Scene& machine, const Crank& crank) {
  slider_crank::Scene free = machine;
  free.torque = 0.0;
  const slider_crank::Reduced reduced(free);
  const auto at = reduced.pose(crank.theta);
  return reduced.mu(at) * (crank.alpha - reduced.angular_acceleration(at, crank.omega));
}

slider_crank::Reactions reactions(const slider_crank::Scene& machine, const Crank& crank) {
  slider_crank::Scene pushed = machine;
  pushed.torque = static_cast<double>(torque(machine, crank));
  return slider_crank::reactions(pushed, {crank.theta, crank.omega});
}

Real energy(const slider_crank::Scene& machine, const Crank& crank) {
  const slider_crank::Reduced reduced(machine);
  return reduced.mu(reduced.pose(crank.theta)) * crank.omega * crank.omega / 2 -
         reduced.pull * std::sin(crank.theta);
}

}  // namespace drivers
