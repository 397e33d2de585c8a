#pragma once

#include <string>

#include "mechanics/motion/method.hpp"

namespace measure {

/// What the shared options say of one run.
struct RunOptions {
  double duration;       ///< [s]
  double step;           ///< [s]
  double every = 0.0;    ///< time between rows [s]; 0: every step
  std::string csv = {};  ///< file name, "-" for standard output, empty for none
  mechanics::Method method = {};

  /// Whole steps in the run, and what is left over for a last, shorter one [s].
  long whole_steps() const;
  double remainder() const;
};

}  // namespace measure
