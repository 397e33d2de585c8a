#include "app/options.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>

namespace app {
namespace {

#ifdef __cpp_lib_to_chars
using std::from_chars;
#else
/// For the standard library of clang, in the book, which has this for whole numbers alone.
std::from_chars_result from_chars(const char* first, const char* last, double& value) {
  const std::string text(first, last);
  if (text.empty() || text.find_first_not_of("+-.0123456789eE") != std::string::npos ||
      text[0] == '+')
    return {first, std::errc::invalid_argument};
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return {first + (end - text.c_str()), std::errc{}};
}
#endif

}  // namespace

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
  const auto [end, error] = from_chars(first, last, value);
  const bool too_small = error == std::errc::result_out_of_range;
  if (error == std::errc::invalid_argument || end != last || first == last || too_small ||
      !allowed.holds(value) || (only_whole && value != std::floor(value)))
    throw UsageError(fmt::format("{} {}: allowed is {}{}", option, text.empty() ? "''" : text,
                                 allowed.text(), only_whole ? ", whole" : ""));
  return value;
}

}  // namespace app
