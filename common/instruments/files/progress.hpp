#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

namespace files {

/// A line on standard error that says how far the work is: only on a terminal, and only once the
/// work has taken 0.8 s. A thread of its own writes it, so that it appears however long a step or a
/// picture takes. It wipes itself away.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` from 0 to 1.
  void show(double done, const std::string& what);
  /// Wipes it away until the next show(), for what is printed to the same terminal.
  void clear();

 private:
  void write_now_and_then();
  void wipe();

  std::mutex mutex_;
  std::condition_variable over_;
  bool shown_ = false, hidden_ = false, ends_ = false;
  double done_ = 0.0;
  std::string what_ = "begins";
  std::thread writer_;  ///< none where standard error is no terminal
};

}  // namespace files
