#pragma once

#include <string>
#include <vector>

#include "instruments/draw/pen.hpp"

namespace pictures {

/// A Jacobian to look at: which joint stands in which rows, which thing in which columns, and the
/// numbers, row by row.
struct Jacobian {
  struct Side {
    std::string name;                ///< "bead1_curve", "bead1"
    std::vector<std::string> parts;  ///< a word for each row or column, may be empty: "x", "y"
  };
  std::vector<Side> joints, things;
  std::vector<double> values;
};

/// Every block that is not zero as a coloured box with its numbers. A block of zeros stays blank:
/// it is not stored.
void draw_jacobian(draw::Pen& pen, const draw::Rect& area, const Jacobian& J);

}  // namespace pictures
