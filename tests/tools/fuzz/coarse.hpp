#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace fuzz {

/// A run with a step from a thirtieth of its method's limit to three times it, over 1 to 400 s, and
/// what is known of its scene from its options alone.
struct Coarse {
  struct Mass {
    double m = 0.0, I = 0.0;  ///< [kg], [kg·m²]
  };
  std::size_t chapter = 0;             ///< counted from 0
  std::vector<std::string> arguments;  ///< of `run`
  std::map<std::string, Mass> masses;  ///< of its things
  double radius = 0.0;                 ///< of its largest thing [m]
  double gradient = 1.0;               ///< at least of C, so that |C| over it is a length
  double bottom = 0.0;                 ///< 1: the bottom of a valley, at the origin, belongs to it
};

Coarse make_coarse(std::uint64_t seed, std::uint64_t index);

/// What a run printed, as far as it is looked at.
struct Ended {
  int status;
  std::string out, err;  ///< the summary, and standard error
  std::string table;     ///< the trajectory of the same run
};

/// What is wrong with it, or nothing: a run that ends with 0 and says nothing is right to 10 % of
/// its scene's size, where the exact answer is known; one that is right to 0.1 % in its joints, its
/// energy and its place does not warn.
std::string check_coarse(const Coarse& coarse, const Ended& ended);

}  // namespace fuzz
