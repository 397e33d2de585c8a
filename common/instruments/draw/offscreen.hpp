#pragma once

#include <functional>

#include "instruments/draw/image.hpp"
#include "instruments/draw/pen.hpp"

namespace draw {

/// Size in points; a point is `scale` pixels wide.
struct Page {
  int width = 960, height = 600;
  double scale = 2;
  Theme theme = draw::theme("light");
  bool captions = true;  ///< under the picture; else only what Pen::caption tells
};

/// What `draw` puts on the page, filled by the processor alone: the same bytes on every machine.
/// Throws std::runtime_error when a font is missing, std::invalid_argument when a side has not 1 to
/// 16384 pixels. Call it from one thread at a time.
Image render(const Page& page, const std::function<void(Pen&)>& draw);

}  // namespace draw
