// A joint of any type between any two things, as the solver sees it: one call does all that
// concerns this joint alone, where its sizes are known to the compiler.
#pragma once

#include <cstddef>
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

/// Everything that is not the world, kind by kind, in one state.
template <class Thing>
struct Slot {
  Thing thing;
  int column;
};
struct Things {
  std::vector<Slot<Particle>> particles;
  std::vector<Slot<Body>> bodies;

  World operator[](Handle<World>) const { return {}; }
  const Particle& operator[](Handle<Particle> p) const {
    return particles[std::size_t(p.index)].thing;
  }
  const Body& operator[](Handle<Body> b) const { return bodies[std::size_t(b.index)].thing; }
};

/// Equation 1 as flat arrays: C, the sizes of its terms, Cdot = J v + C_t, C_t, which nobody writes
/// but joints that depend on time, b = -Jdot_v - C_tt - J W F, the blocks of J W J^T, and those of
/// J.
struct Equation {
  double *C, *size, *Cdot, *C_t, *b, *JWJt, *J;
};
/// Where in these a joint writes: its first row, its diagonal block of J W J^T, and its blocks J1,
/// J2 one behind the other, each column by column.
struct JointPlace {
  int row, K, J;
};

/// A joint whose types and sizes are forgotten.
struct AnyJoint {
  virtual ~AnyJoint() = default;
  /// Writes C, J, b and JWJt. W and F have an entry for each coordinate.
  virtual void equation(double t, const Things&, const VectorXd& W, const VectorXd& F,
                        const Equation& all, const JointPlace& place) const = 0;
  /// Writes C, its sizes, Cdot and J.
  virtual void constraint(double t, const Things&, const VectorXd& v, const Equation& all,
                          const JointPlace& place) const = 0;
};

/// The rows of a joint, which asks for the time if its constraint depends on it.
template <class Joint, class First, class Second>
auto rows_of(const Joint& joint, double t, const First& first, const Second& second) {
  if constexpr (requires { joint.rows(t, first, second); })
    return joint.rows(t, first, second);
  else
    return joint.rows(first, second);
}

template <class Joint, class First, class Second>
struct JointOf final : AnyJoint {
  using Rows = decltype(rows_of(std::declval<Joint>(), 0.0, First(), Second()));
  static constexpr int r = Rows::r;
  static constexpr bool depends_on_time =
      requires(const Joint& j, const First& f, const Second& s) {
    j.rows(0.0, f, s);
  };

  JointOf(Joint j, Handle<First> f, Handle<Second> s) : joint(std::move(j)), first(f), second(s) {}

  [[gnu::flatten]] void equation(double t, const Things& things, const VectorXd& W,
                                 const VectorXd& F, const Equation& all,
                                 const JointPlace& place) const override {
    const Rows rows = rows_of(joint, t, things[first], things[second]);
    Eigen::Vector<double, r> b = -rows.Jdot_v;
    if constexpr (depends_on_time) b -= rows.C_tt;
    Eigen::Matrix<double, r, r> JWJt = Eigen::Matrix<double, r, r>::Zero();
    const auto add = [&](const auto& J, int column) {  // column by column, J W is never stored
      for (int k = 0; k < std::decay_t<decltype(J)>::ColsAtCompileTime; ++k) {
        const Eigen::Vector<double, r> JW = J.col(k) * W[column + k];
        for (int j = 0; j < r; ++j) JWJt.col(j) += JW * J(j, k);
        b -= JW * F[column + k];
      }
    };
    if constexpr (First::dof > 0) add(rows.J1, first.column);
    if constexpr (Second::dof > 0) add(rows.J2, second.column);
    Block<r, 1>{all.b + place.row} = b;
    Block<r, r>{all.JWJt + place.K} = JWJt;
    write_C_and_J(rows, all, place);
  }
  [[gnu::flatten]] void constraint(double t, const Things& things, const VectorXd& v,
                                   const Equation& all, const JointPlace& place) const override {
    const Rows rows = rows_of(joint, t, things[first], things[second]);
    Eigen::Vector<double, r> Cdot = rows.C_t;
    if constexpr (First::dof > 0) Cdot += rows.J1.lazyProduct(part(v, first));
    if constexpr (Second::dof > 0) Cdot += rows.J2.lazyProduct(part(v, second));
    Block<r, 1>{all.size + place.row} = rows.size;
    Block<r, 1>{all.Cdot + place.row} = Cdot;
    write_C_and_J(rows, all, place);
  }

  template <class Thing>
  static ConstBlock<Thing::dof, 1> part(const VectorXd& x, Handle<Thing> thing) {
    return ConstBlock<Thing::dof, 1>(x.data() + thing.column);
  }
  static void write_C_and_J(const Rows& rows, const Equation& all, const JointPlace& place) {
    Block<r, 1>{all.C + place.row} = rows.C;
    if constexpr (depends_on_time) Block<r, 1>{all.C_t + place.row} = rows.C_t;
    double* const J2 = all.J + place.J + r * First::dof;
    if constexpr (First::dof > 0) Block<r, First::dof>{all.J + place.J} = rows.J1;
    if constexpr (Second::dof > 0) Block<r, Second::dof>{J2} = rows.J2;
  }

  Joint joint;
  Handle<First> first;
  Handle<Second> second;
};

}  // namespace dynamics
