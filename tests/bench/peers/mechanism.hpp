#pragma once

#include "05_revolute/mechanism.hpp"
#include "07_slider_crank/mechanism.hpp"
#include "model.hpp"

namespace peers {

/// The model as the chapter has it. Its joints stand in the model's order: the pins, then the rail.
inline mechanics::Mechanism make_mechanism(const Model& model,
                                           const mechanics::Method& method = {}) {
  if (model.rail) return ::slider_crank::make_mechanism({}, method);
  return revolute::make_mechanism({.links = model.size()}, method);
}

}  // namespace peers
