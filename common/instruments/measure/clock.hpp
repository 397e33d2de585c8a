#pragma once

#include <time.h>

namespace measure {

/// Seconds of processor time that the calling thread has used. Unlike the clock on the wall it does
/// not run on while another process has the core.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Whether this build is one to measure: optimised, and without assertions.
#if defined(__OPTIMIZE__) && defined(NDEBUG)
inline constexpr bool optimised = true;
#else
inline constexpr bool optimised = false;
#endif

}  // namespace measure
