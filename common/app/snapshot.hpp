#pragma once

#include <filesystem>
#include <vector>

#include "app/chapter.hpp"
#include "instruments/draw/offscreen.hpp"

namespace app {

/// Which pictures `snapshot` makes: those of the lesson, unless one of the others is asked for.
struct Snapshot {
  draw::Page page = {};
  std::vector<double> at = {};            ///< the scene at these times [s]
  long frames = 0;                        ///< a series of so many pictures
  std::optional<double> fps = {};         ///< of which so many show a second
  int sheet_columns = 0, sheet_rows = 0;  ///< small scenes on one page

  double interval() const { return 1.0 / fps.value_or(25.0); }  ///< of a series [s]
  int cells() const { return sheet_columns * sheet_rows; }

  /// Up to when the scene is simulated [s].
  double end(const measure::RunOptions& run) const;

  /// Throws UsageError where options do not go together or ask for too many steps.
  void check(const measure::RunOptions& run, double most_steps) const;
};

/// Writes the pictures into the folder and prints their names. Where the run that they show is far
/// from right, by the verdict of its end, their captions say so.
void take(const Snapshot& snapshot, const Chapter& chapter, const measure::RunOptions& run,
          const mechanics::Verdict& verdict, const std::filesystem::path& out);

}  // namespace app
