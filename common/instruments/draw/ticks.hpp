#pragma once

#include <string>
#include <vector>

#include "instruments/draw/pen.hpp"

namespace draw {

struct Tick {
  double value = 0;
  std::string label = {};  ///< empty for a minor tick
};

/// The multiples of 1, 2 or 5 times a power of ten in [low, high], at most `at_most` (1 or
/// more) of them; none in a range that is empty or too narrow.
std::vector<Tick> linear_ticks(double low, double high, int at_most);

/// Decades labelled 10⁻³, at most `at_most` of them with a label; the multiples 2 … 9 as minor
/// ticks when every decade has its label. Where there is no more than one decade, 1, 2 and 5 times
/// a power of ten get labels, or round numbers as on a linear axis if that is too few or too many.
std::vector<Tick> log_ticks(double low, double high, int at_most);

/// As many ticks as fit with their labels on an axis of `extent` points.
std::vector<Tick> fitting_ticks(const Pen& pen, double low, double high, bool log, double extent,
                                bool horizontal);

}  // namespace draw
