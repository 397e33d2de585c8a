#include "instruments/draw/theme.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace draw {
namespace {

constexpr Color hex(unsigned rgb) {
  return {static_cast<std::uint8_t>(rgb >> 16), static_cast<std::uint8_t>((rgb >> 8) & 0xff),
          static_cast<std::uint8_t>(rgb & 0xff)};
}

// The hues of Okabe and Ito's palette. Those too pale for a thin line on white are darkened, those
// too dark for a thin line on black are lightened, until they can be read.
Theme light() {
  return {
      .name = "light",
      .paper = hex(0xffffff),
      .ink = hex(0x1f2328),
      .muted = hex(0x667080),
      .grid = hex(0xe4e7eb),
      .track = hex(0x49525e),
      .body = hex(0xf6d58a),
      .body_edge = hex(0x5e4a12),
      .weight = hex(0xd55e00),
      .constraint_force = hex(0x0072b2),
      .applied_force = hex(0xb0568e),
      .velocity = hex(0x00855f),
      .warning = hex(0xd0021b),
      .series = {hex(0x0072b2), hex(0xd55e00), hex(0x009e73), hex(0xb0568e), hex(0x4d5561),
                 hex(0xcc8f00)},
  };
}

Theme dark() {
  return {
      .name = "dark",
      .paper = hex(0x14171c),
      .ink = hex(0xe8eaed),
      .muted = hex(0x9aa4b2),
      .grid = hex(0x2c323b),
      .track = hex(0xb4bdc9),
      .body = hex(0x8a6a1c),
      .body_edge = hex(0xffdf94),
      .weight = hex(0xff8542),
      .constraint_force = hex(0x56b4e9),
      .applied_force = hex(0xe39bc8),
      .velocity = hex(0x35c79d),
      .warning = hex(0xff5a5f),
      .series = {hex(0x56b4e9), hex(0xff8542), hex(0x35c79d), hex(0xe39bc8), hex(0xc4cad3),
                 hex(0xe6d24a)},
  };
}

}  // namespace

Color Color::faded(double opacity) const {
  return {r, g, b, static_cast<std::uint8_t>(std::lround(a * std::clamp(opacity, 0.0, 1.0)))};
}

const Theme& theme(std::string_view name) {
  static const std::array themes{light(), dark()};
  for (const Theme& t : themes) {
    if (t.name == name) return t;
  }
  throw std::invalid_argument("no theme \"" + std::string(name) + "\": use light or dark");
}

}  // namespace draw
