// The global solver. It only organises: it knows where each thing's coordinates stand in q, puts
// the rows of each joint where they belong, and solves equation 1,
//
//   (J W J^T) lambda = - Jdot_v - J W F - ks C - kd J v,      a = W (F + J^T lambda);
//
// for joints that depend on time with - C_tt beside - Jdot_v, and J v + C_t for J v.
//
// Forces stand in forces.cpp, rows that nearly depend on others in weak_rows.cpp, the way back onto
// the constraints in projection.cpp, rates to start with in start_rates.cpp, what is asked of an
// evaluation in evaluation.cpp.
#pragma once

#include <atomic>
#include <concepts>
#include <cstddef>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "mechanics/dynamics/evaluation.hpp"
#include "mechanics/dynamics/force.hpp"
#include "mechanics/dynamics/joint.hpp"
#include "mechanics/dynamics/things.hpp"

namespace dynamics {

/// A number that no other System has, and that goes along when a System is moved.
struct Identity {
  static inline std::atomic<int> last = 0;
  int number = ++last;

  Identity() = default;
  Identity(Identity&& other) noexcept : number(std::exchange(other.number, ++last)) {}
  Identity& operator=(Identity&& other) noexcept {
    number = std::exchange(other.number, ++last);
    return *this;
  }
};

/// How a projection ended: whether C and J v are down to rounding, and the Newton steps it took.
struct Projection {
  bool converged;
  int steps;
};

/// What assemble() found: the largest change of a coordinate (m, rad); the largest |C| and |J v|
/// before it.
struct Assembly {
  bool projected;  ///< false: q was on the constraints already, to rounding, and is left as it was
  double moved, C_before, Jv_before;
};

/// A rate that a thing starts with: of its coordinate 0, 1 or, a body's angle, 2 (m/s, rad/s).
struct Rate {
  template <class Thing>
  Rate(Handle<Thing> thing, int of, double rate)
      : column(thing.column), system(thing.system), coordinate(of), value(rate) {}
  int column, system, coordinate;
  double value;
};

/// The joints cannot be closed, or leave no such rates. what() is one line that names the worst
/// joint and row, or the thing.
struct AssemblyError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A scene: things, joints between them, and applied forces, which add and apply set up. All else
/// is const and leaves it as it is; what an evaluation needs of memory is its own.
/// Whoever passes a q or v of the wrong length, or the handle of another System, gets
/// std::invalid_argument. A number in q or v that is not finite makes the answer NaN, or those
/// accelerations that depend on it: nothing here crashes or loops on it, but who steps a System
/// must look whether its state is finite.
class System {
 public:
  static constexpr Handle<World> world{};

  /// mass in kg, inertia about the centre of mass in kg m^2; x (m), theta (rad), v (m/s), omega
  /// (rad/s): where it starts. std::invalid_argument for a name that another thing has, for a mass
  /// or inertia that is not positive or whose inverse is out of range, and for what is not finite,
  /// the weight included.
  Handle<Particle> add_particle(const std::string& name, double mass, const Vector2d& x,
                                const Vector2d& v = Vector2d::Zero());
  Handle<Body> add_body(const std::string& name, double mass, double inertia, const Vector2d& x,
                        double theta = 0, const Vector2d& v = Vector2d::Zero(), double omega = 0);

