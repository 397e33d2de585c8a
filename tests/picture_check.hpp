#pragma once

// The pictures of the lessons, drawn again and compared with those in the repository.

#include <filesystem>
#include <string>
#include <vector>

#include "catch.hpp"
#include "draw/image.hpp"
#include "draw/offscreen.hpp"
#include "program/files.hpp"
#include "program/pictures.hpp"
#include "program/report.hpp"

namespace picture_check {

/// Machines differ by a few steps of a channel where a shape ends between two pixels. Whatever a
/// reader would see differs by far more: a bead moved by a pixel by 100 steps and more at its edge.
inline bool alike(const draw::Difference& difference) {
  return difference.same_size && difference.largest_step <= 12 && difference.worst_window <= 1.0;
}

inline void compare(const std::string& chapter, const std::string& name,
                    const draw::Image& actual) {
  const std::filesystem::path committed =
      std::filesystem::path(TUTORIAL_SOURCE) / "chapters" / chapter / "snapshots" / (name + ".png");
  INFO("expected: " << committed.string());
  const draw::Image expected = draw::read_png(committed);
  const draw::Difference difference = draw::difference(expected, actual);
  if (alike(difference)) {
    SUCCEED();
    return;
  }
  const std::filesystem::path folder =
      std::filesystem::path(TUTORIAL_BIN).parent_path() / "picture_failures" / chapter;
  program::make_folder(folder);
  program::write_file(folder / (name + "_expected.png"), draw::encode_png(expected));
  program::write_file(folder / (name + "_actual.png"), draw::encode_png(actual));
  program::write_file(folder / (name + "_difference.png"), draw::encode_png(difference.picture));
  FAIL_CHECK("largest channel step "
             << difference.largest_step << ", worst 16x16 window " << difference.worst_window
             << "; expected, actual and difference are in " << folder.string());
}

/// All pictures of a chapter at the defaults of its program, and the plot of its committed report.
inline void compare_all(const std::string& chapter, const std::vector<program::Picture>& pictures) {
  for (const program::Picture& picture : pictures)
    compare(chapter, picture.name, draw::render({}, picture.draw));
  const auto report = program::read_csv(std::filesystem::path(TUTORIAL_SOURCE) / "chapters" /
                                        chapter / "snapshots" / "error_vs_time.csv");
  compare(chapter, "error_vs_time", draw::render({}, program::error_picture(report).draw));
}

}  // namespace picture_check
