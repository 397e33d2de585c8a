#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "instruments/measure/ladder.hpp"
#include "instruments/measure/run.hpp"
#include "mechanics/motion/method.hpp"
#include "mechanics/motion/motion.hpp"

namespace measure {

/// Runs `steps` steps of h [s] and looks at each. Throws Diverged as Watch does.
Largest run_and_watch(mechanics::Simulation& simulation, long steps, double h);

/// One integrator's plane of two numbers: where a run is stable, and what theory says.
struct Plan {
  integrators::Scheme integrator;
  std::string x_label, y_label;
  double x_max, y_max;                               ///< the plane is 0 … x_max, 0 … y_max
  std::function<bool(double x, double y)> stable;    ///< measured, by running the scene
  std::function<double(double x, double y)> growth;  ///< theory: factor per step; above 1: unstable
  double theory_to = std::numeric_limits<double>::infinity();  ///< the y up to which it holds
  int differing = 0;      ///< cells up to there in which it is known to be wrong
  std::string name = {};  ///< empty: the integrator's
  bool of_gains = false;  ///< x is kd h and y is ks h²

  std::string title() const {
    return name.empty() ? std::string(integrators::info(integrator).text) : name;
  }
};

struct Cell {
  double x, y;  ///< its centre
  bool stable, theory;
  bool compared;  ///< theory holds here and says the same in the whole cell
};

struct Map {
  Plan plan;
  int across;  ///< cells in either direction
  std::vector<Cell> cells;

  int compared() const;
  int agreeing() const;  ///< of those compared
};

Map measure_map(const Plan& plan, int across, const Progress& progress = {});

/// How feedback is tried out: the scene is pushed off its constraints by `nudge` [m, rad] and runs
/// for so many steps, short enough that nothing else in the scene is at its limit.
struct FeedbackTrial {
  double step;   ///< [s]
  double nudge;  ///< small beside the scene
  long steps = 2000;
};

/// Whether the constraint error dies out: its largest value in the last quarter of the run is
/// smaller than in the second.
bool feedback_decays(const Start& start, const mechanics::Method& method,
                     const FeedbackTrial& trial);

/// The plane (kd h, ks h²) of feedback for every integrator, with the growth of the test equation.
std::vector<Plan> feedback_plans(const Start& start, const FeedbackTrial& trial);

/// The largest s = h√ks at critical damping at which the error still dies out, by bisection; and
/// the same by theory. The implicit midpoint rule has none: 8, the end of the search, stands there.
double measured_limit(integrators::Scheme name, const Start& start, const FeedbackTrial& trial);
double theoretical_limit(integrators::Scheme name);

/// A method in a run of very many steps, and whether its energy error is expected to stay bounded.
struct LongMethod {
  mechanics::Method method;
  bool bounded;
};

/// The energy error of a method over a long run: the largest so far, as a part of the largest
/// kinetic energy in the first thousand steps, at times spaced evenly in their logarithm.
struct LongCurve {
  std::string method;
  bool expected_bounded = false;
  struct Look {
    double t, energy_error;
  };
  std::vector<Look> looks = {};
  std::string failure = {};

  /// How it grows with time over the last tenfold of time: as t to this power.
  double exponent() const;
  /// It does not grow, and not because it is as large as it can become.
  bool bounded() const {
    return failure.empty() && exponent() < 0.25 && looks.back().energy_error < 0.5;
  }
};

LongCurve long_run(mechanics::Simulation& simulation, const LongMethod& method, long steps,
                   double h);

}  // namespace measure
