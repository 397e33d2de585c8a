#include "instruments/draw/raster.hpp"

#include <algorithm>
#include <cmath>

namespace draw {
namespace {

// Corners come from single precision and from cosines that differ in the last bit between machines:
// on a grid of 1/256 pixel they are the same.
double on_grid(double pixels) { return std::round(256 * pixels) / 256; }

// What is linear over a triangle.
class Plane {
 public:
  Plane(const std::array<Corner, 3>& corners, double twice_area, double Corner::*value) {
    const auto& [a, b, c] = corners;
    const double ab = b.*value - a.*value, ac = c.*value - a.*value;
    dx_ = (ab * (c.y - a.y) - ac * (b.y - a.y)) / twice_area;
    dy_ = (ac * (b.x - a.x) - ab * (c.x - a.x)) / twice_area;
    x_ = a.x;
    y_ = a.y;
    value_ = a.*value;
  }
  double at(double x, double y) const { return value_ + dx_ * (x - x_) + dy_ * (y - y_); }

 private:
  double dx_, dy_, x_, y_, value_;
};

// Where the edge from `a` down to `b` crosses the height y.
double crossing(const Corner& a, const Corner& b, double y) {
  return a.x + (y - a.y) * ((b.x - a.x) / (b.y - a.y));
}

// Two texels beside each other and how far it is from the first to the second, in 1/256.
struct Between {
  int first, second, weight;
  Between(double place, int size) {
    const double texel = std::clamp(place * size - 0.5, 0.0, size - 1.0);
    first = static_cast<int>(texel);
    second = std::min(first + 1, size - 1);
    weight = static_cast<int>(256 * (texel - first));
  }
  int mix(int a, int b) const { return a * (256 - weight) + b * weight; }
};

// 0 … 1
double coverage(const Texture& texture, double u, double v) {
  const Between x(u, texture.width), y(v, texture.height);
  const std::uint8_t* upper = texture.coverage + std::ptrdiff_t{y.first} * texture.width;
  const std::uint8_t* lower = texture.coverage + std::ptrdiff_t{y.second} * texture.width;
  return y.mix(x.mix(upper[x.first], upper[x.second]), x.mix(lower[x.first], lower[x.second])) /
         (255 * 65536.0);
}

std::uint8_t blend(int below, int above, int opacity) {
  return static_cast<std::uint8_t>((above * opacity + below * (255 - opacity) + 127) / 255);
}

}  // namespace

int first_pixel(double edge, int low, int high) {
  return static_cast<int>(std::clamp(std::ceil(edge - 0.5), double(low), double(high)));
}

void fill_triangle(Image& image, const PixelRect& clip, const Texture& texture, Color color,
                   std::array<Corner, 3> corners) {
  for (Corner& corner : corners) {
    corner.x = on_grid(corner.x);
    corner.y = on_grid(corner.y);
  }
  const auto& [a, b, c] = corners;
  const double twice_area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  if (twice_area == 0 || !std::isfinite(twice_area)) return;
  const Plane opacity(corners, twice_area, &Corner::opacity), u(corners, twice_area, &Corner::u),
      v(corners, twice_area, &Corner::v);
  // Shapes take the whole colour, from one texel; only letters have an area on the texture.
  const bool plain = a.u == b.u && a.u == c.u && a.v == b.v && a.v == c.v;
  const double everywhere = coverage(texture, a.u, a.v);

  std::sort(corners.begin(), corners.end(),
            [](const Corner& upper, const Corner& lower) { return upper.y < lower.y; });
  const auto& [top, middle, bottom] = corners;
  const int last_row = first_pixel(bottom.y, clip.top, clip.bottom);
  for (int row = first_pixel(top.y, clip.top, clip.bottom); row < last_row; ++row) {
    const double y = row + 0.5;
    const double one = crossing(top, bottom, y);
    const double other = y < middle.y ? crossing(top, middle, y) : crossing(middle, bottom, y);
    const int begin = first_pixel(std::min(one, other), clip.left, clip.right);
    const int end = first_pixel(std::max(one, other), clip.left, clip.right);
    std::uint8_t* pixel = image.rgba.data() + 4 * (std::ptrdiff_t{row} * image.width + begin);
    for (int column = begin; column < end; ++column, pixel += 4) {
      const double x = column + 0.5;
      const double part = plain ? everywhere : coverage(texture, u.at(x, y), v.at(x, y));
      const double result = part * opacity.at(x, y);
      const int ink = static_cast<int>(std::clamp(result, 0.0, 255.0) + 0.5);
      pixel[0] = blend(pixel[0], color.r, ink);
      pixel[1] = blend(pixel[1], color.g, ink);
      pixel[2] = blend(pixel[2], color.b, ink);
    }
  }
}

}  // namespace draw
