#include "instruments/files/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>

namespace files {

Progress::Progress() {
  if (isatty(STDERR_FILENO) != 0) writer_ = std::thread([this] { write_now_and_then(); });
}

Progress::~Progress() {
  if (!writer_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  over_.notify_one();
  writer_.join();
}

void Progress::write_now_and_then() {
  using namespace std::chrono;
  const auto start = steady_clock::now();
  auto next = start + milliseconds(800);
  std::unique_lock lock(mutex_);
  while (!over_.wait_until(lock, next, [this] { return ends_; })) {
    next += milliseconds(200);
    if (hidden_) continue;
    shown_ = true;
    const auto seconds = duration_cast<std::chrono::seconds>(steady_clock::now() - start).count();
    std::fputs(fmt::format("\r\033[K{:3.0f} % {}, {} s", 100.0 * done_, what_, seconds).c_str(),
               stderr);
    std::fflush(stderr);
  }
  wipe();
}

void Progress::wipe() {
  if (shown_) std::fputs("\r\033[K", stderr);
  shown_ = false;
}

void Progress::show(double done, const std::string& what) {
  if (!writer_.joinable()) return;
  const std::lock_guard lock(mutex_);
  done_ = done;
  what_ = what;
  hidden_ = false;
}

void Progress::clear() {
  if (!writer_.joinable()) return;
  const std::lock_guard lock(mutex_);
  wipe();
  hidden_ = true;
}

}  // namespace files
