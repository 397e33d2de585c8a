#pragma once

#include "mechanics/joints/revolute.hpp"

namespace revolute {

// [without]
/// The pin without J̇v: it holds two points together as if no body turned. Each point needs ω² |u|
/// towards its centre of mass to stay on its circle, and this pin does not provide it.
struct WithoutJdotV : joints::Revolute {
  template <class First, class Second>
  dynamics::Rows<2, First, Second> rows(const First& first, const Second& second) const {
    auto rows = Revolute::rows(first, second);
    rows.Jdot_v.setZero();
    return rows;
  }
};
// [without]

}  // namespace revolute
