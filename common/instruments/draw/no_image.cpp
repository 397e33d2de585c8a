// In the place of image.cpp in the book, where no file is written.
#include <stdexcept>

#include "instruments/draw/image.hpp"

namespace draw {

std::string encode_png(const Image&) {
  throw std::runtime_error("pictures are not written here, only by the programs");
}

}  // namespace draw
