#include "instruments/measure/run_options.hpp"

#include <cmath>

namespace measure {
namespace {

/// A duration that misses a whole number of steps by rounding alone is taken as whole.
constexpr double rounding = 1e-9;

}  // namespace

long RunOptions::whole_steps() const {
  return static_cast<long>(std::floor(duration / step * (1.0 + 1e-15) + rounding));
}

double RunOptions::remainder() const {
  const double rest = duration - static_cast<double>(whole_steps()) * step;
  return rest > rounding * step ? rest : 0.0;
}

}  // namespace measure