  /// Joins first to second. Any type is a joint that has rows(first, second), or, where its
  /// constraint depends on time, rows(t, first, second), which returns the Rows of these two
  /// things, and unit, which names the unit of each row of C. One that also has
  /// fault() says there what is wrong with its parameters, or nullptr. std::invalid_argument for
  /// that, for a name that another joint has, and for rows that cannot be computed at the start.
  template <class Joint, class First, class Second = World>
  JointHandle add(const std::string& name, const Joint& joint, Handle<First> first,
                  Handle<Second> second = world) {
    static_assert(First::dof + Second::dof > 0, "a joint needs a thing that can move");
    using Typed = JointOf<Joint, First, Second>;
    check(name.c_str(), first);
    check(name.c_str(), second);
    if constexpr (requires { joint.fault(); })
      if (const char* fault = joint.fault()) throw std::invalid_argument(name + ": " + fault);
    const auto rows = rows_of(joint, 0.0, at(first, q0_, v0_), at(second, q0_, v0_));
    Eigen::Matrix<double, Typed::r, First::dof + Second::dof> J;
    Eigen::Vector<double, First::dof + Second::dof> W;
    const auto side = [&](const auto& J_thing, int at, int column) {
      constexpr int dof = std::decay_t<decltype(J_thing)>::ColsAtCompileTime;
      J.template middleCols<dof>(at) = J_thing;
      W.template segment<dof>(at) = layout_.W.template segment<dof>(column);
    };
    if constexpr (First::dof > 0) side(rows.J1, 0, first.column);
    if constexpr (Second::dof > 0) side(rows.J2, First::dof, second.column);
    check_rows(name, rows.C, rows.size, J, W);
    depends_on_time_ |= Typed::depends_on_time;
    return add_joint(name, std::make_unique<Typed>(joint, first, second), Typed::r,
                     Joint::unit.data(), {first.column, First::dof}, {second.column, Second::dof});
  }

  /// The thing of a name, and the joint that was added after `number` others;
  /// std::invalid_argument when there is none.
  template <class Thing>
  Handle<Thing> thing(const std::string& name) const {
    const auto found = thing_of_name_.find(name);
    if (found == thing_of_name_.end() || layout_.things[found->second].dof != Thing::dof)
      throw std::invalid_argument(name + ": no thing of this kind has that name");
    const ThingInfo& info = layout_.things[found->second];
    return {info.index, info.column, identity_.number};
  }
  JointHandle joint(int number) const;

  /// A uniform field (m/s^2) that acts on everything; its potential counts in energy().
  void set_gravity(const Vector2d& g);

  /// A constant force and couple from outside: the work it does shows as a change of energy().
  template <class Thing>
  ForceHandle apply(Handle<Thing> thing, const std::type_identity_t<Force<Thing>>& F) {
    check("apply", thing);
    return add_load(thing.column, F);
  }
  /// A force that depends on time and on the thing's own state, with its potential if it has one.
  template <class Thing>
  ForceHandle apply(Handle<Thing> thing, std::type_identity_t<ForceLaw<Thing>> F,
                    std::type_identity_t<Potential<Thing>> V = {}) {
    check("apply", thing);
    laws(thing).push_back({thing, std::move(F), std::move(V), ++forces_});
    return applied();
  }
  /// What two things, or a thing and the world, do to each other: F is what the first gets.
  /// std::invalid_argument for a thing with itself.
  template <class First, class Second>
  ForceHandle apply(Handle<First> first, Handle<Second> second,
                    std::type_identity_t<MutualLaw<First, Second>> F,
                    std::type_identity_t<MutualPotential<First, Second>> V = {}) {
    static_assert(First::dof + Second::dof > 0, "a force needs a thing that can move");
    check_pair(first, second);
    AnyMutualLaw law{[=, F = std::move(F)](double t, const Things& things, VectorXd& forces) {
                       const Push push = F(t, things[first], things[second]);
                       add_push(1, push, things[first], first.column, forces);
                       add_push(-1, push, things[second], second.column, forces);
                     },
                     {},
                     ++forces_};
    if (V)
      law.V = [=, V = std::move(V)](const Things& things) {
        return V(things[first], things[second]);
      };
    mutual_laws_.push_back(std::move(law));
    return applied();
  }
  /// The same of a type that has push(first, second), potential(first, second) and, as a joint,
  /// fault().
  template <class First, class Second, class Forces>
  requires requires(const Forces& forces, const First& first, const Second& second) {
    { forces.push(first, second) } -> std::same_as<Push>;
  }
  ForceHandle apply(Handle<First> first, Handle<Second> second, const Forces& forces) {
    check_pair(first, second);
    if (const char* fault = forces.fault())
      throw std::invalid_argument(name_of(first.column) + " and " + name_of(second.column) + ": " +
                                  fault);
    return apply(
        first, second,
        [=](double, const First& one, const Second& two) { return forces.push(one, two); },
        [=](const First& one, const Second& two) { return forces.potential(one, two); });
  }
  /// Takes back what was applied, as if it had never been. std::invalid_argument when it is gone
  /// already.
  void remove(ForceHandle force);

