#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "mechanics/integrators/integrator.hpp"
#include "mechanics/motion/method.hpp"
#include "mechanics/motion/reach.hpp"

namespace mechanics {

/// What every model tells of its state, whatever it is made of.
struct Measures {
  double energy;            ///< kinetic and potential [J]
  double constraint_error;  ///< largest |C|, in the unit of C
  double velocity_error;    ///< largest |J v + C_t|
  double work = 0.0;     ///< done by loads that have no potential [J]; not a number where they only
                         ///< take energy and the state does not tell how much, as with a damper
  double kinetic;        ///< [J]
  double speed = 0.0;    ///< of the thing that moves fastest [m/s]
  double opening = 0.0;  ///< the way that brings the joint that is furthest open back together [m]
  double load = 0.0;     ///< the sizes of all applied forces added up [N]
  double drive;  ///< √(FᵀWF) of the applied forces: how fast √(2·kinetic) grows at most [N/√kg]
  double power = 0.0;  ///< that joints which depend on time put in [W]; their work is in `work`

  /// What stays constant in an exact motion [J]; not a number where there is no such thing.
  double balance() const { return energy - work; }
  bool balances() const { return !std::isnan(work); }
  /// The balance, or where there is none the energy, which then only falls [J].
  double kept() const { return balances() ? balance() : energy; }
  bool finite() const {
    return std::isfinite(kept()) && std::isfinite(constraint_error) &&
           std::isfinite(velocity_error);
  }
};

/// One line of a trajectory.
struct Row {
  double t;                   ///< [s]
  std::vector<double> state;  ///< positions and velocities, SI
  Measures measures;
  std::vector<double> reactions;  ///< forces [N] and moments [N·m]; NaN: not determined
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

/// What is wrong with a run, as far as it matters for what to try.
enum class Trouble {
  wrong,      ///< it is not, or no longer, a motion of the scene
  late,       ///< it is one, at another place than the exact answer
  singular,   ///< its drift decided how it left a pose in which J loses rank
  tolerance,  ///< its tolerance asks for more than can be done
  ended,      ///< nothing: the scene ends here
};

/// A simulation that cannot go on; the message is one line for the user.
struct Diverged : std::runtime_error {
  explicit Diverged(const std::string& message, Trouble kind = Trouble::wrong)
      : std::runtime_error(message), trouble(kind) {}
  Trouble trouble;
};

/// "at t = 3.2 s: ", for such a message.
inline std::string at(double t) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "at t = %.6g s: ", t);
  return text.data();
}

/// A number for such a message.
inline std::string in_digits(double value, int digits = 2) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
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
  /// How many steps the integrator has taken, and the shortest that a tolerance has chosen [s].
  virtual long steps() const = 0;
  virtual double shortest_step() const = 0;
  /// |q|, of which a tolerance is a part.
  virtual double state_size() const = 0;
  virtual const Method& method() const = 0;
  /// The h [s] of the last advance().
  virtual double step() const = 0;
  /// What to call after each step that a tolerance has chosen, but the last of an interval, while
  /// it lives: who looks at a run sees no more of it else than where it is stopped.
  virtual void watch_steps(std::weak_ptr<const std::function<void()>> look) = 0;
  // These two may use the model's workspace.
  virtual Measures measures() = 0;
  /// To the constraints, in the mass metric [m√kg]; 0 for a model that starts on them.
  virtual double distance() = 0;
  /// Covers the places of all that moves.
  virtual void cover(Reach& reach) const = 0;
  /// The part of the scene that moves most and the constraint that is furthest off, in words.
  virtual std::string culprit() = 0;
  virtual Row row() = 0;
  virtual Columns columns() const = 0;
  virtual Uses uses() = 0;
  /// What the user should know of the start, a line each: a state that had to be projected, for
  /// example.
  virtual std::vector<std::string> notes() const = 0;
  /// Whether J has lost its rank for a moment on the way.
  virtual bool lost_rank() const = 0;
};

inline bool is_finite(double value) { return std::isfinite(value); }
template <class Vector>
bool is_finite(const Vector& values) {
  return values.allFinite();
}

inline double norm(double value) { return std::abs(value); }
template <class Vector>
double norm(const Vector& values) {
  return values.norm();
}

