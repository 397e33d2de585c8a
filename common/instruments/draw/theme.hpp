#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace draw {

struct Color {
  std::uint8_t r = 0, g = 0, b = 0, a = 255;

  /// The same colour with its opacity multiplied by `opacity` (0 … 1).
  Color faded(double opacity) const;
};

/// Nothing is painted in this colour: for a shape without fill or without edge.
inline constexpr Color transparent{0, 0, 0, 0};

/// One colour for each role, told apart by colour-blind readers too.
struct Theme {
  std::string name;
  Color paper, ink, muted, grid;
  Color track;  ///< constraint curves, rails
  Color body;   ///< fill of beads and bodies
  Color body_edge;
  Color weight, constraint_force, applied_force, velocity;
  Color warning;                ///< what should not be: an open joint
  std::array<Color, 6> series;  ///< curves of a plot, in this order
};

/// "light" or "dark". Throws std::invalid_argument for any other name.
const Theme& theme(std::string_view name);

}  // namespace draw
