#pragma once

#include <time.h>

#include <algorithm>

namespace measure {

/// Seconds of processor time that the calling thread has used. Unlike the clock on the wall it does
/// not run on while another process has the core.
inline double cpu_seconds() {
#ifdef __EMSCRIPTEN__  // a browser has no such clock
  constexpr clockid_t clock = CLOCK_MONOTONIC;
#else
  constexpr clockid_t clock = CLOCK_THREAD_CPUTIME_ID;
#endif
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// How often to measure: in so many samples, fewer where they take longer than `most` together [s].
struct Sampling {
  int samples = 20;
  double most = 1.0;
};

/// Processor time of one call of `work` [s]. A sample is of as many calls as it takes to be long
/// enough for the clock, half a millisecond; the fastest of several is the one that was disturbed
/// least. What `work` has to be set back to belongs into it.
template <class Work>
double seconds_of(Work&& work, const Sampling& sampling = {}) {
  constexpr double long_enough = 5e-4;
  const auto sample = [&](long calls) {
    const double before = cpu_seconds();
    for (long call = 0; call < calls; ++call) work();
    return cpu_seconds() - before;
  };
  long calls = 1;
  double least = sample(calls);
  while (least < long_enough) least = sample(calls *= 2);
  double total = least;
  for (int i = 1; i < sampling.samples && total < sampling.most; ++i) {
    const double seconds = sample(calls);
    least = std::min(least, seconds);
    total += seconds;
  }
  return least / static_cast<double>(calls);
}

/// Whether this build is one to measure: optimised, and without assertions.
#if defined(__OPTIMIZE__) && defined(NDEBUG)
inline constexpr bool optimised = true;
#else
inline constexpr bool optimised = false;
#endif

}  // namespace measure
