#pragma once

#include <stdexcept>

namespace integrators {

/// A method that cannot take its next step; the message says why, to follow "at t = 3.2 s: ".
struct NoStep : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace integrators
