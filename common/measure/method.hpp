#pragma once

#include <string>
#include <string_view>

#include "integrators/integrator.hpp"

namespace measure {

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

/// Everything that decides how a scene is advanced, but for the step.
struct Method {
  integrators::Name integrator = integrators::Name::rk4;
  Stabilization stabilization = Stabilization::none;
  double ks = 0.0;  ///< feedback of C [1/s²]
  double kd = 0.0;  ///< feedback of Ċ [1/s]

  /// For legends and tables: "rk4", "rk4 + projection".
  std::string label() const {
    std::string text(integrators::method(integrator).text);
    if (stabilization != Stabilization::none) text += " + " + std::string(name(stabilization));
    return text;
  }
};

}  // namespace measure
