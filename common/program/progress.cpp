#include "program/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>

namespace program {
namespace {

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

Progress::Progress() : terminal_(isatty(STDERR_FILENO) != 0), last_(wall_seconds() + 0.8) {}

Progress::~Progress() { clear(); }

void Progress::clear() {
  if (shown_) std::fputs("\r\033[K", stderr);
  shown_ = false;
}

void Progress::show(double done, const std::string& what) {
  if (!terminal_) return;
  const double now = wall_seconds();
  if (now - last_ < 0.2) return;
  last_ = now;
  shown_ = true;
  std::fputs(fmt::format("\r\033[K{:3.0f} % {}", 100.0 * done, what).c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace program
