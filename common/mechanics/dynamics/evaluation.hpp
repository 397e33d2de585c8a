// Equation 1 in one state: what System::evaluate found there.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "mechanics/dynamics/joint.hpp"

namespace dynamics {

class System;

/// A thing's name, where its coordinates begin in q and v, how many they are, 2 or 3, and its place
/// among the things of its kind.
struct ThingInfo {
  std::string name;
  int column, dof, index;
};

/// The thing whose coordinates begin at a column; the things stand in that order.
inline const ThingInfo& thing_at(const std::vector<ThingInfo>& things, int column) {
  return *std::lower_bound(things.begin(), things.end(), column,
                           [](const ThingInfo& thing, int c) { return thing.column < c; });
}

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
  double pivot;  ///< what the rows before it leave of its diagonal entry of K: from 1 to 0, where
                 ///< it depends on them
};

/// What the scene holds. rank and degrees_of_freedom are those of one evaluation.
struct Counts {
  int things, coordinates, rows, rank, degrees_of_freedom;
  int jacobian_blocks;          ///< blocks of J: one for each thing of each joint but the world
  int factor_blocks;            ///< blocks of the lower triangle of J W J^T, with fill
  std::size_t state_bytes;      ///< q and v
  std::size_t workspace_bytes;  ///< all that one evaluation touches besides
};

/// A joint's name, the unit of each of its rows, how many these are, and where they stand.
struct JointInfo {
  std::string name;
  const char* const* unit;
  int r;
  JointPlace at;
};

/// What stands where: things, joints, blocks of J; inertia M of each coordinate and its inverse W.
struct Layout {
  /// The part of J in the rows of one joint and the columns of one thing.
  struct JBlock {
    int joint, r, row, dof, column, J;
  };
  std::vector<ThingInfo> things;
  std::vector<JointInfo> joints;
  std::vector<JBlock> J_blocks;
  VectorXd M, W;
  int rows = 0, size_of_J = 0;

  double radius(int column) const { return std::sqrt(3 * M[column + 2] * W[column]); }
};

/// A value that whoever asks owns; `system.evaluate(t, q, v, e)` fills it, and never allocates once
/// it did so before. It keeps what it was told though the System changes or goes. Its storage also
/// serves System::project, after which there is nothing to ask: std::logic_error, as before the
/// first evaluation.
class Evaluation {
 public:
  /// std::invalid_argument where it is then used with another System.
  explicit Evaluation(const System& system);

  /// The accelerations (m/s^2, rad/s^2), one for each coordinate.
  const VectorXd& a() const { return checked().a_; }
  /// C of all rows, in the order in which the joints were added, each in its own unit.
  const VectorXd& C() const { return checked().C_; }
  /// lambda of a joint's rows, and the joint's part of J^T lambda on one of its things: (fx, fy) in
  /// N and the moment in N m about the centre of mass (0 for a particle).
  VectorXd lambda(JointHandle joint) const;
  template <class Thing>
  Vector3d reaction(JointHandle joint, Handle<Thing> thing) const {
    if constexpr (Thing::dof > 0) check("reaction", {thing.index, thing.system});
    return reaction(joint, thing.column);
  }

  /// The same with NaN for the parts that are not determined: those of rows that depend on others,
  /// and in a singular pose of all that could take their place.
  template <class Thing>
  Vector3d determined_reaction(JointHandle joint, Handle<Thing> thing) const {
    const Vector3d all = reaction(joint, thing);
    return all + undetermined(joint, thing.column);
  }

  /// The power (W) that joints which depend on time put in, -lambda . C_t: all others do no work.
  double power() const { return -checked().lambda_.dot(C_t_); }

  /// The largest |C| of all rows, each in its own unit; the largest |J v + C_t| there.
  double constraint_error() const;
  double velocity_error(const VectorXd& v) const;
  /// sqrt(C^T K^-1 C), the distance to the constraints in the mass metric (m sqrt(kg)).
  double distance() const;
  /// How far the joint that is furthest open gapes (m): the way by which a Newton step for each row
  /// alone brings its points back, or turns its things, in the mass metric, times their radius.
  double opening() const;
  /// The whole J. To look at; it allocates.
  Eigen::MatrixXd jacobian() const;

  /// Whether rows are so nearly dependent that this was answered on the constraints: an integrator
  /// should then ask there in all stages of its step. Whether it is the limit along the motion.
  bool nearly_dependent() const { return checked().nearly_dependent_; }
  bool is_limit() const { return checked().limit_; }

