#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace draw {

/// Rows from the top, 4 bytes a pixel: red, green, blue, opacity.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;
};

/// The bytes of a PNG file without opacity. Throws std::runtime_error when it cannot be made.
std::string encode_png(const Image& image);

/// Throws std::runtime_error, naming the file, when it cannot be read as a PNG.
Image read_png(const std::filesystem::path& file);

/// How two pictures differ, opacity apart, with channels counted 0 … 255. A pixel that only one of
/// them has counts as 255.
struct Difference {
  bool same_size = true;
  int largest_step = 0;     ///< the largest difference of a channel over all pixels
  double worst_window = 0;  ///< the largest mean over the 16 × 16 windows of both pictures
  Image picture;            ///< `actual` in pale grey, with the differences in red
};

Difference difference(const Image& expected, const Image& actual);

}  // namespace draw
