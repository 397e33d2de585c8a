#pragma once

#include <array>

namespace draw {

/// Height of a line of text in points, for each value of `Font`; the em is 0.86 of it.
inline constexpr std::array<double, 4> font_heights{14, 16, 16, 21};

}  // namespace draw
