// Rates to start with: some are given, the others follow.
#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "mechanics/dynamics/entries.hpp"
#include "mechanics/dynamics/system.hpp"

namespace dynamics {
namespace {

using Eigen::MatrixXd;

/// The rows of J v = -C_t and v_i = given: dense, since this is set-up.
struct Equations {
  MatrixXd A;
  VectorXd b;

  void add(Eigen::Index column, double value) {
    A.conservativeResize(A.rows() + 1, Eigen::NoChange);
    A.bottomRows<1>().setZero();
    A(A.rows() - 1, column) = 1;
    b.conservativeResize(A.rows());
    b[A.rows() - 1] = value;
  }
};

/// 1 / |row| of each row; 1 where that is 0.
VectorXd per_row(const MatrixXd& A) {
  const VectorXd norm = A.rowwise().norm();
  return (norm.array() > 0).select(norm.cwiseInverse(), 1);
}

/// Of all v with A v = b the one of least v^T M v. False when there is none: then a row is off by
/// more than a rate that was given in nine digits can be.
///
/// Rows and columns are scaled to about 1, G = r A c, so that units, levers and masses do not say
/// what depends on what. From G^T P = Q R follows v = c Q R^-T P^T r b, of whose last columns of Q,
/// beyond the rank, any part N z may be added: they are what A leaves free. z is the one for which
/// M^(1/2) (v + N z) is shortest. A second pass takes away the rounding of the first; what rests
/// has only the second's, epsilon^2, and is made to rest.
bool solve(const Equations& equations, const VectorXd& M, VectorXd& v) {
  constexpr double dependent = 1e-12, digits = 1e-9;
  v.setZero(M.size());
  if (equations.b.isZero(0)) return true;
  const double unit = std::exp2(std::ilogb(equations.b.lpNorm<Eigen::Infinity>()));
  const MatrixXd& A = equations.A;
  const VectorXd b = equations.b / unit;  // so that no square overflows
  VectorXd r, c = VectorXd::Ones(M.size());
  for (int sweep = 0; sweep < 4; ++sweep) {
    r = per_row(A * c.asDiagonal());
    c = per_row(A.transpose() * r.asDiagonal());
  }
  Eigen::ColPivHouseholderQR<MatrixXd> qr(c.asDiagonal() * A.transpose() * r.asDiagonal());
  qr.setThreshold(dependent);
  const Eigen::Index rank = qr.rank();
  const auto R = qr.matrixQR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>();
  MatrixXd N = MatrixXd::Identity(M.size(), M.size()).rightCols(M.size() - rank);
  N.applyOnTheLeft(qr.householderQ());
  N = c.asDiagonal() * N;
  const VectorXd root_M = M.cwiseSqrt();
  VectorXd left = b;
  for (int pass = 0; pass < 2; ++pass) {
    const VectorXd right = qr.colsPermutation().transpose() * left.cwiseProduct(r);
    VectorXd x = VectorXd::Zero(M.size());
    x.head(rank) = R.transpose().solve(right.head(rank));
    x.applyOnTheLeft(qr.householderQ());
    v += c.cwiseProduct(x);
    if (N.cols() > 0)
      v -= N * (root_M.asDiagonal() * N).colPivHouseholderQr().solve(root_M.cwiseProduct(v));
    left = b - A * v;
  }
  const double size = v.cwiseQuotient(c).norm();
  v = (v.array().abs() > 64 * epsilon * epsilon * size * c.array()).select(v, 0);
  const VectorXd allowed = digits * (A.cwiseAbs() * v.cwiseAbs() + b.cwiseAbs());
  v *= unit;
  return (left.array().abs() <= allowed.array() + 64 * epsilon * size / r.array()).all();
}

}  // namespace

VectorXd System::start_rates(const VectorXd& q, const std::vector<Rate>& given) const {
  check_lengths(q, q);
  if (!q.allFinite()) throw AssemblyError("cannot start: q must be finite");
  Evaluation e(*this);
  evaluate(0, q, VectorXd::Zero(q.size()), e);
  Equations equations{e.jacobian(), -e.C_t_};
  VectorXd v;
  for (const Rate& rate : given) {
    check("start_rates", JointHandle{0, rate.system});
    const ThingInfo& thing = thing_at(layout_.things, rate.column);
    if (rate.coordinate < 0 || rate.coordinate >= thing.dof)
      throw std::invalid_argument(thing.name + ": has no coordinate " +
                                  std::to_string(rate.coordinate));
    if (!std::isfinite(rate.value))
      throw std::invalid_argument(thing.name + ": its start rates must be finite");
    equations.add(rate.column + rate.coordinate, rate.value);
  }
  if (solve(equations, layout_.M, v)) {
    if (e.singular_) {  // the rates that the joints allow here need not belong to any motion
      Eigen::MatrixXd all =
          Eigen::MatrixXd::Zero(layout_.rows + static_cast<int>(given.size()), q.size());
      all.topRows(layout_.rows) = e.jacobian();
      for (Eigen::Index row = layout_.rows; const Rate& rate : given)
        all(row++, rate.column + rate.coordinate) = 1;
      Eigen::ColPivHouseholderQR<Eigen::MatrixXd> QR(all);
      if (QR.setThreshold(1e-9).rank() < q.size())
        throw AssemblyError(
            "cannot start: in this pose the joints lose rank, and more rates are "
            "needed to tell which way they go");
    }
    for (const Rate& rate : given) v[rate.column + rate.coordinate] = rate.value;
    return v;
  }
  // The first that does not go with those before it.
  equations = {e.jacobian(), -e.C_t_};
  for (const Rate& rate : given) {
    equations.add(rate.column + rate.coordinate, rate.value);
    if (solve(equations, layout_.M, v)) continue;
    constexpr const char* coordinates[] = {"x", "y", "theta"};
    throw AssemblyError("cannot start: the joints" +
                        std::string(&rate == &given.front() ? "" : " and the rates before it") +
                        " do not leave " + thing_at(layout_.things, rate.column).name +
                        " this rate of " + coordinates[rate.coordinate]);
  }
  return v;
}

}  // namespace dynamics
