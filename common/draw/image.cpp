#include "draw/image.hpp"

#include <stb_image.h>
#include <stb_image_write.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

namespace draw {
namespace {

const std::uint8_t* pixel(const Image& image, int x, int y) {
  if (x >= image.width || y >= image.height) return nullptr;
  return &image.rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                          static_cast<std::size_t>(x))];
}

}  // namespace

std::string encode_png(const Image& image) {
  const std::size_t pixels =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (image.width <= 0 || image.height <= 0 || image.rgba.size() != 4 * pixels) {
    throw std::runtime_error("cannot encode a PNG: the picture is empty or its size is wrong");
  }
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    rgb.insert(rgb.end(), &image.rgba[4 * i], &image.rgba[4 * i] + 3);
  }
  std::string bytes;
  const auto append = [](void* out, void* data, int size) {
    static_cast<std::string*>(out)->append(static_cast<const char*>(data),
                                           static_cast<std::size_t>(size));
  };
  if (stbi_write_png_to_func(append, &bytes, image.width, image.height, 3, rgb.data(),
                             3 * image.width) == 0) {
    throw std::runtime_error("cannot encode a PNG: out of memory");
  }
  return bytes;
}

Image read_png(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error("cannot open " + file.string());
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (!bytes.starts_with("\x89PNG")) throw std::runtime_error(file.string() + " is not a PNG");
  Image image;
  int channels = 0;
  const std::unique_ptr<stbi_uc, decltype(&stbi_image_free)> data(
      stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()),
                            static_cast<int>(bytes.size()), &image.width, &image.height, &channels,
                            4),
      &stbi_image_free);
  if (!data) {
    throw std::runtime_error("cannot read " + file.string() + ": " + stbi_failure_reason());
  }
  const std::size_t size =
      4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  image.rgba.assign(data.get(), data.get() + size);
  return image;
}

Difference difference(const Image& expected, const Image& actual) {
  constexpr int window = 16;
  Difference result;
  result.same_size = expected.width == actual.width && expected.height == actual.height;
  Image& picture = result.picture;
  picture.width = std::max(expected.width, actual.width);
  picture.height = std::max(expected.height, actual.height);
  picture.rgba.resize(4 * static_cast<std::size_t>(picture.width) *
                      static_cast<std::size_t>(picture.height));

  const int columns = (picture.width + window - 1) / window;
  std::vector<double> sums(static_cast<std::size_t>(columns));
  std::uint8_t* out = picture.rgba.data();
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const std::uint8_t* a = pixel(expected, x, y);
      const std::uint8_t* b = pixel(actual, x, y);
      int step = 0, sum = 0, grey = 255;
      for (int c = 0; c < 3; ++c) {
        const int d = a && b ? std::abs(a[c] - b[c]) : 255;
        step = std::max(step, d);
        sum += d;
      }
      if (b) grey = 192 + (b[0] + b[1] + b[2]) / 12;
      // The smallest step must be seen too, so it starts at half of full red.
      const int red = step == 0 ? 0 : 128 + step / 2;
      const auto rest = static_cast<std::uint8_t>(grey * (255 - red) / 255);
      const auto first = static_cast<std::uint8_t>(rest + red * 220 / 255);
      for (const std::uint8_t value : std::array<std::uint8_t, 4>{first, rest, rest, 255}) {
        *out++ = value;
      }
      result.largest_step = std::max(result.largest_step, step);
      sums[static_cast<std::size_t>(x / window)] += sum / 3.0;
    }
    const int rows = y % window + 1;
    if (rows < window && y + 1 < picture.height) continue;
    for (int i = 0; i < columns; ++i) {
      const int width = std::min(window, picture.width - i * window);
      double& total = sums[static_cast<std::size_t>(i)];
      result.worst_window = std::max(result.worst_window, total / (width * rows));
      total = 0;
    }
  }
  return result;
}

}  // namespace draw
