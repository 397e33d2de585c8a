#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mechanics/motion/method.hpp"
#include "mechanics/motion/motion.hpp"
#include "mechanics/motion/watch.hpp"

namespace measure {

/// Something that is measured against the exact answer.
struct Quantity {
  std::string name;  ///< "position"
  std::string unit;  ///< "m"; one in m or rad tells where the scene is
  /// Of one that the scene is about besides: its largest exact value, of which an error is a part.
  std::function<double()> largest = {};
};

/// The verdict at the end of a run, where the errors of its quantities are known.
mechanics::Verdict judge(const mechanics::Watch& watch, const std::vector<Quantity>& quantities,
                         const std::vector<double>& errors);

/// One run of one method with one step.
struct Rung {
  std::string method;      ///< Method::label()
  int order = 0;           ///< that theory promises
  double tolerance = 0.0;  ///< of a method that chooses its own steps; 0: it does not
  double step = 0.0;       ///< [s]; the mean of those that the method chose
  long steps = 0;
  long evaluations = 0;
  double seconds = 0.0;  ///< processor time, smallest of several repeats
  std::vector<double> errors =
      {};  ///< of each quantity at the end of the run; empty when the run failed
  double constraint_error = 0.0;  ///< largest |C| over the run
  double energy_error = 0.0;      ///< largest change of the energy balance over the run [J]; not a
                                  ///< number where there is none
  std::string far_off = {};       ///< what of it is far from right: Verdict::words()
  std::string failure = {};       ///< why the run stopped, in words; empty when it did not
};

/// A ladder of ever smaller steps for a list of methods, or of tolerances, each a tenth of the
/// last, for those that choose their own steps.
struct Ladder {
  std::vector<mechanics::Method> methods;
  double duration;  ///< [s]
  double coarsest;  ///< the first step [s], each further one half of the last; a method of more
                    ///< evaluations a step than RK4 begins with a step as much longer
  int rungs = 12;   ///< at most; at least 8 are climbed
  std::vector<Quantity> quantities = {};  ///< of the errors, for the verdict
  long most_steps = 1L << 22;
};

using Start = std::function<std::unique_ptr<mechanics::Simulation>(const mechanics::Method&)>;
using Errors = std::function<std::vector<double>(const mechanics::Row&)>;

/// The Start of a model that `make(method)` puts together.
template <class Make>
Start start_of(Make make) {
  return [make](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<decltype(make(method))>>(make(method), method);
  };
}

using Progress = std::function<void(double done, const std::string& what)>;

/// Runs the ladder; a run that Watch stops is a rung that failed. `errors(row)` compares the last
/// row of a run with the exact answer; the first quantity is the one by which a curve ends: a rung
/// after its error has stopped falling, since from there on rounding is all that is measured.
std::vector<Rung> climb(const Ladder& ladder, const Start& start, const Errors& errors,
                        const Progress& progress);

/// The observed order of quantity `k` between two neighbouring rungs, log2 of the ratio of their
/// errors; not a number where either failed.
double observed_order(const Rung& coarse, const Rung& fine, std::size_t k = 0);

/// What ran the measurement: processor, compiler, flags, build type; a line each, "name: value".
std::vector<std::string> machine();

/// Every integrator with the same stabilization, in the order of integrators::schemes.
inline std::vector<mechanics::Method> every_integrator(
    mechanics::Stabilization stabilization = mechanics::Stabilization::none, double ks = 0.0,
    double kd = 0.0) {
  std::vector<mechanics::Method> methods;
  for (const auto& scheme : integrators::schemes)
    methods.push_back({scheme.id, stabilization, ks, kd});
  return methods;
}

/// What a report of a scene with constraints compares: every integrator alone, RK4 with feedback
/// and with projection, dop853 with projection and without, in given steps and in its own.
inline std::vector<mechanics::Method> methods_to_compare(double ks, double kd) {
  using enum integrators::Scheme;
  std::vector<mechanics::Method> methods = every_integrator();
  methods.push_back({rk4, mechanics::Stabilization::feedback, ks, kd});
  methods.push_back({rk4, mechanics::Stabilization::projection});
  methods.push_back({dop853, mechanics::Stabilization::projection});
  methods.push_back(
      {dop853, mechanics::Stabilization::none, 0.0, 0.0, mechanics::coarsest_tolerance});
  methods.push_back(
      {dop853, mechanics::Stabilization::projection, 0.0, 0.0, mechanics::coarsest_tolerance});
  return methods;
}

}  // namespace measure
