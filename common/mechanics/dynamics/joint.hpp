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

/// Where a joint writes its part of equation 1: its rows of C, of the sizes of C's terms, of
/// Cdot = J v + C_t, of C_t, which nobody writes but joints that depend on time, and of
/// b = -Jdot_v - C_tt - J W F, its diagonal block of J W J^T, and its blocks J1, J2 one behind the
/// other, each column by column.
struct JointPlace {
  double *C, *size, *Cdot, *C_t, *b, *JWJt, *J;
};

/// A joint whose types and sizes are forgotten.
struct AnyJoint {
  virtual ~AnyJoint() = default;
  /// Writes C, J, b and JWJt. W and a = W F have an entry for each coordinate.
  virtual void equation(double t, const Things&, const VectorXd& W, const VectorXd& a,
                        const JointPlace& place) const = 0;
  /// Writes C, its sizes, Cdot and J.
  virtual void constraint(double t, const Things&, const VectorXd& v,
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

  // [equation]
  void equation(double t, const Things& things, const VectorXd& W, const VectorXd& a,
                const JointPlace& place) const override {
    const Rows rows = rows_of(joint, t, things[first], things[second]);
    Eigen::Vector<double, r> b = -rows.Jdot_v;
    if constexpr (depends_on_time) b -= rows.C_tt;
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
  void constraint(double t, const Things& things, const VectorXd& v,
                  const JointPlace& place) const override {
    const Rows rows = rows_of(joint, t, things[first], things[second]);
    Eigen::Vector<double, r> Cdot = rows.C_t;
    if constexpr (First::dof > 0) Cdot += rows.J1.lazyProduct(part(v, first));
    if constexpr (Second::dof > 0) Cdot += rows.J2.lazyProduct(part(v, second));
    Block<r, 1>{place.size} = rows.size;
    Block<r, 1>{place.Cdot} = Cdot;
    write_C_and_J(rows, place);
  }

  template <class Thing>
  static ConstBlock<Thing::dof, 1> part(const VectorXd& x, Handle<Thing> thing) {
    return ConstBlock<Thing::dof, 1>(x.data() + thing.column);
  }
  static void write_C_and_J(const Rows& rows, const JointPlace& place) {
    Block<r, 1>{place.C} = rows.C;
    if constexpr (depends_on_time) Block<r, 1>{place.C_t} = rows.C_t;
    if constexpr (First::dof > 0) Block<r, First::dof>{place.J} = rows.J1;
    constexpr int size_of_J1 = r * First::dof;
    if constexpr (Second::dof > 0) Block<r, Second::dof>{place.J + size_of_J1} = rows.J2;
  }

  Joint joint;
  Handle<First> first;
  Handle<Second> second;
};

}  // namespace dynamics
