#pragma once

#include <utility>

namespace revolute {

/// A joint without J̇v: it holds its bodies as if none of them moved. A point of a turning body
/// needs ω² |u| towards the centre of mass to stay on its circle, and this joint does not provide
/// it.
template <class Joint>
struct WithoutJdotV : Joint {
  explicit WithoutJdotV(Joint joint) : Joint(std::move(joint)) {}

  template <class First, class Second>
  auto rows(const First& first, const Second& second) const {
    auto rows = Joint::rows(first, second);
    rows.Jdot_v.setZero();
    return rows;
  }
};

}  // namespace revolute
