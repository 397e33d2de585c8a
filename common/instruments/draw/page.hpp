#pragma once

#include <string_view>

#include "instruments/draw/pen.hpp"

namespace draw {

/// Writes `title` at the top left and `caption` (the number that matters) at the bottom, each on
/// as many lines as it needs, nothing where it is empty. Returns what is left for the content.
Rect page(Pen& pen, std::string_view title, std::string_view caption);

}  // namespace draw
