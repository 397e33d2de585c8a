#pragma once

#include <string>

namespace program {

/// A line on standard error that says how far the work is: only on a terminal, and only once the
/// work has taken a second. It wipes itself away.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` from 0 to 1.
  void show(double done, const std::string& what);
  /// Wipes it away, for what is printed to the same terminal.
  void clear();

 private:
  bool terminal_, shown_ = false;
  double last_;  ///< wall clock [s]
};

}  // namespace program