  Counts counts() const;
  /// The rows that depend on others, and so have no load.
  std::vector<JointRow> dependent_rows() const;
  /// The row that is off by most, as the mass metric compares them, and the one that is closest to
  /// depending on others. std::logic_error without joints.
  RowState worst_row() const;
  RowState weakest_row() const;

 private:
  friend class System;
  // Blocks of J of two joints a, b in the same columns: J_a W J_b^T adds to a block of K.
  struct Pair {
    int r_a, r_b, dof, column, J_a, J_b, K;
  };

  // A row that the factor set aside, and what is left of it beside all others: the combination y of
  // rows that moves nothing which those hold, and its gradient g = J^T y.
  struct WeakRow {
    int row;
    VectorXd y, g;
    double independence, pivot;

    // Less than a thousandth is left, by geometry.
    bool is_close() const { return g.size() > 0 && independence < 1e-3; }
    // And by the pivot. By the pivot alone less is left where masses differ much, by geometry alone
    // in a long chain: there is nothing to be careful about.
    bool is_delicate() const { return is_close() && pivot < 1e-4; }
  };
  // Of each row, the size of its gradient in the places and in the angles; the size of the scene
  // (m).
  struct Geometry {
    VectorXd J_x, J_theta;
    double size;

    double part(const VectorXd& x, Eigen::Index k) const;
    double largest_part(const VectorXd& x, const VectorXd& y) const;
  };

  const Evaluation& checked() const {
    if (!solved_) refuse();
    return *this;
  }
  [[noreturn]] static void refuse();
  void check(const char* who, JointHandle handle) const;
  Vector3d reaction(JointHandle joint, int column) const;
  Vector3d undetermined(JointHandle joint, int column) const;
  Vector3d reaction_of(const VectorXd& rows, int joint, int column) const;
  RowState row_state(Eigen::Index row) const;

  void analyse(const System& system);
  template <class F>
  void for_each_block_of_J(F&& f) const;
  void add_J(double sign, const VectorXd& x, VectorXd& y) const;
  void add_Jt(const VectorXd& y, VectorXd& x) const;
  void factor(double damping = 0);
  Equation equation() {
    return {C_.data(), size_.data(),  Cdot_.data(), C_t_.data(),
            b_.data(), K_.K().data(), J_.data()};
  }

  void find_weak_rows();
  bool closed() const;
  int nearly_dependent_rows() const;
  bool wholly_dependent() const;
  int left_out() const { return static_cast<int>(weak_.size() - kept_); }
  void clear_of_strong(WeakRow& weak);
  void clear_of(const WeakRow& kept, WeakRow& weak) const;
  double left_of(const WeakRow& weak) const;
  double speed(int column, int dof, const VectorXd& v) const;
  double independence(Eigen::Index row) const;
  void solve(VectorXd& b, VectorXd& F);

  void correct(const VectorXd& error, VectorXd& x);
  double residual(const VectorXd& x) const;
  void find_metric();
  void measure_rounding(double start);
  double relative_error() const;
  double tolerance() const;
  Geometry geometry() const;
  [[noreturn]] void refuse(Eigen::Index open_row) const;
  void check_closed() const;

  int system_ = 0, revision_ = 0;  // for which its storage was laid out
  Layout layout_;
  Things things_;
  std::vector<Pair> pairs_;
  BlockLdlt K_;
  std::vector<WeakRow> weak_;  // those that are kept, then those that are left out
  std::size_t kept_ = 0;
  std::vector<int> redundant_;  // where limit_: rows that depend on others beside the pose too
  Geometry geometry_;           // of the last state with weak rows
  double rounding_ = 0;         // of C there, as a part of the scene
  double nan_of_state_ = 0;     // NaN where an entry of the last state is not finite, else 0
  double largest_W_theta_ = 0;  // infinite where there are particles
  bool nearly_dependent_ = false, singular_ = false,
       limit_ = false;     // where a and lambda are the limits along v
  bool factored_ = false;  // K_ is that of some state
  bool solved_ = false;    // all is that of one state
  int dof_ = 0;            // of all things; 0 where they differ

  VectorXd a_, F0_, F_, q_;  // one entry a coordinate
  VectorXd C_, C_t_, size_, per_size_, per_root_K_, b_, Cdot_, lambda_, mu_, x_;  // one entry a row
  VectorXd J_;  // the blocks of J, one behind the other
};

}  // namespace dynamics
