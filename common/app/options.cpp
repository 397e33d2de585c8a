#include "app/options.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace app {

std::string Range::text() const {
  if (low == high) return fmt::format("only {:g}", low);
  if (low == 0.0) return fmt::format("a number from 0 to {:g}", high);
  return fmt::format("a number from {:g} to {:g}", low, high);
}

double number(const std::string& option, const std::string& text, const Range& allowed,
              bool only_whole) {
  double value = 0.0;
  const char* first = text.data() + (text.starts_with('+') && !text.starts_with("+-") ? 1 : 0);
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(first, last, value);
  const bool too_small = error == std::errc::result_out_of_range;
  if (error == std::errc::invalid_argument || end != last || first == last || too_small ||
      !allowed.holds(value) || (only_whole && value != std::floor(value)))
    throw UsageError(fmt::format("{} {}: allowed is {}{}", option, text.empty() ? "''" : text,
                                 allowed.text(), only_whole ? ", whole" : ""));
  return value;
}

}  // namespace app
