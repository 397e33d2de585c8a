// What a vector's entries say of it, where none of them may hide another that is not a number.
#pragma once

#include <Eigen/Core>
#include <limits>

namespace dynamics {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// The largest |x_k|: NaN where one is, 0 where there are none.
inline double largest(const Eigen::VectorXd& x) {
  return x.size() == 0 ? 0 : x.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

/// 0, or NaN where an entry is not finite: to be added to what must not hide that.
inline double nan_of(const Eigen::VectorXd& x) {
  double sum = 0;
  for (const double entry : x) sum += 0 * entry;
  return sum;
}

}  // namespace dynamics
