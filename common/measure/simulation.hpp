#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "integrators/integrator.hpp"
#include "measure/method.hpp"

namespace measure {

/// What every model tells of its state, whatever it is made of.
struct Measures {
  double energy;            ///< kinetic and potential [J]
  double constraint_error;  ///< largest |C|, in the unit of C
  double velocity_error;    ///< largest |J v|
  double work = 0.0;        ///< done by loads that have no potential [J]
  double kinetic;           ///< [J]
  double drive;  ///< √(FᵀWF) of the applied forces: how fast √(2·kinetic) grows at most [N/√kg]

  /// What stays constant in an exact motion [J].
  double balance() const { return energy - work; }
  bool finite() const {
    return std::isfinite(balance()) && std::isfinite(constraint_error) &&
           std::isfinite(velocity_error);
  }
};

/// One line of a trajectory.
struct Row {
  double t;                   ///< [s]
  std::vector<double> state;  ///< positions and velocities, SI
  Measures measures;
  std::vector<double> reactions;  ///< forces [N] and moments [N·m]
};

/// What the values of a Row are called, in the same order.
struct Columns {
  std::vector<std::string> state;
  std::vector<std::string> reactions;
};

/// What a scene holds, and what it does without.
struct Uses {
  int things, coordinates, rows, rank;
  int blocks_of_J = 0, blocks_of_factor = 0;  ///< 0 where there are no matrices
  std::size_t state_bytes, workspace_bytes;
  std::vector<std::string> left_out;

  int degrees_of_freedom() const { return coordinates - rank; }
};

/// A simulation that cannot go on; the message is one line for the user.
struct Diverged : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// "at t = 3.2 s: ", for such a message.
inline std::string at(double t) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "at t = %.6g s: ", t);
  return text.data();
}

/// A scene in motion under one method: what the measurements, the tables and the pictures drive.
class Simulation {
 public:
  virtual ~Simulation() = default;

  /// Back to the start; the count of evaluations begins again.
  virtual void restart() = 0;
  /// Moves on by `steps` steps of h [s], each in as many parts as a method with a tolerance takes.
  /// Throws Diverged when the state is no longer finite or the method cannot take its step.
  virtual void advance(long steps, double h) = 0;
  /// Pushes the state off its constraints: each coordinate by another part of `size` [m, rad].
  virtual void nudge(double size) = 0;
  /// Goes on from the time and the state of another simulation of the same scene, which may have
  /// another method or other loads.
  virtual void take_over(const Simulation& other) = 0;

  virtual double time() const = 0;
  /// How often q̈ = a(t, q, v) was evaluated: the cost that no clock blurs.
  virtual long evaluations() const = 0;
  /// How many steps the integrator has taken.
  virtual long steps() const = 0;
  // These two may use the model's workspace.
  virtual Measures measures() = 0;
  /// The √(2·kinetic) that feedback can make of the constraint error as it is now [√J].
  virtual double feedback_speed() = 0;
  /// The part of the scene that moves most and the constraint that is furthest off, in words.
  virtual std::string culprit() = 0;
  virtual Row row() = 0;
  virtual Columns columns() const = 0;
  /// After the last evaluation of the acceleration.
  virtual Uses uses() = 0;
  /// What the user should know of the start, a line each: a state that had to be projected, for
  /// example.
  virtual std::vector<std::string> notes() const = 0;
};

inline bool is_finite(double value) { return std::isfinite(value); }
template <class Vector>
bool is_finite(const Vector& values) {
  return values.allFinite();
}
inline long size(double) { return 1; }
template <class Vector>
long size(const Vector& values) {
  return values.size();
}

/// A model is a state (q, v) of some vector type and its acceleration. One with constraints may
/// have a way back onto them, project(q, v), and know its feedback_speed(q).
template <class M>
concept Model = requires(M model, typename M::Vector& q, typename M::Vector& v, Row& row) {
  model.acceleration(0.0, q, v, q);  // writes q̈ into the last argument
  { model.initial_position() } -> std::convertible_to<typename M::Vector>;
  { model.initial_velocity() } -> std::convertible_to<typename M::Vector>;
  { model.measures(0.0, q, v) } -> std::same_as<Measures>;
  { model.culprit(0.0, q, v) } -> std::same_as<std::string>;
  { model.free_acceleration() } -> std::same_as<double>;  // |q̈| at the start without constraints
  { model.columns() } -> std::same_as<Columns>;
  { model.uses() } -> std::same_as<Uses>;
  model.observe(0.0, q, v, row);  // fills row.state and row.reactions
};

