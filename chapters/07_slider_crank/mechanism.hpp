#pragma once

#include <optional>

#include "mechanics/motion/mechanism.hpp"
#include "scene.hpp"

namespace slider_crank {

/// Where the coordinates of the bodies stand in q; the frame's only where it is simulated.
struct Bodies {
  dynamics::Handle<dynamics::Body> wheel, rod, slider;
  std::optional<dynamics::Handle<dynamics::Body>> frame;
};

/// The scene as a system: wheel, rod and slider, and the frame where it is simulated.
/// std::invalid_argument for a rod that is shorter than the crank.
mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method,
                                    Bodies* bodies = nullptr);

}  // namespace slider_crank
