#pragma once

// The pictures of the lessons, drawn again and compared with those in the repository.

#include <filesystem>
#include <string>
#include <vector>

#include "instruments/draw/image.hpp"
#include "instruments/pictures/pictures.hpp"

namespace picture_check {

using draw::Image;

/// Throws std::runtime_error when they are not those of a PNG.
Image decode_png(const std::string& bytes);
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

/// For a window and a picture: OpenGL's driver fills triangles too, but rounds in its own way, a
/// few steps of a channel where a shape ends between two pixels, and a file has 128 colours. At
/// 1800 times of five chapters a pixel differed by at most 38 and a window by 2.33. Whatever a
/// reader would see differs by far more: a bead moved by a pixel by 100 steps and more at its edge.
bool alike(const Image& expected, const Image& actual);

/// With the picture in the snapshots of a chapter, pixel for pixel, as it would be stored. Where
/// they differ, both and their difference are written to a folder that the message names.
void compare(const std::string& chapter, const std::string& name, const Image& drawn);

/// All pictures of a chapter at the defaults of its program, and the plot of its committed report.
void compare_all(const std::string& chapter, const std::vector<pictures::Picture>& pictures);

}  // namespace picture_check
