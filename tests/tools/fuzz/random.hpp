#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

namespace fuzz {

/// The distributions of <random> differ between libraries; these do not.
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t index)
      : bits_((seed + 1) * 0x9e3779b97f4a7c15u ^ index * 0xbf58476d1ce4e5b9u) {}

  std::size_t below(std::size_t count) { return static_cast<std::size_t>(bits_() % count); }
  double unit() { return std::ldexp(static_cast<double>(bits_() >> 11), -53); }
  bool chance(double probability) { return unit() < probability; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Log-uniform over 10^low to 10^high.
  double scale(double low, double high) { return std::pow(10.0, between(low, high)); }
  template <class T>
  const T& pick(const std::vector<T>& from) {
    return from[below(from.size())];
  }

 private:
  std::mt19937_64 bits_;
};

}  // namespace fuzz
