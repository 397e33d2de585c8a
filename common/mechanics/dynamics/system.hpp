// The global solver. It only organises: it knows where each thing's coordinates stand in q, puts
// the rows of each joint where they belong, and solves equation 1,
//
//   (J W J^T) lambda = - Jdot_v - J W F - ks C - kd J v,      a = W (F + J^T lambda).
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "mechanics/dynamics/block_ldlt.hpp"
#include "mechanics/dynamics/things.hpp"

namespace dynamics {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// A thing of a System. column: where its coordinates begin in q and v; the world has none. A
/// handle comes from its System, knows it, and is refused by all others.
template <class Thing>
struct Handle {
  int index = -1, column = -1, system = 0;
};
struct JointHandle {
  int index = -1, system = 0;
};

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

/// An applied force: (fx, fy) in N at the centre of mass and, on a body, the moment in N m.
template <class Thing>
using Force = Eigen::Vector<double, Thing::dof>;
template <class Thing>
using ForceLaw = std::function<Force<Thing>(double t, const Thing&)>;
/// The potential energy (J) that belongs to a force law.
template <class Thing>
using Potential = std::function<double(const Thing&)>;

/// Everything that is not the world, kind by kind, with the forces on it.
template <class Thing>
struct Kind {
  struct Slot {
    Thing thing;
    int column;
  };
  struct Law {
    Handle<Thing> handle;
    ForceLaw<Thing> F;
    Potential<Thing> V;
  };
  std::vector<Slot> slots;
  std::vector<Law> laws;
};

struct Things {
  Kind<Particle> particles;
  Kind<Body> bodies;

  World operator[](Handle<World>) const { return {}; }
  const Particle& operator[](Handle<Particle> p) const {
    return particles.slots[std::size_t(p.index)].thing;
  }
  const Body& operator[](Handle<Body> b) const { return bodies.slots[std::size_t(b.index)].thing; }
};

/// Where a joint writes its part of equation 1: its rows of C, of the sizes of C's terms, of J v
/// and of b = -Jdot_v - J W F, its diagonal block of J W J^T, and its blocks J1, J2 one behind the
/// other, each column by column.
struct JointPlace {
  double *C, *size, *Jv, *b, *JWJt, *J;
};

/// A joint of any type between any two things, for the solver: one call does all that concerns
/// this joint alone, where its sizes are known to the compiler.
struct AnyJoint {
  virtual ~AnyJoint() = default;
  /// Writes C, J, b and JWJt. W and a = W F have an entry for each coordinate.
  virtual void equation(const Things&, const VectorXd& W, const VectorXd& a,
                        const JointPlace& place) const = 0;
  /// Writes C, its sizes, J v and J.
  virtual void constraint(const Things&, const VectorXd& v, const JointPlace& place) const = 0;
};

template <class Joint, class First, class Second>
struct JointOf final : AnyJoint {
  using Rows = decltype(std::declval<Joint>().rows(First(), Second()));
  static constexpr int r = Rows::r;

  JointOf(Joint j, Handle<First> f, Handle<Second> s) : joint(std::move(j)), first(f), second(s) {}

  // [equation]
  void equation(const Things& things, const VectorXd& W, const VectorXd& a,
                const JointPlace& place) const override {
    const Rows rows = joint.rows(things[first], things[second]);
    Eigen::Vector<double, r> b = -rows.Jdot_v;
    Eigen::Matrix<double, r, r> JWJt = Eigen::Matrix<double, r, r>::Zero();
    const auto add = [&](const auto& J, int column) {
      constexpr int dof = std::decay_t<decltype(J)>::ColsAtCompileTime;
      const Eigen::Vector<double, dof> W_thing = ConstBlock<dof, 1>(W.data() + column);
      const Eigen::Matrix<double, r, dof> JW = J * W_thing.asDiagonal();
      JWJt += JW.lazyProduct(J.transpose());
      b -= J.lazyProduct(ConstBlock<dof, 1>(a.data() + column));
    };
    if constexpr (First::dof > 0) add(rows.J1, first.column);
    if constexpr (Second::dof > 0) add(rows.J2, second.column);
    Block<r, 1>{place.b} = b;
    Block<r, r>{place.JWJt} = JWJt;
    write_C_and_J(rows, place);
  }
  // [equation]
  void constraint(const Things& things, const VectorXd& v, const JointPlace& place) const override {
    const Rows rows = joint.rows(things[first], things[second]);
    Eigen::Vector<double, r> Jv = Eigen::Vector<double, r>::Zero();
    if constexpr (First::dof > 0) Jv += rows.J1.lazyProduct(part(v, first));
    if constexpr (Second::dof > 0) Jv += rows.J2.lazyProduct(part(v, second));
    Block<r, 1>{place.size} = rows.size;
    Block<r, 1>{place.Jv} = Jv;
    write_C_and_J(rows, place);
  }

