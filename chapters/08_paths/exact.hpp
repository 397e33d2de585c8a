#pragma once

#include <functional>
#include <optional>
#include <vector>

namespace any_wire {

/// Where the bead is, and its speed along growing q [m/s].
struct State {
  double q, speed;
};

/// On a cycloid of radius R the bead is an oscillator in the length s from the lowest point,
///
///     s = 4R sin(q/2),   y = 2R − s²/8R,   s̈ = −(g/4R) s,
///
/// so that its period 4π√(R/g) does not depend on how far it swings. Nothing where it has left the
/// wire, which has the length 8R.
std::optional<State> on_cycloid(double R, double g, const State& start, double t);

/// A wire as its energy sees it, as functions of q.
struct Wire {
  std::function<double(double q)> depth;    ///< y [m], down
  std::function<double(double q)> slope;    ///< its derivative
  std::function<double(double q)> stretch;  ///< |x′|, the length [m] of a unit of q
  double first, last;
  std::vector<double> knots;  ///< where these are not smooth
  bool closed;
};

/// The exact motion on any wire. Energy is conserved,
///
///     speed² = e(q) = v0² + 2g (y(q) − y(q0)),   t = ∫ |x′| / speed dq,
///
/// from one turning point, where e = 0, or end of the wire, to the other. With
/// q = (a + b)/2 − (b − a)/2 cos φ between two of them the integrand is smooth in φ, but for the
/// knots, at which it is cut; t(φ) is inverted by Newton's method.
class EnergyMotion {
 public:
  EnergyMotion(Wire wire, double g, const State& start);

  /// Nothing after the bead has left the wire, or where the quadrature does not hold: from or to a
  /// place where it all but stays.
  std::optional<State> at(double t) const;

  /// When it leaves an open wire [s]; infinite where it does not.
  double end() const;

 private:
  /// A way on which q grows or falls, cut into pieces, with the time at which each begins.
  struct Leg {
    double from, whole;        ///< where it begins, and how far it goes, with its sign
    bool turns;                ///< at its end, else it leaves the wire there, or goes around
    double y0;                 ///< a depth at which
    double v2;                 ///< the square of the speed is this
    std::vector<double> ends;  ///< of smooth pieces of the wire, from its beginning
    struct Cut {
      double phi, t;
    };
    std::vector<Cut> cuts = {};

    double way(double phi) const;  ///< behind it
    double duration() const { return cuts.back().t; }
  };

  bool is_knot(double q) const;
  double energy(const Leg& leg, double way) const;
  double dt_dphi(const Leg& leg, double phi) const;
  double time(const Leg& leg, double from, double to) const;
  /// The way from a place in a direction, to where its speed is zero or the wire ends.
  Leg leg(double from, int direction, double y0, double v2);
  State in(const Leg& leg, double t) const;
  std::optional<State> since_last_round(double t) const;

  Wire wire_;
  double g_;
  State start_;
  double before_ = 0;  // the rounds of a closed wire before the start
  bool rests_ = false, holds_ = true;
  std::vector<Leg> legs_;  ///< the first way; where it turns the way back, and the way there again
};

}  // namespace any_wire
