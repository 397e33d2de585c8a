#pragma once

#include <functional>

#include "draw/image.hpp"
#include "draw/pen.hpp"

namespace draw {

/// Size in points; a point is `scale` pixels wide.
struct Page {
  int width = 960, height = 600;
  double scale = 2;
  Theme theme = draw::theme("light");
};

/// What `draw` puts on the page, rendered without display or GPU; the same bytes on every run.
/// Throws std::runtime_error when EGL or OpenGL cannot start, std::invalid_argument when the size
/// is not positive or larger than OpenGL allows. Call it from one thread at a time.
Image render(const Page& page, const std::function<void(Pen&)>& draw);

}  // namespace draw
