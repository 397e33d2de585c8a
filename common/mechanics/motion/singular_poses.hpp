#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "mechanics/dynamics/system.hpp"
#include "mechanics/motion/motion.hpp"

namespace mechanics {

/// Finds the times at which the rows of a moving scene become dependent for a moment, as those of a
/// slider-crank in a dead centre, and the rows that do. It looks at the pivot that the others leave
/// of the weakest row: about a singular pose that falls as (t − t₀)², so the lowest of three looks
/// is one when the parabola through them comes down to 0, within a tenth of their height.
class SingularPoses {
 public:
  /// To be called with the evaluation at t, step by step.
  void look(double t, const dynamics::Evaluation& e) {
    if (e.C().size() == 0) return;
    if (looks_ == 0) {
      always_ = e.dependent_rows();
      moves_through_ = e.is_limit();
    }
    const dynamics::RowState weakest = e.weakest_row();
    last_ = {last_[1], last_[2], {t, weakest.pivot, weakest.row}};
    if (++looks_ >= 3) find();
  }

  /// A line for the rows that depended on others at the start, and one for the poses.
  std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    if (!always_.empty()) {
      notes.push_back(moves_through_
                          ? "rows that depend on others at the start, where forces are the limits "
                            "along the motion:"
                          : "rows that depend on others at the start, so that who carries which "
                            "load is not determined:");
      for (const auto& [joint, row] : always_)
        notes.back() += " " + joint + " row " + std::to_string(row);
    }
    if (!poses_.empty()) {
      constexpr std::size_t most = 12;
      notes.push_back("J loses rank " +
                      (poses_.size() == 1 ? "once" : std::to_string(poses_.size()) + " times") +
                      ", at t =");
      for (std::size_t i = 0; i < poses_.size() && i < most; ++i)
        notes.back() += (i == 0 ? " " : ", ") + in_digits(poses_[i].t, 4) + " s (" +
                        poses_[i].row.joint + " row " + std::to_string(poses_[i].row.row) + ")";
      if (poses_.size() > most) notes.back() += ", ...";
    }
    return notes;
  }

  struct Look {
    double t = 0.0, pivot = 1.0;
    dynamics::JointRow row = {};
  };
  const std::vector<Look>& poses() const { return poses_; }

 private:
  void find() {
    const auto& [before, lowest, after] = last_;
    if (!(lowest.pivot < before.pivot && lowest.pivot <= after.pivot)) return;
    // Newton's form of the parabola through the three looks, and its lowest point.
    const double slope_1 = (lowest.pivot - before.pivot) / (lowest.t - before.t);
    const double slope_2 = (after.pivot - lowest.pivot) / (after.t - lowest.t);
    const double bend = (slope_2 - slope_1) / (after.t - before.t);
    const double t = 0.5 * (before.t + lowest.t - slope_1 / bend);
    const double depth =
        before.pivot + slope_1 * (t - before.t) + bend * (t - before.t) * (t - lowest.t);
    if (depth < 0.1 * std::min(before.pivot, after.pivot)) poses_.push_back({t, depth, lowest.row});
  }

  std::vector<dynamics::JointRow> always_;
  bool moves_through_ = false;
  std::array<Look, 3> last_;
  long looks_ = 0;
  std::vector<Look> poses_;
};

}  // namespace mechanics
