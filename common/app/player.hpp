#pragma once

#include <algorithm>
#include <cmath>

namespace app {

/// Makes the simulated time follow the wall clock, whatever the frame rate: told how much time a
/// frame took, it takes as many steps. What no whole step fits in is carried to the next frame;
/// what does not fit into a frame's budget of work, or is too long ago, is dropped, and told.
class Player {
 public:
  static constexpr double budget = 0.012;  ///< of work in a frame [s]
  static constexpr double longest = 0.25;  ///< frame that is made up for [s]

  /// `wall` seconds passed, in which `speed` times as much time is to be simulated in steps of h.
  /// advance(n) takes n steps; clock() is the time [s] by which the work is measured.
  template <class Advance, class Clock>
  void play(double wall, double speed, double h, Advance&& advance, Clock&& clock) {
    owed_ += speed * std::min(wall, longest);
    const long due = static_cast<long>(std::min(owed_ / h * (1.0 + 1e-9), 1e9));
    const double start = clock();
    long done = 0;
    for (long some = 1; done < due;) {
      const double before = clock();
      some = std::min(some, due - done);
      advance(some);
      done += some;
      const double now = clock();
      if (now - start > budget) break;
      if (now - before < budget / 16.0) some *= 2;
    }
    owed_ -= static_cast<double>(done) * h;
    double dropped = done < due ? owed_ : 0.0;
    owed_ -= dropped;
    dropped += speed * std::max(0.0, wall - longest);
    // What was half a second ago counts little.
    if (wall > 0.0) kept_ += -std::expm1(-wall / 0.5) * (1.0 - dropped / (speed * wall) - kept_);
  }

  /// After a pause nothing is owed.
  void rest() {
    owed_ = 0.0;
    kept_ = 1.0;
  }

  /// The part of the time wanted that was simulated lately: 1 when it keeps up.
  double kept() const { return kept_; }

 private:
  double owed_ = 0.0;  ///< time to be simulated [s]
  double kept_ = 1.0;
};

}  // namespace app
