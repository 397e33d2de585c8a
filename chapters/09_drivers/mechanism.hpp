#pragma once

#include <functional>

#include "07_slider_crank/mechanism.hpp"
#include "ease.hpp"
#include "scene.hpp"

namespace drivers {

/// The wheel's angle over time [s].
using Function = std::function<joints::Given(double t)>;

/// Chapter 7's machine whose wheel is turned by a function, from where and as fast as that begins.
mechanics::Mechanism make_mechanism(const slider_crank::Scene& machine, const Function& f,
                                    const mechanics::Method& method,
                                    slider_crank::Bodies* bodies = nullptr);

/// What the wheel is told. std::invalid_argument, which begins with "ease", for a name that is
/// none.
eases::Move move(const Scene& scene);

/// The same of a scene. std::invalid_argument, too, for a start from which it can go on in two
/// ways.
mechanics::Mechanism make_mechanism(const Scene& scene, const mechanics::Method& method,
                                    slider_crank::Bodies* bodies = nullptr);

}  // namespace drivers
