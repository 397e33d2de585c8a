// Triangles on pixels: what closed forms say of coverage, gradients, textures and blending.

#include "instruments/draw/raster.hpp"

#include <cmath>
#include <limits>
#include <random>

#include "catch.hpp"

using namespace draw;

namespace {

constexpr std::uint8_t full[] = {255};
constexpr Texture plain{1, 1, full};
constexpr Color white{255, 255, 255};

struct Sheet {
  Image image;
  PixelRect clip;
  explicit Sheet(int side, std::uint8_t paper = 0) : clip{0, 0, side, side} {
    const auto n = static_cast<std::size_t>(side);
    image = {side, side, std::vector<std::uint8_t>(4 * n * n, paper)};
  }
  int at(int x, int y, int channel = 0) const {
    return image.rgba[static_cast<std::size_t>(4 * (y * image.width + x) + channel)];
  }
  void fill(std::array<Corner, 3> corners, Color color = white, const Texture& texture = plain) {
    fill_triangle(image, clip, texture, color, corners);
  }
  int painted() const {
    int count = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) count += at(x, y) != 0;
    return count;
  }
};

Corner corner(double x, double y, double opacity = 255) { return {x, y, 0, 0, opacity}; }

}  // namespace

TEST_CASE("a triangle has the pixels whose centres it holds, on its left and upper edges too") {
  Sheet sheet(8);
  sheet.fill({corner(0, 0), corner(8, 0), corner(0, 8)});
  // x + y < 7 between whole numbers; the diagonal, a right edge, has x + y = 7.
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) CHECK((sheet.at(x, y) == 255) == (x + y < 7));

  Sheet other(8);
  other.fill({corner(1.5, 2.5), corner(6.5, 2.5), corner(6.5, 5.5)});
  other.fill({corner(6.5, 5.5), corner(1.5, 5.5), corner(1.5, 2.5)});
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x)
      CHECK((other.at(x, y) == 255) == (x >= 1 && x < 6 && y >= 2 && y < 5));
}

TEST_CASE("triangles with common edges cover a surface once, wherever their corners are") {
  std::mt19937 random(17);
  const auto between = [&](double low, double high) {
    return low + (high - low) * (double(random()) / 4294967296.0);
  };
  for (int round = 0; round < 500; ++round) {
    // The triangles around a point in a square, whose rim is cut somewhere.
    const auto in = [&] { return between(2, 30); };
    const std::array rim{corner(2, 2, 128),     corner(in(), 2, 128), corner(30, 2, 128),
                         corner(30, in(), 128), corner(30, 30, 128),  corner(in(), 30, 128),
                         corner(2, 30, 128),    corner(2, in(), 128)};
    const Corner middle = corner(in(), in(), 128);
    Sheet sheet(32);
    for (std::size_t i = 0; i < rim.size(); ++i)
      sheet.fill({rim[i], middle, rim[(i + 1) % rim.size()]});
    int wrong = 0;
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x)
        wrong += sheet.at(x, y) != (x >= 2 && x < 30 && y >= 2 && y < 30 ? 128 : 0);
    CHECK(wrong == 0);
  }
}

TEST_CASE("corners lie on a grid of 1/256 pixel, which rounding does not leave") {
  const auto picture = [](double error) {
    Sheet sheet(32);
    sheet.fill(
        {corner(3.25 + error, 4.125, 0), corner(29.5, 9.75 - error), corner(11, 27 + error)});
    return sheet.image.rgba;
  };
  CHECK(picture(0.9 / 512) == picture(0));
  CHECK(picture(-0.9 / 512) == picture(0));
  CHECK(picture(1.0 / 8) != picture(0));
}

TEST_CASE("opacity is linear between the corners") {
  Sheet sheet(64);
  const auto exact = [](double x, double y) { return 10 + 1.5 * x + 2 * y; };
  const auto at = [&](double x, double y) { return corner(x, y, exact(x, y)); };
  sheet.fill({at(0, 0), at(64, 0), at(0, 64)});
  sheet.fill({at(64, 64), at(64, 0), at(0, 64)});
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      CHECK(std::abs(sheet.at(x, y) - exact(x + 0.5, y + 0.5)) <= 0.5 + 1e-9);
}

TEST_CASE("a texture is read with bilinear weights, and its rim goes on outside") {
  const std::uint8_t texels[] = {0, 255, 100, 50};
  const Texture texture{2, 2, texels};
  const auto exact = [&](double u, double v) {  // texels have their centres at 1/4 and 3/4
    const double s = std::clamp(2 * u - 0.5, 0.0, 1.0), t = std::clamp(2 * v - 0.5, 0.0, 1.0);
    return (1 - t) * ((1 - s) * texels[0] + s * texels[1]) +
           t * ((1 - s) * texels[2] + s * texels[3]);
  };
  Sheet sheet(64);
  const Corner a{0, 0, 0, 0, 255}, b{64, 0, 1, 0, 255}, c{0, 64, 0, 1, 255}, d{64, 64, 1, 1, 255};
  sheet.fill({a, b, c}, white, texture);
  sheet.fill({b, c, d}, white, texture);
  // Weights in 1/256 cost a step of the channel in each direction, rounding half of one.
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      CHECK(std::abs(sheet.at(x, y) - exact((x + 0.5) / 64, (y + 0.5) / 64)) <= 2.5);
}

TEST_CASE("a colour goes over what is below it in the proportion of its opacity") {
  for (const int paper : {0, 1, 77, 254, 255})
    for (int opacity = 0; opacity <= 255; ++opacity) {
      Sheet sheet(2, static_cast<std::uint8_t>(paper));
      const auto at = [&](double x, double y) { return corner(x, y, opacity); };
      sheet.fill({at(0, 0), at(2, 0), at(0, 2)}, {200, 20, 255});
      for (const auto& [channel, ink] : {std::pair{0, 200}, {1, 20}, {2, 255}, {3, paper}})
        CHECK(std::abs(sheet.at(0, 0, channel) -
                       (ink * opacity + paper * (255 - opacity)) / 255.0) <= 0.5);
    }
}

TEST_CASE("nothing is drawn outside the clip, and nothing of what has no area or no place") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  Sheet sheet(32);
  sheet.fill({corner(1, 1), corner(20, 20), corner(30, 30)});
  sheet.fill({corner(1, nan), corner(20, 5), corner(30, 30)});
  sheet.fill({corner(1, 1), corner(infinity, 5), corner(30, 30)});
  CHECK(sheet.painted() == 0);
  sheet.clip = {10, 12, 20, 15};
  sheet.fill({corner(-1e30, -1e30), corner(1e30, -1e30), corner(0, 1e30)});
  CHECK(sheet.painted() == 10 * 3);
  CHECK(sheet.at(10, 12) == 255);
  CHECK(sheet.at(19, 14) == 255);
}