  template <class Thing>
  static ConstBlock<Thing::dof, 1> part(const VectorXd& x, Handle<Thing> thing) {
    return ConstBlock<Thing::dof, 1>(x.data() + thing.column);
  }
  static void write_C_and_J(const Rows& rows, const JointPlace& place) {
    Block<r, 1>{place.C} = rows.C;
    if constexpr (First::dof > 0) Block<r, First::dof>{place.J} = rows.J1;
    constexpr int size_of_J1 = r * First::dof;
    if constexpr (Second::dof > 0) Block<r, Second::dof>{place.J + size_of_J1} = rows.J2;
  }

  Joint joint;
  Handle<First> first;
  Handle<Second> second;
};

/// A thing's name, where its coordinates begin in q and v, how many they are, 2 or 3, and its place
/// among the things of its kind.
struct ThingInfo {
  std::string name;
  int column, dof, index;
};

/// A row of a joint, counted from 1.
struct JointRow {
  std::string joint;
  int row;
};

/// How far a row is from holding, and how far it is from depending on others.
struct RowState {
  JointRow row;
  const char* unit;  ///< of C
  double C;
  double pivot;  ///< what the rows before it leave of it in the factor: from 1, independent, to 0
};

/// What the scene holds. rank and degrees_of_freedom are those of the last acceleration().
struct Counts {
  int things, coordinates, rows, rank, degrees_of_freedom;
  int jacobian_blocks;          ///< blocks of J: one for each thing of each joint but the world
  int factor_blocks;            ///< blocks of the lower triangle of J W J^T, with fill
  std::size_t state_bytes;      ///< q and v
  std::size_t workspace_bytes;  ///< all that one evaluation touches besides
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

/// The joints cannot be closed. what() is one line that names the worst joint and row.
struct AssemblyError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A scene: things, joints between them, and applied forces. Set it up with add and apply; the
/// first evaluation then fixes its storage, and none of those after it allocates.
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

  /// Joins first to second. Any type is a joint that has rows(first, second), which returns the
  /// Rows of these two things, and unit, which names the unit of each row of C. One that also has
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
    const auto rows = joint.rows(at(first, q0_, v0_), at(second, q0_, v0_));
    Eigen::Matrix<double, Typed::r, First::dof + Second::dof> J;
    Eigen::Vector<double, First::dof + Second::dof> W;
    const auto side = [&](const auto& J_thing, int at, int column) {
      constexpr int dof = std::decay_t<decltype(J_thing)>::ColsAtCompileTime;
      J.template middleCols<dof>(at) = J_thing;
      W.template segment<dof>(at) = W_.template segment<dof>(column);
    };
    if constexpr (First::dof > 0) side(rows.J1, 0, first.column);
    if constexpr (Second::dof > 0) side(rows.J2, First::dof, second.column);
    check_rows(name, rows.C, rows.size, J, W);
    return add_joint(name, std::make_unique<Typed>(joint, first, second), Typed::r,
                     Joint::unit.data(), {first.column, First::dof}, {second.column, Second::dof});
  }

  /// The thing of a name, and the joint that was added after `number` others;
  /// std::invalid_argument when there is none.
  template <class Thing>
  Handle<Thing> thing(const std::string& name) const {
    const auto found = thing_of_name_.find(name);
    if (found == thing_of_name_.end() || thing_info_[found->second].dof != Thing::dof)
      throw std::invalid_argument(name + ": no thing of this kind has that name");
    const ThingInfo& info = thing_info_[found->second];
    return {info.index, info.column, identity_.number};
  }
  JointHandle joint(int number) const;

  /// A uniform field (m/s^2) that acts on everything; its potential counts in energy().
  void set_gravity(const Vector2d& g);

  /// A constant force and couple from outside: the work it does shows as a change of energy().
  template <class Thing>
  void apply(Handle<Thing> thing, const std::type_identity_t<Force<Thing>>& F) {
    check("apply", thing);
    add_load(thing.column, F);
  }
  /// A force that depends on time and on the thing's own state, with its potential if it has one.
  template <class Thing>
  void apply(Handle<Thing> thing, std::type_identity_t<ForceLaw<Thing>> F,
             std::type_identity_t<Potential<Thing>> V = {}) {
    check("apply", thing);
    laws(thing).push_back({thing, std::move(F), std::move(V)});
  }

