#include <imgui.h>

#include <filesystem>
#include <stdexcept>

#include "instruments/draw/font_sizes.hpp"
#include "instruments/draw/pen.hpp"

namespace draw {
namespace {

// First and last code point of each range, ended by 0.
constexpr ImWchar glyph_ranges[] = {
    0x0020, 0x007e,  // ASCII
    0x00a0, 0x00ff,  // Latin-1: ° ± ² · × ½
    0x0370, 0x03ff,  // Greek
    0x1d40, 0x1d40,  // ᵀ, a matrix transposed
    0x1e8a, 0x1e8f,  // ẋ ẍ ẏ
    0x2010, 0x2033,  // dashes, quotes, … ′ ″
    0x2070, 0x209c,  // superscripts and subscripts
    0x2113, 0x2113,  // ℓ
    0x2190, 0x2193,  // arrows
    0x2202, 0x2202,  // ∂
    0x2206, 0x2207,  // ∆ ∇
    0x2211, 0x2212,  // ∑ −
    0x221a, 0x221e,  // √ ∞
    0x2248, 0x2248,  // ≈
    0x2260, 0x2265,  // ≠ ≤ ≥
    0x226a, 0x226b,  // ≪ ≫
    0,
};

}  // namespace

Fonts load_fonts(double scale) {
  for (const char* file : {DRAW_FONT, DRAW_FONT_BOLD}) {
    if (!std::filesystem::exists(file)) {
      throw std::runtime_error(std::string("cannot open the font ") + file +
                               ": install the DejaVu fonts (package fonts-dejavu-core)");
    }
  }
  ImFontConfig config;
  config.OversampleH = 2;
  Fonts fonts{};
  for (const Font font : {Font::small, Font::text, Font::bold, Font::title}) {
    const auto i = static_cast<std::size_t>(font);
    const bool bold = font == Font::bold || font == Font::title;
    fonts[i] = ImGui::GetIO().Fonts->AddFontFromFileTTF(
        bold ? DRAW_FONT_BOLD : DRAW_FONT, font_pixels(i, scale), &config, glyph_ranges);
  }
  return fonts;
}

}  // namespace draw
