#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "mechanics/integrators/integrator.hpp"

namespace mechanics {

/// How the error of the constraints is held down while a scene moves.
enum class Stabilization {
  none,        ///< the acceleration alone keeps C̈ = 0; what builds up stays
  feedback,    ///< C̈ + kd Ċ + ks C = 0 (Baumgarte)
  projection,  ///< after each step back onto C = 0 and J v = 0
};

inline constexpr std::string_view stabilization_names[] = {"none", "feedback", "projection"};

constexpr std::string_view name(Stabilization s) {
  return stabilization_names[static_cast<int>(s)];
}

/// Where the ladder of a method that chooses its own steps begins, and where it ends.
inline constexpr double coarsest_tolerance = 1e-2, finest_tolerance = 1e-14;
/// The largest tolerance that a run may have.
inline constexpr double coarsest_allowed = 0.1;

/// So many steps may a run take: some minutes of work.
inline constexpr double most_steps = 1e8;

/// Everything that decides how a scene is advanced, but for the step.
struct Method {
  integrators::Scheme integrator = integrators::Scheme::rk4;
  Stabilization stabilization = Stabilization::none;
  double ks = 0.0;         ///< feedback of C [1/s²]
  double kd = 0.0;         ///< feedback of Ċ [1/s]
  double tolerance = 0.0;  ///< with which dop853 chooses its steps; 0: they are given

  /// For legends and tables: "rk4", "rk4 + projection".
  std::string label() const {
    std::string text(integrators::info(integrator).text);
    if (tolerance > 0.0) text += " adaptive";
    if (stabilization != Stabilization::none) text += " + " + std::string(name(stabilization));
    return text;
  }
};

}  // namespace mechanics
