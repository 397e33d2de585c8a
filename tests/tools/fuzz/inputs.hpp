#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace fuzz {

/// An option as a program's own help shows it.
struct Option {
  std::string name;                  ///< "--x0"
  std::string group;                 ///< "Scene", "Method", "Output"
  std::vector<std::string> choices;  ///< of an option that takes a name
  std::optional<double> preset;      ///< where the help tells a number
};

/// The options in the text of `run --help`.
std::vector<Option> read_help(const std::string& help);

/// What a user might type behind the program's name.
struct Input {
  std::vector<std::string> arguments;
  bool must_be_refused = false;  ///< it holds what no chapter takes
};

/// Input `index` of a seed for a program with these options: the same on every machine, whatever
/// was made before. Files are named without a folder; folders that cannot be written are named
/// wherever they are.
Input make_input(std::uint64_t seed, std::uint64_t index, const std::vector<Option>& options);

/// A number from 0 to `count` − 1 that depends on a seed and an index only.
std::size_t choose(std::uint64_t seed, std::uint64_t index, std::size_t count);

/// As a shell reads it back, byte for byte.
std::string quoted(const std::string& argument);

}  // namespace fuzz
