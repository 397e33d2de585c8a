#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include "measure/simulation.hpp"

namespace measure {

/// Notices a run that diverges, as it happens. Forces of constraints do no work, so whatever the
/// joints, the speed √(2T) of the whole scene (in the mass metric, T its kinetic energy) obeys
///
///     √(2T) ≤ √(2T₀) + ∫ √(FᵀWF) dt + what feedback can make of the constraint error at the start
///
/// with the applied forces F alone: a bound without any threshold in metres or joules. A run whose
/// kinetic energy is twice what this allows is no longer a motion of the scene.
class Watch {
 public:
  /// Begins with the simulation as it is now.
  explicit Watch(Simulation& simulation)
      : simulation_(simulation),
        t_(simulation.time()),
        speed_(overshoot * simulation.feedback_speed()) {
    const Measures start = simulation.measures();
    speed_ += std::sqrt(2.0 * start.kinetic);
    drive_ = start.drive;
  }

  /// To be called after every step or every few, with the measures then. Throws Diverged.
  void look(const Measures& now) {
    const double t = simulation_.time();
    if (!now.finite()) throw Diverged(at(t) + "the energy or an error is no longer finite");
    speed_ += (t - t_) * std::max(drive_, now.drive);
    t_ = t;
    drive_ = now.drive;
    const double most = 0.5 * speed_ * speed_;
    if (!(now.kinetic <= 2.0 * most))
      throw Diverged(at(t) + "the kinetic energy is " + joule(now.kinetic) +
                     ", where its start and the forces can have made at most " + joule(most) +
                     "; " + simulation_.culprit());
  }

 private:
  /// Close to the limit of its step a stable method swings higher than the motion that it follows.
  static constexpr double overshoot = 4.0;

  static std::string joule(double energy) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.2g J", energy);
    return text.data();
  }

  Simulation& simulation_;
  double t_, speed_, drive_ = 0.0;
};

}  // namespace measure
