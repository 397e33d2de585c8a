#include "instruments/draw/image.hpp"

#include <png.h>

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

namespace draw {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

/// A colour of the picture and the entry of the palette that stands for it.
struct Tone {
  Rgb rgb;
  std::int64_t pixels = 0;
  std::int64_t distance = 3 * 256 * 256;  ///< squared, from rgb to the entry
  std::uint8_t entry = 0;
};

std::int64_t squared_distance(const Rgb& a, const Rgb& b) {
  std::int64_t sum = 0;
  for (std::size_t c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

/// Takes, until 128 are found, the colour whose pixels are farthest from what they would be drawn
/// in, and sets each tone's entry to the nearest.
std::vector<Rgb> palette_of(std::vector<Tone>& tones) {
  const auto error = [](const Tone& tone) { return tone.pixels * tone.distance; };
  std::vector<Rgb> palette;
  while (palette.size() < 128) {
    const Rgb worst = std::max_element(tones.begin(), tones.end(), [&](auto& a, auto& b) {
                        return error(a) < error(b);
                      })->rgb;
    const auto entry = static_cast<std::uint8_t>(palette.size());
    palette.push_back(worst);
    bool exact = true;
    for (Tone& tone : tones) {
      if (const auto d = squared_distance(tone.rgb, worst); d < tone.distance)
        tone.distance = d, tone.entry = entry;
      exact = exact && tone.distance == 0;
    }
    if (exact) break;
  }
  return palette;
}

}  // namespace

std::string encode_png(const Image& image) {
  const std::size_t pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (image.width <= 0 || image.height <= 0 || image.rgba.size() != 4 * pixels) {
    throw std::runtime_error("cannot encode a PNG: the picture is empty or its size is wrong");
  }
  const auto rgb = [&](std::size_t i) {
    return Rgb{image.rgba[4 * i], image.rgba[4 * i + 1], image.rgba[4 * i + 2]};
  };
  std::map<Rgb, std::size_t> numbers;
  std::vector<Tone> tones;
  std::vector<std::size_t> tone_of(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (i > 0 && rgb(i) == rgb(i - 1)) {
      tone_of[i] = tone_of[i - 1];
    } else {
      const auto [at, is_new] = numbers.emplace(rgb(i), tones.size());
      if (is_new) tones.push_back({.rgb = rgb(i)});
      tone_of[i] = at->second;
    }
    ++tones[tone_of[i]].pixels;
  }
  const std::vector<Rgb> palette = palette_of(tones);
  std::vector<std::uint8_t> entries(pixels);
  for (std::size_t i = 0; i < pixels; ++i) entries[i] = tones[tone_of[i]].entry;

  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB_COLORMAP;
  png.colormap_entries = static_cast<png_uint_32>(palette.size());
  std::string bytes(PNG_IMAGE_PNG_SIZE_MAX(png), '\0');
  png_alloc_size_t size = bytes.size();
  if (png_image_write_to_memory(&png, bytes.data(), &size, 0, entries.data(), 0, palette.data()) ==
      0) {
    throw std::runtime_error(std::string("cannot encode a PNG: ") + png.message);
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace draw