/// A model is a state (q, v) of some vector type and its acceleration. One with constraints may
/// have a way back onto them, project(t, q, v), and know its distance(t, q). One whose joints do
/// work tells their power(), one whose acceleration jumps, its next_jump(t); and one that can end
/// has a check(t, q, v), called after each step, that throws Diverged.
template <class M>
concept Model = requires(M model, typename M::Vector& q, typename M::Vector& v, Row& row,
                         Reach& reach) {
  model.acceleration(0.0, q, v, q);  // writes q̈ into the last argument
  { model.initial_position() } -> std::convertible_to<typename M::Vector>;
  { model.initial_velocity() } -> std::convertible_to<typename M::Vector>;
  { model.measures(0.0, q, v) } -> std::same_as<Measures>;
  { model.culprit(0.0, q, v) } -> std::same_as<std::string>;
  { model.free_acceleration(0.0, q, v) } -> std::same_as<double>;  // |q̈| without constraints
  { model.columns() } -> std::same_as<Columns>;
  { model.uses() } -> std::same_as<Uses>;
  model.cover(q, reach);
  model.observe(0.0, q, v, row);  // after measures() there: fills row.state and row.reactions
};

/// A model that may have joints which do work.
template <class M>
concept Driven = requires(M model) {
  { model.is_driven() } -> std::same_as<bool>;
  { model.power() } -> std::same_as<double>;
};

/// A model in motion: the one loop of the tutorial.
template <Model M>
class Motion final : public Simulation {
 public:
  using Vector = typename M::Vector;

  Motion(M model, const Method& method)
      : model_(std::move(model)),
        integrator_(method.integrator, like(), method.tolerance,
                    epsilon * model_.free_acceleration(0.0, model_.initial_position(),
                                                       model_.initial_velocity())),
        method_(method) {
    restart();
  }

  void restart() override {
    q_ = model_.initial_position();
    v_ = model_.initial_velocity();
    integrator_.restart();
    t_ = t_anchor_ = h_ = work_ = 0.0;
    shortest_step_ = std::numeric_limits<double>::infinity();
    intervals_since_anchor_ = steps_ = evaluations_ = 0;
  }

