#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "mechanics/dynamics/system.hpp"
#include "mechanics/motion/motion.hpp"
#include "mechanics/motion/singular_poses.hpp"

namespace mechanics {

/// The work of a damper, for Mechanism::work: it takes energy, how much depends on the way to q.
inline double dissipated(const Eigen::VectorXd&) {
  return std::numeric_limits<double>::quiet_NaN();
}

/// A System as a model of the one loop: what chapters 3 to 7 run. A chapter adds its things, joints
/// and forces to `system`, names the reactions that it reports, and calls `assemble`
/// (or, to start off its constraints, `start_as_given`).
class Mechanism {
 public:
  using Vector = Eigen::VectorXd;
  /// Reads a reaction off the evaluation at q.
  using Reaction = std::function<Eigen::Vector3d(const dynamics::Evaluation&, const Vector& q)>;

  dynamics::System system;

  /// Work [J] of the loads that have no potential, up to state q. Empty: none. Not a number, as
  /// `dissipated` says, where they only take energy and q does not tell how much.
  std::function<double(const Vector& q)> work;

  /// The times [s], in their order, at which a force or a C_tt jumps: a step ends there.
  std::vector<double> jumps;

  explicit Mechanism(const mechanics::Method& method) : ks_(method.ks), kd_(method.kd) {
    system.set_feedback(method.ks, method.kd);
  }

  /// Reports the force [N] and moment [N·m] of a joint on one of its things under a name, NaN
  /// where they are not determined.
  template <class Thing>
  void report(const std::string& name, dynamics::JointHandle joint, dynamics::Handle<Thing> thing) {
    report(name, [=](const dynamics::Evaluation& e, const Vector&) {
      return e.determined_reaction(joint, thing);
    });
  }
  /// The same for a reaction that is no joint's of the system, computed from those that are.
  void report(const std::string& name, Reaction reaction) {
    reactions_.emplace_back(name, std::move(reaction));
  }
  /// A body that is fixed and therefore left out of the system, but stands in the tables all the
  /// same: at the origin, at rest.
  void report_fixed(const std::string& name) { fixed_.push_back(name); }

  /// Starts in the state that the things were added with, off the constraints or not.
  void start_as_given() {
    q_ = system.initial_q();
    v_ = system.initial_v();
  }

  /// Closes the joints before the first step; a start that had to be moved becomes a note. Where
  /// rates are given, they are all that moves, with what follows them; otherwise the velocities of
  /// the things are projected. Throws dynamics::AssemblyError.
  void assemble(const std::vector<dynamics::Rate>& given = {}) {
    start_as_given();
    const dynamics::Assembly assembly = system.assemble(0.0, q_, v_);
    if (!given.empty()) v_ = system.start_rates(q_, given);
    if (assembly.projected)
      notes_.push_back("start: off its constraints by " + in_digits(assembly.C_before) +
                       "; projected onto them, which moved it by " + in_digits(assembly.moved));
    else if (given.empty() && (v_ - system.initial_v()).norm() > 1e-9 * system.initial_v().norm())
      notes_.push_back("start: its velocities broke the constraints by " +
                       in_digits(assembly.Jv_before) + "; projected");
  }

  Vector initial_position() const { return q_; }
  Vector initial_velocity() const { return v_; }
  std::vector<std::string> notes() const {
    std::vector<std::string> notes = notes_;
    for (const std::string& note : poses_.notes()) notes.push_back(note);
    if (left_open_ > 0)
      notes.push_back("projection: " + std::to_string(left_open_) +
                      " times it could not bring the state back onto the constraints");
    return notes;
  }

  bool lost_rank() const { return !poses_.poses().empty(); }

  void acceleration(double t, const Vector& q, const Vector& v, Vector& a) {
    if (on_constraints_)
      system.evaluate_on_constraints(t, q, v, e_);
    else
      system.evaluate(t, q, v, e_);
    a = e_.a();
    nearly_dependent_ = e_.nearly_dependent();
  }
  /// Whether the rows of the last acceleration were nearly dependent; whether accelerations are
  /// those of the nearest state on the constraints.
  bool nearly_dependent() const { return nearly_dependent_; }
  bool on_constraints() const { return on_constraints_; }
  void stay_on_constraints(bool stay) { on_constraints_ = stay; }

  void project(double t, Vector& q, Vector& v) {
    if (!system.project(t, q, v, e_).converged) ++left_open_;
  }
  /// Whether joints do work, and the power [W] that they put in, at the last acceleration.
  bool is_driven() const { return system.depends_on_time(); }
  double power() const { return e_.power(); }
  /// The first of the jumps after t.
  double next_jump(double t) const {
    const auto next = std::upper_bound(jumps.begin(), jumps.end(), t);
    return next == jumps.end() ? std::numeric_limits<double>::infinity() : *next;
  }

