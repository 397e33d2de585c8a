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

// Near the hues of Okabe and Ito's palette, but moved until colour-blind readers see any two
// further apart than 25 steps of CIELAB, and until a thin line can be read on the paper: a test
// measures both.
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
      .weight = hex(0xd97c0a),
      .constraint_force = hex(0x064fd0),
      .applied_force = hex(0x9467ab),
      .velocity = hex(0x00a870),
      .warning = hex(0xae061d),
      .series = {hex(0x1d4fd5), hex(0xb73b23), hex(0x1aa884), hex(0x9158a7), hex(0x2e334b),
                 hex(0xd28000)},
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
      .weight = hex(0xfea831),
      .constraint_force = hex(0x7991f8),
      .applied_force = hex(0xccb1d8),
      .velocity = hex(0x50eaa2),
      .warning = hex(0xde3c3f),
      .series = {hex(0x6f95ff), hex(0xef6421), hex(0x2de97b), hex(0xc07cad), hex(0xbaebd2),
                 hex(0xf4eb2f)},
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
