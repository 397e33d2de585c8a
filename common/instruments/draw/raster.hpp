#pragma once

#include <array>
#include <cstdint>

#include "instruments/draw/image.hpp"
#include "instruments/draw/theme.hpp"

namespace draw {

/// A corner of a triangle: its place in pixels, y down, its place on the texture from 0 to 1, and
/// its opacity from 0 to 255.
struct Corner {
  double x, y, u, v, opacity;
};

/// How much of the colour lands, 0 … 255; rows from the top.
struct Texture {
  int width, height;
  const std::uint8_t* coverage;
};

/// The pixels of columns left … right - 1 and rows top … bottom - 1.
struct PixelRect {
  int left, top, right, bottom;
};

/// The first pixel whose centre is not left of (above) `edge`: a shape between two edges has the
/// pixels from the one's to before the other's. Within `low` … `high`.
int first_pixel(double edge, int low, int high);

/// Lays `color` over the pixels whose centres are in the triangle (on an edge: on its left or upper
/// one), so that triangles with a common edge leave no gap and no pixel to both. Opacity and the
/// place on the texture, read with bilinear weights, are linear between the corners. `clip` is
/// within the image. The same bytes on every machine with IEEE arithmetic.
void fill_triangle(Image& image, const PixelRect& clip, const Texture& texture, Color color,
                   std::array<Corner, 3> corners);

}  // namespace draw
