#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mechanics/motion/motion.hpp"
#include "mechanics/motion/reach.hpp"

namespace mechanics {

/// A value [any unit] that is followed over a run: its largest, and since when it was how large.
class Growth {
 public:
  void take(double t, double value);
  double most() const { return most_; }
  /// When it first rose above a level [s]; to within the time in which it grew by a twentieth.
  double since(double level) const;

 private:
  struct Note {
    double t, value;
  };
  std::vector<Note> notes_;  ///< each a twentieth above the one before
  double most_ = 0.0, t_ = 0.0;
};

/// What of a run is far from right; nothing where nothing is.
struct Verdict {
  struct Fault {
    std::string what;   ///< "joints", "energy", "position", "velocity", "tolerance": for tables
    std::string words;  ///< by how much, in one clause
    Trouble trouble;    ///< what to try depends on it
  };
  std::vector<Fault> faults;

  bool right() const { return faults.empty(); }
  /// Of the first.
  Trouble trouble() const { return right() ? Trouble::wrong : faults.front().trouble; }
  std::string text() const;   ///< one line: all clauses
  std::string words() const;  ///< "joints and energy", for a caption or a table
};

/// Looks at a run, step by step: stops one that diverges, and says at its end, or at any time,
/// whether it was a motion of its scene at all.
///
/// *Divergence.* Forces of constraints do no work, so whatever the joints, the speed √(2T) of the
/// whole scene (in the mass metric, T its kinetic energy) obeys
///
///     √(2T) ≤ √(2T₀) + ∫ √(FᵀWF) dt + what feedback can make of the constraint error at the start
///
/// with the applied forces F alone: a bound without any threshold in metres or joules. Of joints
/// that depend on time, T may grow by their power besides, ∫ |λ·C_t| dt. A run whose
/// kinetic energy is twice what this allows is no longer a motion of the scene.
///
/// *Verdict.* A run is far from right when more than 1 % is wrong of
///
///     joints      how far one is open, beyond what it was at the start, of the scene's size
///     energy      how far the balance is off, of the largest kinetic energy of the run
///     position    the error against the exact answer, where there is one, of the scene's size
///
/// The balance is energy less the work of the loads. Where a load takes energy and the state does
/// not tell how much, as with a damper, there is none; then the energy must not be above that
/// of the start, whatever it was in between, which a damper makes forgotten, and the velocity must
/// be that of the exact answer to 1 % of the largest speed of the run. Where the start is open and
/// the method takes that away, it does work of its own: after projection the balance counts from
/// there, and under feedback neither the balance nor, until it is taken away, the opening says
/// anything. (What either does to the drift of the steps is an error like others.) What is lost in
/// the rounding of the terms compared does not count.
///
/// A tolerance that was not kept is told as well: with an energy balance off by 200 times that part
/// of the kinetic energy (20, where the steps collapsed besides), or an error by 50 times that part
/// of the state, after more than 220 steps by a thousandth of their square; runs through
/// well-behaved scenes end with 70 and 35 at most.
class Watch {
 public:
  static constexpr double far = 0.01;

  /// Begins with the simulation as it is now.
  explicit Watch(Simulation& simulation);
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

  /// To be called after every step or every few, with the measures then. Throws Diverged.
  void look(const Measures& now);

  /// So far, or at the end, where the error of position is known, [m] and the same in angles [rad],
  /// and that of velocity [m/s].
  Verdict verdict(double position_error = 0.0, double angle_error = 0.0,
                  double velocity_error = 0.0) const;

  /// [J]; not a number where there is no balance.
  double largest_energy_error() const;

 private:
  double speed_of_feedback() const;
  bool feedback_is_stable() const;
  void stop_unstable_feedback();
  double energy_rounding() const;
  void judge_tolerance(double error, Verdict& verdict) const;
  Verdict::Fault fault(const char* what, const std::string& which, double value, const char* unit,
                       double part, double since) const;

  Simulation& simulation_;
  Measures start_, last_;
  bool open_;                ///< at the start, and the method takes it away
  bool moved_ = false;       ///< since the start
  bool taken_away_ = true;   ///< what was open at the start, as far as it was
  double speed_, distance_;  ///< what is allowed; the distance to the constraints at the start
  double t_, balance_;
  double largest_kinetic_, largest_energy_, largest_load_, largest_state_, largest_speed_;
  Reach reach_;
  Growth opening_, energy_;
  std::shared_ptr<const std::function<void()>> look_inside_;  ///< of a tolerance's intervals
};

}  // namespace mechanics