  /// The gains ks (1/s^2) and kd (1/s) of equation 1, both finite; a term of gain 0 is left out.
  void set_feedback(double ks, double kd);

  /// The state that the things were added with.
  const VectorXd& initial_q() const { return q0_; }
  const VectorXd& initial_v() const { return v0_; }

  /// Equation 1 at time t in state q, v. Where rows are nearly dependent it calls the next one.
  void evaluate(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const;

  /// The same with J, Jdot_v and F of the nearest state on the constraints, where alone rows that
  /// depend on each other agree; C and J v remain those of q, v. At a singular pose that the motion
  /// passes: the limit along the motion.
  void evaluate_on_constraints(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const;

  /// Brings q, then v, back onto the constraints at time t by the least change in the mass metric:
  /// dq = -W J^T (J W J^T)^-1 C until C is rounding, then dv = -W J^T (J W J^T)^-1 (J v + C_t), so
  /// that J v = -C_t. For states that an integrator let drift. One that cannot be improved is left
  /// as it was. e lends its storage, and its factor where it was evaluated near q.
  Projection project(double t, VectorXd& q, VectorXd& v, Evaluation& e) const;

  /// Closes the joints before the first step, from further away than project() can: q, then v.
  /// Throws AssemblyError, and leaves q and v as they were, when they cannot be closed: to
  /// rounding, and to a millionth of the scene, which far from the origin or after many turns is
  /// less.
  Assembly assemble(double t, VectorXd& q, VectorXd& v) const;

  /// The velocities at q that have the given rates and keep the joints, J v = -C_t at time 0: where
  /// that leaves a choice, those of the least kinetic energy. So {{wheel, 2, 10}} turns a crank and
  /// all that follows it. Redundant joints and rates do no harm. AssemblyError, which names the
  /// first thing whose rate cannot be had, and in a singular pose for rates that do not say which
  /// way it is left. Dense: for set-up.
  VectorXd start_rates(const VectorXd& q, const std::vector<Rate>& given) const;

  /// Kinetic energy, and potential energy of gravity and of the laws that gave one (J).
  double energy(const VectorXd& q, const VectorXd& v) const;
  /// Kinetic energy of one thing, or of all (J).
  double kinetic_energy(const ThingInfo& thing, const VectorXd& v) const;
  double kinetic_energy(const VectorXd& v) const;
  /// The applied forces (N, N m), one entry for each coordinate.
  VectorXd forces(double t, const VectorXd& q, const VectorXd& v) const;
  /// Of such forces: sqrt(F^T W F) (N/sqrt(kg)), the rate at which sqrt(2 T) grows at most where
  /// constraint forces do no work; their sizes added up (N), a moment as the force at its body's
  /// radius.
  double drive(const VectorXd& F) const;
  double load(const VectorXd& F) const;
  /// The circle (m) about a body's centre that a uniform rod or rectangle of its inertia fits in,
  /// sqrt(3 I / m); a particle has none.
  double radius(const ThingInfo& thing) const;

  /// The diagonal of W, the inverse masses and inertias (1/kg, 1/(kg m^2)).
  const VectorXd& W() const { return layout_.W; }
  /// A thing as it is in state q, v: to find its points, or to draw it.
  template <class Thing>
  Thing state(Handle<Thing> thing, const VectorXd& q, const VectorXd& v) const {
    check("state", thing);
    check_lengths(q, v);
    return at(thing, q, v);
  }

  int rows() const { return layout_.rows; }
  /// Whether a joint does: it moves things by itself, and does work.
  bool depends_on_time() const { return depends_on_time_; }
  const std::vector<ThingInfo>& things() const { return layout_.things; }

 private:
  friend class Evaluation;
  // The columns of a joint's first or second thing.
  struct Side {
    int column, dof;
  };

  void add_thing(const std::string& name, int index, const VectorXd& mass, const VectorXd& q,
                 const VectorXd& v);
  JointHandle add_joint(const std::string& name, std::unique_ptr<AnyJoint> rows, int r,
                        const char* const* unit, Side first, Side second);
  ForceHandle add_load(int column, const VectorXd& F);
  ForceHandle applied() {
    ++revision_;
    return {forces_, identity_.number};
  }
  auto& laws(Handle<Particle>) { return particle_laws_; }
  auto& laws(Handle<Body>) { return body_laws_; }

  void check(const char* who, JointHandle joint) const;
  template <class Thing>
  void check(const char* who, Handle<Thing> thing) const {
    if constexpr (Thing::dof > 0) check(who, JointHandle{thing.index, thing.system});
  }
  template <class First, class Second>
  void check_pair(Handle<First> first, Handle<Second> second) const {
    check("apply", first);
    check("apply", second);
    if (first.column == second.column)
      throw std::invalid_argument(name_of(first.column) + ": no force acts between a thing and " +
                                  "itself");
  }
  std::string name_of(int column) const {
    return column < 0 ? "world" : thing_at(layout_.things, column).name;
  }
  void check_load(const std::string& name, double mass, const Vector2d& g, const VectorXd& F) const;
  void check_rows(const std::string& name, const VectorXd& C, const VectorXd& size,
                  const Eigen::MatrixXd& J, const VectorXd& W) const;
  void check_lengths(const VectorXd& q, const VectorXd& v) const;

  static World at(Handle<World>, const VectorXd&, const VectorXd&) { return {}; }
  static Particle at(Handle<Particle> p, const VectorXd& q, const VectorXd& v) {
    return {q.segment<2>(p.column), v.segment<2>(p.column)};
  }
  static Body at(Handle<Body> b, const VectorXd& q, const VectorXd& v) {
    const double theta = q[b.column + 2];
    return {q.segment<2>(b.column), v.segment<2>(b.column), theta, v[b.column + 2],
            rotation(theta)};
  }

  Things things_at(const VectorXd& q, const VectorXd& v) const;
  VectorXd weights() const;
  void enter(const VectorXd& q, const VectorXd& v, Evaluation& e) const;
  void find_forces(double t, Evaluation& e) const;
  void find_equation(double t, Evaluation& e) const;
  void find_constraint(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const;
  void set_up(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const;
  void solve_for_a(const VectorXd& q, const VectorXd& v, Evaluation& e) const;
  double speed(const VectorXd& v, const Evaluation& e) const;
  VectorXd times_along(const VectorXd& v, double far, double rest, const Evaluation& e) const;
  bool is_singular_pose(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const;
  bool find_limit(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const;
  void factor_here(double t, Evaluation& e, double damping = 0) const;
  bool project_velocities(double t, VectorXd& v, Evaluation& e) const;

  Identity identity_;
  int revision_ = 1;  // counts what changes the storage of an evaluation
  Layout layout_;
  std::map<std::string, std::size_t> thing_of_name_;
  std::set<std::string> joint_names_;
  std::vector<std::unique_ptr<AnyJoint>> joints_;  // as in layout_.joints
  int particles_ = 0, bodies_ = 0;
  int forces_ = 0;  // counts what was applied
  std::vector<Load> loads_;
  std::vector<Law<Particle>> particle_laws_;
  std::vector<Law<Body>> body_laws_;
  std::vector<AnyMutualLaw> mutual_laws_;

  Vector2d gravity_ = Vector2d::Zero();
  double ks_ = 0, kd_ = 0;
  bool depends_on_time_ = false;
  VectorXd q0_, v0_, constant_;  // one entry a coordinate; constant_: the sum of the loads
};

}  // namespace dynamics
