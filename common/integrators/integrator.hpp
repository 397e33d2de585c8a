#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

#include "integrators/explicit_euler.hpp"
#include "integrators/rk4.hpp"
#include "integrators/semi_implicit_euler.hpp"

namespace integrators {

/// The methods that a scene can choose, in the order in which tables list them.
enum class Name { explicit_euler, semi_implicit_euler, rk4 };

struct Method {
  Name name;
  std::string_view text;  ///< as on the command line
  int order;              ///< the error at a fixed time shrinks as h^order
};

inline constexpr std::array<Method, 3> methods{{
    {Name::explicit_euler, "explicit_euler", 1},
    {Name::semi_implicit_euler, "semi_implicit_euler", 1},
    {Name::rk4, "rk4", 4},
}};

constexpr const Method& method(Name name) { return methods[static_cast<std::size_t>(name)]; }

/// The method of that name, or nothing.
constexpr std::optional<Name> find(std::string_view text) {
  for (const Method& m : methods)
    if (m.text == text) return m.name;
  return std::nullopt;
}

/// The method chosen at run time. It holds the method's workspace and never allocates after that.
template <class Vector>
class Integrator {
 public:
  Integrator(Name name, const Vector& like) : chosen_(make(name, like)) {}

  /// Moves q and v from t to t + h; `acceleration(t, q, v, a)` writes q̈ into a.
  template <class Acceleration>
  void step(Acceleration&& acceleration, double t, Vector& q, Vector& v, double h) {
    std::visit([&](auto& integrator) { integrator.step(acceleration, t, q, v, h); }, chosen_);
  }

 private:
  using Chosen = std::variant<ExplicitEuler<Vector>, SemiImplicitEuler<Vector>, Rk4<Vector>>;

  static Chosen make(Name name, const Vector& like) {
    switch (name) {
      case Name::explicit_euler:
        return ExplicitEuler<Vector>(like);
      case Name::semi_implicit_euler:
        return SemiImplicitEuler<Vector>(like);
      case Name::rk4:
        break;
    }
    return Rk4<Vector>(like);
  }

  Chosen chosen_;
};

}  // namespace integrators
