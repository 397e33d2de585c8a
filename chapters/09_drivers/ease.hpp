// Eases: how a move from one value to another takes its time. Each starts and ends at rest; what
// differs is how f'' begins, and whether it jumps.
//
// E goes from 0 to 1 while s does, and its second half is its first turned by half a turn about
// (1/2, 1/2):   E(s) = 1 - E(1 - s),   E'(s) = E'(1 - s),   E''(s) = -E''(1 - s).
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>

#include "mechanics/joints/driver.hpp"

namespace eases {

/// E, E' and E'' at one s.
struct Derivatives {
  double value, first, second;
};

/// A curve of progression by its name and its first half, for s from 0 to 1/2.
struct Ease {
  std::string_view name;
  Derivatives (*first_half)(double s);
};

/// 10 s^3 - 15 s^4 + 6 s^5: E' and E'' begin and end at 0.
inline Derivatives smooth(double s) {
  return {s * s * s * (10 + s * (6 * s - 15)), 30 * s * s * (1 - s) * (1 - s),
          60 * s * (1 - s) * (1 - 2 * s)};
}
/// (1 - cos pi s) / 2: E'' begins with a jump, and ends with one.
inline Derivatives sine_in_out(double s) {
  constexpr double pi = std::numbers::pi;
  const double half = std::sin(pi * s / 2);
  return {half * half, pi / 2 * std::sin(pi * s), pi * pi / 2 * std::cos(pi * s)};
}
/// (2 s)^p / 2: E'' jumps from 2 p (p - 1) to its opposite in the middle; with p = 2 at the ends
/// too.
template <int p>
Derivatives power_in_out(double s) {
  const double power = std::pow(2 * s, p - 2);
  return {power * 2 * s * s, power * 2 * p * s, power * 2 * p * (p - 1)};
}

inline constexpr std::array<Ease, 6> all{{{"smooth", smooth},
                                          {"sine_in_out", sine_in_out},
                                          {"quadratic_in_out", power_in_out<2>},
                                          {"cubic_in_out", power_in_out<3>},
                                          {"quartic_in_out", power_in_out<4>},
                                          {"quintic_in_out", power_in_out<5>}}};

/// The ease of a name; std::invalid_argument, which lists them, for another.
inline const Ease& named(std::string_view name) {
  std::string names;
  for (const Ease& ease : all) {
    if (ease.name == name) return ease;
    names.append(names.empty() ? "" : ", ").append(ease.name);
  }
  std::string message = "ease ";
  message.append(name.empty() ? "''" : name);
  message.append(name == "linear" ? ": its rate jumps at both ends, which takes an infinite force"
                                  : ": there is none of that name");
  throw std::invalid_argument(message.append("; allowed is one of ").append(names));
}

/// A move along an ease, for a driver: rests at `from` (rad) until the time `start` (s), then turns
/// by `by` (rad) in `duration` (s), and rests.
struct Move {
  Ease ease;
  double from, by, start, duration;

  /// Where f'' may jump, or bends: the start, the middle and the end.
  std::array<double, 3> jumps() const { return {start, start + duration / 2, start + duration}; }

  /// At a jump, what is behind it.
  joints::Given operator()(double t) const {
    const auto [begin, middle, end] = jumps();
    if (t < begin) return {from, 0, 0};
    if (t >= end) return {from + by, 0, 0};
    const bool second_half = t >= middle;
    const double s = (second_half ? end - t : t - begin) / duration;
    const auto [E, E_s, E_ss] = ease.first_half(s);
    const double sign = second_half ? -1 : 1;
    return {(second_half ? from + by : from) + sign * by * E, by / duration * E_s,
            sign * by / (duration * duration) * E_ss};
  }
};

}  // namespace eases
