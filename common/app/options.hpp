#pragma once

#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace app {

/// An argument that cannot be used: exit status 2. The message is one line that names the option,
/// its value and what is allowed.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The values that a number may take.
struct Range {
  double low = -1e12, high = 1e12;

  bool holds(double value) const { return value >= low && value <= high; }
  std::string text() const;
};

inline constexpr Range any{};  ///< of either sign, |value| ≤ 1e12
inline constexpr Range positive{1e-12, 1e12};
inline constexpr Range not_negative{0.0, 1e12};
inline constexpr Range on_or_off{0.0, 1.0};

/// What a number that the reader may choose can be besides.
enum Trait : unsigned {
  acts = 1,        ///< changes the motion, neither the start nor a shape: it may while all moves
  switchable = 2,  ///< 0 switches it off
};

/// How the option of a term that can be left out begins.
inline constexpr std::string_view without = "--without=";

/// One number that the reader may choose. It stays where the scene keeps it: a count as an int, a
/// switch, 0 or 1, as a bool.
struct Parameter {
  std::string option;  ///< "--x0"; "--without=jdotv", a switch that leaves a term out
  std::string unit;    ///< "m"; empty for a pure number
  std::string help;
  std::variant<double*, int*, bool*> place;  ///< holds the default
  Range allowed;
  unsigned traits = 0;  ///< of those above, added up

  bool is(Trait trait) const { return (traits & trait) != 0; }
  bool is_switch() const { return std::holds_alternative<bool*>(place); }
  bool is_whole() const { return !std::holds_alternative<double*>(place); }

  double value() const {
    return std::visit([](const auto* number) { return static_cast<double>(*number); }, place);
  }
  void set(double value) const {
    std::visit(
        [=](auto* number) {
          *number = static_cast<std::remove_pointer_t<decltype(number)>>(value);
        },
        place);
  }
};

/// A word or a text that the reader may choose: one of `names`, where there are some.
struct Text {
  std::string option;  ///< "--path"
  std::string form;    ///< as --help shows it: "NAME", "FILE"
  std::string help;
  std::string* place;  ///< holds the default
  std::vector<std::string> names = {};
};

/// Reads a number; throws UsageError naming the option where it is none or not allowed.
double number(const std::string& option, const std::string& text, const Range& allowed,
              bool only_whole = false);

}  // namespace app
