#pragma once

#include "app/options.hpp"
#include "mechanics/paths/by_length.hpp"
#include "scene.hpp"

namespace any_wire {

/// The path of a scene. Throws std::invalid_argument, which names the option, where it is none.
paths::Path path_of(const Scene& scene);

/// The same by its length.
paths::ByLength wire_of(const Scene& scene);

/// A number that a path is chosen by, on the command line or in a file.
struct Number {
  const char *option, *unit, *help;
  double Scene::*place;
  app::Range allowed;
};
const std::vector<Number>& numbers();

/// What the parameter of a path is not good for, beside the length: nothing; steps of one size,
/// where |x′| is small or x″ jumps; or any, where |x′| jumps and with it the speed.
enum class Parameter { good, poor, wrong };
Parameter parameter_of(const paths::Path& path);

/// "x,y x,y" as points; `option` is for the message of std::invalid_argument.
paths::Points points_of(const std::string& option, const std::string& text);

/// A bound of how fast a bead's equation changes [rad/s]: the largest, over the places that its
/// energy can reach, of what q̇ or the direction of the wire changes by.
double fastest(const Scene& scene);

}  // namespace any_wire