  void advance(long steps, double h) override {
    if (h != h_) anchor(h);
    const auto acceleration = [this](double t, const Vector& q, const Vector& v, Vector& a) {
      ++evaluations_;
      model_.acceleration(std::min(t, latest_), q, v, a);
    };
    for (long i = 0; i < steps; ++i) {
      const double end = t_anchor_ + static_cast<double>(++intervals_since_anchor_) * h;
      if (method_.tolerance > 0.0) begin_interval(h);
      for (double rest = h; rest > 0.0;) {
        const double jump = next_jump();
        const double part = std::min(rest, jump - t_), taken = take_step(acceleration, part);
        rest = part < rest && taken == part ? end - jump : rest - taken;
        t_ = part < rest && taken == part ? jump : end - rest;
        if constexpr (requires { model_.project(t_, q_, v_); })
          if (projected()) model_.project(t_, q_, v_);
        if (!is_finite(q_) || !is_finite(v_))
          throw Diverged(at(t_) + first_not_finite() + " is no longer finite");
        if constexpr (requires { model_.check(t_, q_, v_); }) model_.check(t_, q_, v_);
        if (rest > 0.0) look_inside_interval(h);
      }
    }
  }

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
    work_ = motion.work_;
    h_ = 0.0;  // the next step counts its time from here
  }

  double time() const override { return t_; }
  long evaluations() const override { return evaluations_; }
  long steps() const override { return steps_; }
  double shortest_step() const override { return shortest_step_; }
  void watch_steps(std::weak_ptr<const std::function<void()>> look) override {
    look_ = std::move(look);
  }
  double state_size() const override { return norm(q_); }
  const Method& method() const override { return method_; }
  double step() const override { return h_; }
  Measures measures() override {
    Measures measures = model_.measures(t_, q_, v_);
    measures.work += work_;
    return measures;
  }
  double distance() override {
    if constexpr (requires { model_.distance(t_, q_); })
      return model_.distance(t_, q_);
    else
      return 0.0;
  }
  void cover(Reach& reach) const override { model_.cover(q_, reach); }
  std::string culprit() override { return model_.culprit(t_, q_, v_); }
  Columns columns() const override { return model_.columns(); }
  Uses uses() override {
    Vector a = q_;
    model_.acceleration(t_, q_, v_, a);
    Uses uses = model_.uses();
    if constexpr (requires { model_.project(t_, q_, v_); })
      if (!projected()) uses.left_out.push_back("projection");
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

  bool lost_rank() const override {
    if constexpr (requires { model_.lost_rank(); })
      return model_.lost_rank();
    else
      return false;
  }

  M& model() { return model_; }
  const M& model() const { return model_; }
  const Vector& q() const { return q_; }
  const Vector& v() const { return v_; }

 private:
  bool projected() const { return method_.stabilization == Stabilization::projection; }

  static constexpr double epsilon = std::numeric_limits<double>::epsilon();
  /// An acceleration is noise to rounding of the largest force that there is, which may grow.
  void begin_interval(double h) {
    for (const double t : {t_, t_ + h})
      integrator_.expect_rounding(epsilon * model_.free_acceleration(t, q_, v_));
    pace_t_ = t_;
    pace_steps_ = steps_;
  }

  /// A tolerance may take as many steps as may be given. One whose steps have become so short that
  /// it would take more for this interval alone comes to no end.
  void look_inside_interval(double h) {
    if (const auto look = look_.lock()) (*look)();
    constexpr long enough = 100000;
    if (steps_ - pace_steps_ < enough) return;
    if ((t_ - pace_t_) * most_steps < h * static_cast<double>(enough) ||
        static_cast<double>(steps_) > most_steps)
      throw Diverged(at(t_) + "the tolerance takes more than " + in_digits(most_steps) + " steps",
                     Trouble::tolerance);
    pace_t_ = t_;
    pace_steps_ = steps_;
  }

  template <class Acceleration>
  double take_step(Acceleration& acceleration, double h) {
    ++steps_;
    try {
      double taken;
      if constexpr (requires { model_.on_constraints(); })
        taken = step_of_one_kind(acceleration, h);
      else
        taken = integrate(acceleration, h);
      if (taken < h) shortest_step_ = std::min(shortest_step_, taken);
      return taken;
    } catch (const integrators::NoStep& reason) {
      throw Diverged(at(t_) + reason.what(),
                     method_.tolerance > 0.0 ? Trouble::tolerance : Trouble::wrong);
    }
  }

  /// The order of a step comes from stages that ask for one and the same function. Where one of
  /// them has to be asked on the constraints, the step is begun again with all of them there.
  template <class Acceleration>
  double step_of_one_kind(Acceleration& acceleration, double h) {
    struct Again {};
    bool needed = false;
    const auto checked = [&](double t, const Vector& q, const Vector& v, Vector& a) {
      acceleration(t, q, v, a);
      if (!model_.nearly_dependent()) return;
      needed = true;
      if (!model_.on_constraints()) throw Again();
    };
    double taken;
    try {
      taken = integrate(checked, h);
    } catch (const Again&) {
      model_.stay_on_constraints(true);
      taken = integrate(checked, h);
    }
    model_.stay_on_constraints(needed);
    return taken;
  }

  /// One step of the integrator. Where joints do work it is integrated as a last entry of the
  /// state, v's, with their power as its acceleration: by the same method, and scaled so far down
  /// that a tolerance does not see it.
  template <class Acceleration>
  double integrate(Acceleration& acceleration, double h) {
    if constexpr (Driven<M>) {
      if (model_.is_driven()) {
        constexpr double scale = 0x1p-40;
        const Eigen::Index n = q_.size();
        Vector &x = stage_[0], &x_dot = stage_[1], &q = stage_[2], &v = stage_[3], &a = stage_[4];
        x << q_, 0.0;
        x_dot << v_, 0.0;
        const auto with_power = [&](double t, const Vector& x_t, const Vector& x_dot_t,
                                    Vector& x_ddot) {
          q = x_t.head(n);
          v = x_dot_t.head(n);
          acceleration(t, q, v, a);
          x_ddot << a, scale * model_.power();
        };
        const double taken = integrator_.step(with_power, t_, x, x_dot, h);
        q_ = x.head(n);
        v_ = x_dot.head(n);
        work_ += x_dot[n] / scale;
        return taken;
      }
    }
    return integrator_.step(acceleration, t_, q_, v_, h);
  }

  /// A vector of the size that the integrator works with.
  Vector like() {
    Vector like = model_.initial_position();
    if constexpr (Driven<M>)
      if (model_.is_driven()) {
        stage_.fill(like);
        like.conservativeResize(like.size() + 1);
        stage_[0] = stage_[1] = like;
      }
    return like;
  }

  /// When the acceleration jumps next. Until then it is asked for before that, a rounding earlier
  /// where a step ends there; a step that begins there asks for it behind.
  double next_jump() {
    double jump = std::numeric_limits<double>::infinity();
    if constexpr (requires { model_.next_jump(t_); }) jump = model_.next_jump(t_);
    latest_ = jump < std::numeric_limits<double>::infinity() ? std::nextafter(jump, -jump) : jump;
    return jump;
  }

  /// The name of the first such entry of the state.
  std::string first_not_finite() {
    const Row row = this->row();
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
  std::array<Vector, 5> stage_{};  ///< with work: q, v; without: q, v, a of a stage
  integrators::Integrator<Vector> integrator_;
  Method method_;
  Vector q_, v_;
  double t_, t_anchor_, h_, shortest_step_, latest_ = std::numeric_limits<double>::infinity();
  double work_;  ///< of joints that depend on time [J]
  long intervals_since_anchor_, steps_, evaluations_;
  std::weak_ptr<const std::function<void()>> look_;
  double pace_t_ = 0.0;  ///< where and when the pace was looked at last
  long pace_steps_ = 0;
};

}  // namespace mechanics