  mechanics::Measures measures(double t, const Vector& q, const Vector& v) {
    system.evaluate(t, q, v, e_);
    const Vector F = system.forces(t, q, v);
    return {.energy = system.energy(q, v),
            .constraint_error = e_.constraint_error(),
            .velocity_error = e_.velocity_error(v),
            .work = work ? work(q) : 0.0,
            .kinetic = system.kinetic_energy(v),
            .speed = fastest(v),
            .opening = e_.opening(),
            .load = system.load(F),
            .drive = system.drive(F),
            .power = e_.power()};
  }
  /// Of a driven scene no less than that with constraints, which may be all that there is.
  double free_acceleration(double t, const Vector& q, const Vector& v) {
    const double free = system.W().cwiseProduct(system.forces(t, q, v)).norm();
    if (!is_driven()) return free;
    system.evaluate(t, q, v, e_);
    return std::max(free, e_.a().norm());
  }
  double distance(double t, const Vector& q) {
    system.evaluate(t, q, v_, e_);
    return e_.distance();
  }
  /// A body as the disc about its centre that a uniform rod or rectangle of its inertia just fits.
  void cover(const Vector& q, mechanics::Reach& reach) const {
    for (const dynamics::ThingInfo& thing : system.things())
      reach.cover(q[thing.column], q[thing.column + 1], system.radius(thing));
  }

  /// The last evaluation.
  const dynamics::Evaluation& evaluation() const { return e_; }

  /// The poses that lost rank, as far as `observe` has seen them.
  const std::vector<SingularPoses::Look>& singular_poses() const { return poses_.poses(); }

  /// The thing that moves most and the row that is furthest off, in words.
  std::string culprit(double t, const Vector& q, const Vector& v) {
    const auto& things = system.things();
    const auto moves_less = [&](const dynamics::ThingInfo& a, const dynamics::ThingInfo& b) {
      return system.kinetic_energy(a, v) < system.kinetic_energy(b, v);
    };
    system.evaluate(t, q, v, e_);
    const dynamics::RowState worst = e_.worst_row();
    return "most of it in " + std::max_element(things.begin(), things.end(), moves_less)->name +
           "; furthest off is " + worst.row.joint + " row " + std::to_string(worst.row.row) +
           ", by " + in_digits(std::abs(worst.C)) + " " + worst.unit;
  }

  mechanics::Columns columns() const {
    mechanics::Columns columns;
    const auto add = [&](const std::string& name, bool turns) {
      for (const char* rate : {"", "v"}) {
        columns.state.push_back(name + "." + rate + "x");
        columns.state.push_back(name + "." + rate + "y");
        if (turns) columns.state.push_back(name + (*rate ? ".omega" : ".theta"));
      }
    };
    for (const std::string& name : fixed_) add(name, true);
    for (const dynamics::ThingInfo& thing : system.things()) add(thing.name, thing.dof == 3);
    for (const auto& [name, reaction] : reactions_)
      for (const char* part : {"fx", "fy", "moment"})
        columns.reactions.push_back(name + "." + part);
    return columns;
  }

  mechanics::Uses uses() {
    const dynamics::Counts counts = e_.counts();
    std::vector<std::string> left_out;
    for (const std::string& name : fixed_) left_out.push_back("the " + name);
    const auto& things = system.things();
    if (std::all_of(things.begin(), things.end(), [](const auto& thing) { return thing.dof == 2; }))
      left_out.push_back("angles");
    if (ks_ == 0.0 && kd_ == 0.0) left_out.push_back("feedback");
    return {.things = counts.things,
            .coordinates = counts.coordinates,
            .rows = counts.rows,
            .rank = counts.rank,
            .blocks_of_J = counts.jacobian_blocks,
            .blocks_of_factor = counts.factor_blocks,
            .state_bytes = counts.state_bytes,
            .workspace_bytes = counts.workspace_bytes,
            .left_out = left_out};
  }

  void observe(double t, const Vector& q, const Vector& v, mechanics::Row& row) {
    row.state.assign(6 * fixed_.size(), 0.0);
    for (const dynamics::ThingInfo& thing : system.things())
      for (const Vector* part : {&q, &v})
        for (int i = 0; i < thing.dof; ++i) row.state.push_back((*part)[thing.column + i]);
    poses_.look(t, e_);
    for (const auto& [name, reaction] : reactions_)
      for (const double value : reaction(e_, q)) row.reactions.push_back(value);
  }

 private:
  double fastest(const Vector& v) const {
    double most = 0.0;
    for (const dynamics::ThingInfo& thing : system.things())
      most = std::max(most, v.segment<2>(thing.column).norm());
    return most;
  }

  std::vector<std::pair<std::string, Reaction>> reactions_;
  std::vector<std::string> fixed_, notes_;
  SingularPoses poses_;
  double ks_, kd_;
  long left_open_ = 0;
  bool nearly_dependent_ = false, on_constraints_ = false;
  dynamics::Evaluation e_{system};
  Vector q_, v_;
};

}  // namespace mechanics
