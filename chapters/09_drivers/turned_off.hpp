#pragma once

#include "mechanism.hpp"

namespace drivers {

// [lies]
/// A driver that keeps its rate to itself: C_t = 0.
inline Function without_C_t(Function f) {
  return [=](double t) { return joints::Given{f(t).f, 0.0, f(t).f_ddot}; };
}
/// One that does not tell how its rate changes: C_tt = 0.
inline Function without_C_tt(Function f) {
  return [=](double t) { return joints::Given{f(t).f, f(t).f_dot, 0.0}; };
}
// [lies]
/// One that is told a step too late.
inline Function late(Function f, double h) {
  return [=](double t) { return f(t - h); };
}

}  // namespace drivers
