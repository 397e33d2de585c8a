#pragma once

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "instruments/measure/clock.hpp"
#include "model.hpp"

namespace peers {

/// A run that was not worth its time; steps() says how far it came.
struct CutShort : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A model set up in an engine, at its start, to be run once.
class Run {
 public:
  virtual ~Run() = default;

  /// To the end of the model's duration: all of this, and nothing else, is timed. Throws
  /// std::runtime_error when the engine gives up, and CutShort from an engine that chooses its own
  /// steps after `allowed` seconds of processor time.
  virtual void run(double allowed) = 0;
  virtual long steps() const = 0;  ///< that run() took
  virtual State state() = 0;
  /// Mass [kg] and inertia [kg·m²] of each part, as the engine holds them.
  virtual std::vector<std::pair<double, double>> masses() const = 0;
};

/// What a rung of a setting's ladder is: a step [s] or the accuracy asked of a step-size control.
enum class Rung { step, accuracy };

/// One way to use an engine.
struct Setting {
  std::string name;
  Rung rung = Rung::step;
  double first;             ///< the coarsest rung
  bool is_default = false;  ///< the engine as it comes: one run, at `first`
  bool in_chain = false;    ///< tried on the chain too
  std::function<std::unique_ptr<Run>(const Model&, double rung)> start;
};

struct Engine {
  std::string name, version;
  std::vector<Setting> settings;
};

/// This tutorial's solver, the name under which the tables compare it.
inline const std::string ours = "this solver";
/// The same equations in dense matrices.
inline const std::string dense_form = "dense matrices";

/// All engines that were there when this was built, this tutorial's first.
std::vector<Engine> engines();
/// The names of those that were not.
std::vector<std::string> missing_engines();

Engine this_solver();
Engine dense();
Engine box2d();
Engine chipmunk();
Engine mujoco();
Engine simbody();
Engine ida();

/// For engines that choose their own steps: call it at times.
inline void check_time(double started, double allowed, double t) {
  if (measure::cpu_seconds() - started > allowed)
    throw CutShort(fmt::format("cut short after {:.2g} s, at t = {:.3g} s", allowed, t));
}

/// A whole number of equal steps, each close to `step` [s].
inline long whole_steps(const Model& model, double step) {
  return std::lround(model.duration / step);
}

}  // namespace peers
