#pragma once

#include "mechanics/paths/path.hpp"
#include "scene.hpp"

namespace any_wire {

/// The path of a scene. Throws std::invalid_argument, which names the option, where it is none.
paths::Path path_of(const Scene& scene);

/// "x,y x,y" as points; `option` is for the message of std::invalid_argument.
paths::Points points_of(const std::string& option, const std::string& text);

/// A bound of how fast a bead's equation changes [rad/s]: the largest, over the places that its
/// energy can reach, of what q̇ or the direction of the wire changes by.
double fastest(const Scene& scene);

}  // namespace any_wire