  /// The gains ks (1/s^2) and kd (1/s) of equation 1, both finite; a term of gain 0 is left out.
  void set_feedback(double ks, double kd);

  /// The state that the things were added with.
  const VectorXd& initial_q() const { return q0_; }
  const VectorXd& initial_v() const { return v0_; }

  /// Equation 1: the accelerations a at time t in state q, v. a is given its length.
  void acceleration(double t, const VectorXd& q, const VectorXd& v, VectorXd& a);

  /// Of the last acceleration(): lambda of a joint's rows, and the joint's part of J^T lambda on
  /// one of its things: (fx, fy) in N and the moment in N m about the centre of mass (0 for a
  /// particle). Like all that is of the last acceleration(), std::logic_error before the first,
  /// after a change of the scene, and after project, assemble, distance, constraint_error,
  /// velocity_error and jacobian, which evaluate the joints elsewhere.
  VectorXd lambda(JointHandle joint) const;
  template <class Thing>
  Vector3d reaction(JointHandle joint, Handle<Thing> thing) const {
    check("reaction", thing);
    return reaction(joint, thing.column);
  }

  /// Brings q, then v, back onto the constraints by the least change in the mass metric:
  /// dq = -W J^T (J W J^T)^-1 C until C is rounding, then dv = -W J^T (J W J^T)^-1 J v. For states
  /// that an integrator let drift. One that cannot be improved is left as it was.
  Projection project(VectorXd& q, VectorXd& v);

  /// Closes the joints before the first step, from further away than project() can: q, then v.
  /// Throws AssemblyError, and leaves q and v as they were, when they cannot be closed: to
  /// rounding, and to a millionth of the scene, which far from the origin or after many turns is
  /// less.
  Assembly assemble(VectorXd& q, VectorXd& v);

  /// Kinetic energy, and potential energy of gravity and of the laws that gave one (J).
  double energy(const VectorXd& q, const VectorXd& v);
  /// Kinetic energy of one thing, or of all (J).
  double kinetic_energy(const ThingInfo& thing, const VectorXd& v) const;
  double kinetic_energy(const VectorXd& v) const;
  /// sqrt(F^T W F) of the applied forces (N/sqrt(kg)): the rate at which sqrt(2 T) grows at most,
  /// since constraint forces do no work.
  double drive(double t, const VectorXd& q, const VectorXd& v);
  /// The sizes of the applied forces added up (N), a moment as the force at its body's radius.
  double load(double t, const VectorXd& q, const VectorXd& v);
  /// |W F| of the applied forces: the size of the terms that cancel in an acceleration.
  double free_acceleration(double t, const VectorXd& q, const VectorXd& v);
  /// sqrt(C^T K^-1 C), the distance to the constraints in the mass metric (m sqrt(kg)).
  double distance(const VectorXd& q);
  /// How far the joint that is furthest open gapes (m): the way by which a Newton step for each row
  /// alone brings its points back, or turns its things, in the mass metric, times their radius.
  double opening(const VectorXd& q);
  /// The circle (m) about a body's centre that a uniform rod or rectangle of its inertia fits in,
  /// sqrt(3 I / m); a particle has none.
  double radius(const ThingInfo& thing) const;
  /// The largest |C| of all rows, each in its own unit.
  double constraint_error(const VectorXd& q);
  /// The largest |J v|.
  double velocity_error(const VectorXd& q, const VectorXd& v);

  /// The whole J, rows in the order in which the joints were added. To look at; it allocates.
  Eigen::MatrixXd jacobian(const VectorXd& q);
  /// The diagonal of W, the inverse masses and inertias (1/kg, 1/(kg m^2)).
  const VectorXd& W() const { return W_; }
  /// A thing as it is in state q, v: to find its points, or to draw it.
  template <class Thing>
  Thing state(Handle<Thing> thing, const VectorXd& q, const VectorXd& v) const {
    check("state", thing);
    check_lengths(q, v);
    return at(thing, q, v);
  }

  Counts counts() const;
  int rows() const { return static_cast<int>(C_.size()); }
  /// The rows that the last acceleration() found to depend on others, and so gave no load.
  std::vector<JointRow> dependent_rows() const;
  /// Of the last acceleration(): the row that is off by most, as the mass metric compares them,
  /// and the one that is closest to depending on others. std::logic_error without joints.
  RowState worst_row() const;
  RowState weakest_row() const;
  const std::vector<ThingInfo>& things() const { return thing_info_; }

