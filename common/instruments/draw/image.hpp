#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace draw {

/// Rows from the top, 4 bytes a pixel: red, green, blue, opacity.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
};

/// The bytes of a PNG file without opacity, in at most 128 colours: a picture that has more, on
/// soft edges and letters, keeps those that change it least. Throws std::runtime_error when it
/// cannot be made.
std::string encode_png(const Image& image);

}  // namespace draw
