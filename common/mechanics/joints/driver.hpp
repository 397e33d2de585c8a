// Driver: the angle between two things is a given function of time. A motor that does as it is
// told.
//
//   The angle is f(t).               C      = theta1 - theta2 - f(t)
//   Differentiate.                   Cdot   = w1 - w2 - f'(t)
//   Collect the velocities.          J      = [ 0 0 1 | 0 0 -1 ]
//   What is left has no velocity.    C_t    = -f'(t)
//   Differentiate again.             Jdot_v = 0,   C_tt = -f''(t)            (w is omega)
//
// J^T lambda is lambda itself: the torque of the motor on the first thing. No other joint does
// work; this one puts in lambda (w1 - w2) = -lambda C_t. A jump of f' would take an infinite
// torque, a jump of f'' makes one of the torque.
#pragma once

#include <array>
#include <cmath>

#include "mechanics/dynamics/things.hpp"

namespace joints {

/// A function of time at one time: its value (rad), rate (rad/s) and acceleration (rad/s^2).
struct Given {
  double f, f_dot, f_ddot;
};

/// Turns the first thing, a body, against the second, a body or the world, so that
/// theta1 - theta2 = f(t), where f returns a Given. 1 row, in rad.
template <class Function>
struct Driver {
  static constexpr std::array unit{"rad"};

  Function f;

  // [rows]
  template <class Second>
  dynamics::Rows<1, dynamics::Body, Second> rows(double t, const dynamics::Body& first,
                                                 const Second& second) const {
    using Row = Eigen::Vector<double, 1>;
    const Given given = f(t);
    dynamics::Rows<1, dynamics::Body, Second> rows;
    double theta2 = 0;
    rows.J1 << 0, 0, 1;
    if constexpr (Second::dof > 0) {
      theta2 = second.theta;
      rows.J2 << 0, 0, -1;
    }
    rows.C = Row(first.theta - theta2 - given.f);
    rows.Jdot_v = Row(0);
    rows.C_t = Row(-given.f_dot);
    rows.C_tt = Row(-given.f_ddot);
    rows.size = Row(std::abs(first.theta) + std::abs(theta2) + std::abs(given.f));
    return rows;
  }
  // [rows]
};
template <class Function>
Driver(Function) -> Driver<Function>;

}  // namespace joints
