#pragma once

#include <array>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "mechanics/integrators/dop853.hpp"
#include "mechanics/integrators/explicit_euler.hpp"
#include "mechanics/integrators/implicit_midpoint.hpp"
#include "mechanics/integrators/rk4.hpp"
#include "mechanics/integrators/semi_implicit_euler.hpp"

namespace integrators {

/// The methods that a scene can choose, in the order in which tables list them.
enum class Scheme { explicit_euler, semi_implicit_euler, implicit_midpoint, rk4, dop853 };

struct SchemeInfo {
  Scheme id;
  std::string_view text;  ///< as on the command line
  int order;              ///< the error at a fixed time shrinks as h^order
  int evaluations;        ///< of the acceleration in a step; about, for an implicit method
};

inline constexpr std::array<SchemeInfo, 5> schemes{{
    {Scheme::explicit_euler, "explicit_euler", 1, 1},
    {Scheme::semi_implicit_euler, "semi_implicit_euler", 1, 1},
    {Scheme::implicit_midpoint, "implicit_midpoint", 2, 4},
    {Scheme::rk4, "rk4", 4, 4},
    {Scheme::dop853, "dop853", 8, 12},
}};

constexpr const SchemeInfo& info(Scheme scheme) {
  return schemes[static_cast<std::size_t>(scheme)];
}

/// The method chosen at run time. It holds the method's workspace and never allocates after that.
template <class Vector>
class Integrator {
 public:
  /// tolerance: with which dop853 chooses its own steps; 0: it does not. rounding: what of an
  /// acceleration is noise; the two methods that look at their own error need it about rest.
  Integrator(Scheme scheme, const Vector& like, double tolerance = 0.0, double rounding = 0.0)
      : chosen_(make(scheme, like, tolerance, rounding)) {}

  /// Before another run: what a method has learnt from its last steps is forgotten.
  void restart() {
    std::visit(
        [](auto& integrator) {
          if constexpr (requires { integrator.restart(); }) integrator.restart();
        },
        chosen_);
  }

  /// What of an acceleration is noise from now on, where that is more than before.
  void expect_rounding(double rounding) {
    std::visit(
        [&](auto& integrator) {
          if constexpr (requires { integrator.expect_rounding(rounding); })
            integrator.expect_rounding(rounding);
        },
        chosen_);
  }

  /// Moves q and v from t to t + h; `acceleration(t, q, v, a)` writes q̈ into a. Returns how far it
  /// came: h, or less where the method chooses its own steps. Throws NoStep.
  template <class Acceleration>
  double step(Acceleration&& acceleration, double t, Vector& q, Vector& v, double h) {
    return std::visit(
        [&](auto& integrator) -> double {
          if constexpr (std::is_void_v<decltype(integrator.step(acceleration, t, q, v, h))>) {
            integrator.step(acceleration, t, q, v, h);
            return h;
          } else {
            return integrator.step(acceleration, t, q, v, h);
          }
        },
        chosen_);
  }

 private:
  using Chosen = std::variant<ExplicitEuler<Vector>, SemiImplicitEuler<Vector>,
                              ImplicitMidpoint<Vector>, Rk4<Vector>, Dop853<Vector>>;

  static Chosen make(Scheme scheme, const Vector& like, double tolerance, double rounding) {
    switch (scheme) {
      case Scheme::explicit_euler:
        return ExplicitEuler<Vector>(like);
      case Scheme::semi_implicit_euler:
        return SemiImplicitEuler<Vector>(like);
      case Scheme::implicit_midpoint:
        return ImplicitMidpoint<Vector>(like, rounding);
      case Scheme::rk4:
        break;
      case Scheme::dop853:
        return Dop853<Vector>(like, tolerance, rounding);
    }
    return Rk4<Vector>(like);
  }

  Chosen chosen_;
};

}  // namespace integrators
