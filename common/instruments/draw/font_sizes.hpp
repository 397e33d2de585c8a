#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace draw {

/// Height of a line of text in points, for each value of `Font`; the em is 0.86 of it.
inline constexpr std::array<double, 4> font_heights{14, 16, 16, 21};

/// The same in whole pixels, as the fonts are made.
inline float font_pixels(std::size_t font, double scale) {
  return static_cast<float>(std::round(font_heights[font] * scale));
}

}  // namespace draw