/// A model in motion: the one loop of the tutorial.
template <Model M>
class Motion final : public Simulation {
 public:
  using Vector = typename M::Vector;

  Motion(M model, const Method& method)
      : model_(std::move(model)),
        integrator_(method.integrator, model_.initial_position(), method.tolerance,
                    epsilon * model_.free_acceleration()),
        projected_(method.stabilization == Stabilization::projection) {
    restart();
    most_evaluations_ = most_work / std::max(least_size, size(q_));
  }

  void restart() override {
    q_ = model_.initial_position();
    v_ = model_.initial_velocity();
    integrator_.restart();
    t_ = t_anchor_ = h_ = 0.0;
    intervals_since_anchor_ = steps_ = evaluations_ = 0;
  }

  // [loop]
  void advance(long steps, double h) override {
    if (h != h_) anchor(h);
    const auto acceleration = [this](double t, const Vector& q, const Vector& v, Vector& a) {
      ++evaluations_;
      model_.acceleration(t, q, v, a);
    };
    for (long i = 0; i < steps; ++i) {
      const double end = t_anchor_ + static_cast<double>(++intervals_since_anchor_) * h;
      for (double rest = h; rest > 0.0;) {
        rest -= step(acceleration, rest);
        if constexpr (requires { model_.project(q_, v_); })
          if (projected_) model_.project(q_, v_);
        t_ = end - rest;
        if (!is_finite(q_) || !is_finite(v_))
          throw Diverged(at(t_) + first_not_finite() + " is no longer finite");
        if (rest > 0.0 && evaluations_ > most_evaluations_)
          throw Diverged(at(t_) + "the tolerance takes too many steps");
      }
    }
  }
  // [loop]

  void nudge(double size) override {
    if constexpr (std::is_same_v<Vector, double>)
      q_ += size;
    else
      for (Eigen::Index i = 0; i < q_.size(); ++i) q_[i] += size * std::cos(static_cast<double>(i));
  }

  void take_over(const Simulation& other) override {
    const auto& motion = dynamic_cast<const Motion&>(other);
    integrator_.restart();
    q_ = motion.q_;
    v_ = motion.v_;
    t_ = motion.t_;
    h_ = 0.0;  // the next step counts its time from here
  }

  double time() const override { return t_; }
  long evaluations() const override { return evaluations_; }
  long steps() const override { return steps_; }
  Measures measures() override { return model_.measures(t_, q_, v_); }
  double feedback_speed() override {
    if constexpr (requires { model_.feedback_speed(q_); })
      return model_.feedback_speed(q_);
    else
      return 0.0;
  }
  std::string culprit() override { return model_.culprit(t_, q_, v_); }
  Columns columns() const override { return model_.columns(); }
  Uses uses() override {
    Uses uses = model_.uses();
    if constexpr (requires { model_.project(q_, v_); })
      if (!projected_) uses.left_out.push_back("projection");
    return uses;
  }
  Row row() override {
    Row row{t_, {}, measures(), {}};
    model_.observe(t_, q_, v_, row);
    return row;
  }

  std::vector<std::string> notes() const override {
    if constexpr (requires { model_.notes(); })
      return model_.notes();
    else
      return {};
  }

  M& model() { return model_; }
  const M& model() const { return model_; }
  const Vector& q() const { return q_; }
  const Vector& v() const { return v_; }

 private:
  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  /// So many evaluations times coordinates are allowed to a tolerance, a second or two of work;
  /// below so many coordinates an evaluation costs the same.
  static constexpr long most_work = 50000000, least_size = 20;

  template <class Acceleration>
  double step(Acceleration& acceleration, double h) {
    ++steps_;
    try {
      return integrator_.step(acceleration, t_, q_, v_, h);
    } catch (const integrators::NoStep& reason) {
      throw Diverged(at(t_) + reason.what());
    }
  }

  /// The name of the first such entry of the state.
  std::string first_not_finite() {
    Row row{t_, {}, {}, {}};
    model_.observe(t_, q_, v_, row);
    const Columns names = model_.columns();
    for (std::size_t i = 0; i < row.state.size(); ++i)
      if (!std::isfinite(row.state[i])) return names.state[i];
    return "the state";
  }

  /// t = t_anchor + n h, not a running sum, which would gather rounding over a million steps.
  void anchor(double h) {
    t_anchor_ = t_;
    h_ = h;
    intervals_since_anchor_ = 0;
  }

  M model_;
  integrators::Integrator<Vector> integrator_;
  bool projected_;
  long most_evaluations_;
  Vector q_, v_;
  double t_, t_anchor_, h_;
  long intervals_since_anchor_, steps_, evaluations_;
};

}  // namespace measure
