#include "instruments/draw/image.hpp"

#include <stb_image_write.h>

#include <stdexcept>

namespace draw {

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

}  // namespace draw