 private:
  // The columns of a joint's first or second thing.
  struct Side {
    int column, dof;
  };
  struct Joint {
    std::string name;
    std::unique_ptr<AnyJoint> rows;
    const char* const* unit;
    int r, row, J, K;  // its number of rows, the first of them, where its blocks of J and K begin
  };
  // The part of J in the rows of one joint and the columns of one thing.
  struct JBlock {
    int joint, r, row, dof, column, J;
  };
  // Blocks of J of two joints a, b in the same columns: J_a W J_b^T adds to a block of K.
  struct Pair {
    int r_a, r_b, dof, column, J_a, J_b, K;
  };

  void add_thing(const std::string& name, int index, const VectorXd& mass, const VectorXd& q,
                 const VectorXd& v);
  JointHandle add_joint(const std::string& name, std::unique_ptr<AnyJoint> rows, int r,
                        const char* const* unit, Side first, Side second);
  void add_load(int column, const VectorXd& F);
  auto& laws(Handle<Particle>) { return things_.particles.laws; }
  auto& laws(Handle<Body>) { return things_.bodies.laws; }

  void check(const char* who, JointHandle joint) const;
  template <class Thing>
  void check(const char* who, Handle<Thing> thing) const {
    if constexpr (Thing::dof > 0) check(who, JointHandle{thing.index, thing.system});
  }
  void check_load(const std::string& name, double mass, const Vector2d& g, const VectorXd& F) const;
  void check_rows(const std::string& name, const VectorXd& C, const VectorXd& size,
                  const Eigen::MatrixXd& J, const VectorXd& W) const;
  void check_lengths(const VectorXd& q, const VectorXd& v) const;
  void check_solved() const;

  static World at(Handle<World>, const VectorXd&, const VectorXd&) { return {}; }
  static Particle at(Handle<Particle> p, const VectorXd& q, const VectorXd& v) {
    return {q.segment<2>(p.column), v.segment<2>(p.column)};
  }
  static Body at(Handle<Body> b, const VectorXd& q, const VectorXd& v) {
    const double theta = q[b.column + 2];
    return {q.segment<2>(b.column), v.segment<2>(b.column), theta, v[b.column + 2],
            rotation(theta)};
  }

  void prepare();
  void evaluate(const VectorXd& q, const VectorXd& v);
  void load(const VectorXd& q, const VectorXd& v);
  void find_forces(double t, const VectorXd& q, const VectorXd& v);
  JointPlace place(const Joint& joint);
  template <class F>
  void for_each_block_of_J(F&& f) const;
  void find_equation();
  void factor(double damping = 0);
  void factor_here(double damping = 0);
  void add_J(double sign, const VectorXd& x, VectorXd& y) const;
  void add_Jt(const VectorXd& y, VectorXd& x) const;
  void correct(const VectorXd& error, VectorXd& x);
  double residual(const VectorXd& x) const;
  void find_metric();
  void measure_rounding(double start);
  double relative_error() const;
  bool project_velocities(VectorXd& v);
  double radius_at(int column) const;
  void check_closed(const VectorXd& q) const;
  [[noreturn]] void refuse(Eigen::Index open_row) const;
  Vector3d reaction(JointHandle joint, int column) const;
  RowState row_state(Eigen::Index row) const;

  Identity identity_;
  Things things_;
  std::vector<ThingInfo> thing_info_;
  std::map<std::string, std::size_t> thing_of_name_;
  std::set<std::string> joint_names_;
  std::vector<Joint> joints_;
  std::vector<JBlock> J_blocks_;
  std::vector<Pair> pairs_;
  BlockLdlt K_;

  Vector2d gravity_ = Vector2d::Zero();
  double ks_ = 0, kd_ = 0;
  bool ready_ = false, factored_ = false;
  bool solved_ = false;  // C_, J_, lambda_ and K_ are those of one acceleration()
  int dof_ = 0;          // of all things; 0 where they differ

  VectorXd q0_, v0_, M_, W_, constant_, F0_, F_, a_, q_;              // one entry a coordinate
  VectorXd C_, size_, per_size_, per_root_K_, b_, Jv_, lambda_, mu_;  // one entry a row
  VectorXd J_;  // the blocks of J, one behind the other
};

}  // namespace dynamics
