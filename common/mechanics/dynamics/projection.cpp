// Back onto the constraints: projection of a state that drifted, and assembly of one that never was
// on them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string_view>
#include <utility>

#include "mechanics/dynamics/entries.hpp"
#include "mechanics/dynamics/system.hpp"

namespace dynamics {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

}  // namespace

// The largest |x_k| / sqrt(K_kk). The root carries the row's units, so rows of all units compare.
double Evaluation::residual(const VectorXd& x) const {
  return x.size() == 0 ? 0 : x.cwiseProduct(per_root_K_).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

// Takes down 1 / sqrt(K_kk), the measure of each row; 0 for a row that nothing can move.
void Evaluation::find_metric() {
  for (Eigen::Index k = 0; k < per_root_K_.size(); ++k)
    per_root_K_[k] = 1 / std::sqrt(K_.diagonal()[k] > 0 ? K_.diagonal()[k] : infinity);
}

// Takes down how large C may be by rounding: about epsilon times the terms that it is the
// difference of. Where these are 0, say for a wheel at the origin, what a correction of C from
// `start` leaves there by its own rounding counts instead.
void Evaluation::measure_rounding(double start) {
  per_size_ = (size_.array() + start * K_.diagonal().array().sqrt())
                  .max(std::numeric_limits<double>::min())
                  .inverse();
}

// The largest |C| in these terms: about epsilon, whatever the units, when C is rounding.
double Evaluation::relative_error() const {
  return C_.size() == 0 ? 0 : C_.cwiseProduct(per_size_).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

// What may be left of errors that are rounding. A combination of rows of which s is left is known
// to rounding over s, and its rate over s^2.
double Evaluation::tolerance() const { return nearly_dependent_rows() > 0 ? 1e-10 : 16 * epsilon; }

// x -= W J^T K^-1 error
void Evaluation::correct(const VectorXd& error, VectorXd& x) {
  x_ = error;
  F_.setZero();
  solve(x_, F_);
  x -= layout_.W.cwiseProduct(F_);
}

// The factor of K where it is not known yet, in the state that was looked at last. Nobody asks for
// b.
void System::factor_here(double t, Evaluation& e, double damping) const {
  find_equation(t, e);
  e.factor(damping);
}

// Needs J and Cdot at t, q, v, and a factor of K from near them; one from q itself is made when
// that is not enough. Cdot of a row is compared, through sqrt(K_kk), with the velocity in the mass
// metric.
bool System::project_velocities(double t, VectorXd& v, Evaluation& e) const {
  const double smallest = std::sqrt(std::numeric_limits<double>::min());  // with an energy above 0
  const double before = kinetic_energy(v);
  for (int pass = 1;;
       ++pass) {  // one is always made: in this metric a light thing's error is small
    e.correct(e.Cdot_, v);
    e.Cdot_ = e.C_t_;
    e.add_J(1, v, e.Cdot_);
    const double rounding = epsilon * std::sqrt(2 * kinetic_energy(v));
    const double error = e.residual(e.Cdot_);
    if (error <= std::max(rounding, smallest)) return true;
    if (pass == 3)  // of a scene that is brought to rest, the rounding of what it had
      return error <= (e.nearly_dependent_rows() > 0 ? 1e-8 : e.tolerance()) *
                          std::sqrt(2 * std::max(kinetic_energy(v), before));
    if (pass == 1) factor_here(t, e);
  }
}

Projection System::project(double t, VectorXd& q, VectorXd& v, Evaluation& e) const {
  find_constraint(t, q, v, e);
  // One factor serves all steps: that of the acceleration before, from very near q, or else one
  // from q itself. It is renewed when they converge slowly; when that does not help either, C is at
  // its rounding or cannot be closed.
  bool renewed = !e.factored_;
  if (renewed) factor_here(t, e);
  e.find_metric();
  e.measure_rounding(e.residual(e.C_));
  e.q_ = q;
  const double error_before = e.relative_error();
  double error = error_before;
  int steps = 0;
  for (; error > epsilon && steps < 12; ++steps) {
    e.correct(e.C_, q);
    find_constraint(t, q, v, e);
    const double before = std::exchange(error, e.relative_error());
    if (renewed && !(error < before / 2)) break;
    renewed = !(error < before / 100);
    if (renewed && steps == 0) {  // from further away than was thought
      q = e.q_;
      find_constraint(t, q, v, e);
      error = before;
    }
    if (renewed) factor_here(t, e);
  }
  if (!(error <= error_before) || !e.C_.allFinite()) {
    q = e.q_;
    return {false, steps};
  }
  // A row whose own terms vanish for a moment, as at the origin, has the rounding of its
  // neighbours.
  const bool converged = project_velocities(t, v, e);
  return {converged &&
              (error <= e.tolerance() || e.residual(e.C_) <= e.tolerance() * e.residual(e.size_)) &&
              q.allFinite() && v.allFinite(),
          steps};
}

Assembly System::assemble(double t, VectorXd& q, VectorXd& v) const {
  Evaluation e(*this);
  check_lengths(q, v);
  if (!q.allFinite() || !v.allFinite())
    throw AssemblyError("cannot assemble: q and v must be finite");
  constexpr double closed = 64 * epsilon;
  VectorXd best = q, trial = q, C_best;
  find_constraint(t, q, v, e);
  Assembly report{};
  report.C_before = largest(e.C_);
  factor_here(t, e);
  e.find_metric();
  const double start = e.residual(e.C_);

  // Newton's method; whenever a step does not reduce C, K's diagonal is raised (Levenberg and
  // Marquardt), which shortens the step and turns it to the steepest descent. C is measured
  // through the diagonal of K, so that rows of all units count alike.
  e.measure_rounding(0);
  report.projected = e.relative_error() > closed;
  double damping = 0;
  for (int step = 0; report.projected && step < 300 && damping < 1e9; ++step) {
    find_constraint(t, best, v, e);
    e.measure_rounding(std::min(start, e.residual(e.size_)));
    if (e.relative_error() <= epsilon) break;
    factor_here(t, e, damping);
    e.find_metric();
    C_best = e.C_;
    trial = best;
    e.correct(e.C_, trial);
    find_constraint(t, trial, v, e);
    if (e.C_.cwiseProduct(e.per_root_K_).stableNorm() <
        C_best.cwiseProduct(e.per_root_K_).stableNorm()) {
      best = trial;
      damping = damping > 1e-6 ? damping / 10 : 0;
    } else {
      damping = std::max(10 * damping, 1e-3);
    }
  }

  find_constraint(t, best, v, e);
  e.measure_rounding(std::min(start, e.residual(e.size_)));
  if (!(e.relative_error() <= closed) || !e.C_.allFinite()) {
    Eigen::Index worst = 0;
    e.C_.cwiseProduct(e.per_size_).cwiseAbs().maxCoeff(&worst);
    e.refuse(worst);
  }
  e.check_closed();
  report.moved = largest(best - q);
  q = best;
  factor_here(t, e);  // at q; what follows leaves the factor alone
  e.find_metric();
  report.Jv_before = largest(e.Cdot_);
  project_velocities(t, v, e);
  return report;
}

// Throws unless the joints are closed by the scene's own measure too. Rounding, the measure until
// here, grows with the distance from the origin and with the turns of a body.
void Evaluation::check_closed() const {
  constexpr double angle_step = 1e-8, widest = 1e-6;
  for (const ThingInfo& thing : layout_.things) {
    const double theta = thing.dof == 3 ? things_.bodies[std::size_t(thing.index)].thing.theta : 0;
    if (epsilon * std::abs(theta) > angle_step)
      throw AssemblyError("cannot assemble: " + thing.name + " is turned by " + number(theta) +
                          " rad, too far for its angle to be exact");
  }
  const Geometry scene = geometry();
  for (Eigen::Index k = 0; scene.size > 0 && k < C_.size(); ++k)
    if (scene.part(C_, k) > widest) refuse(k);
}

// Throws the AssemblyError of a row that stays open. Around a loop of rows that compare angles the
// gap is shared, so that they have a whole turn between them.
void Evaluation::refuse(Eigen::Index open_row) const {
  const RowState open = row_state(open_row);
  double angles = 0;
  for (const JointInfo& joint : layout_.joints)
    for (int k = 0; k < joint.r; ++k)
      if (std::string_view(joint.unit[k]) == "rad") angles += std::abs(C_[joint.at.row + k]);
  const double turns = angles / (2 * std::acos(-1.0));
  const bool whole = turns > 0.5 && std::abs(turns - std::round(turns)) < 1e-6 * turns;
  throw AssemblyError("cannot assemble: " + open.row.joint + " row " +
                      std::to_string(open.row.row) + " (" + open.unit + ") stays open by " +
                      number(std::abs(open.C)) +
                      (whole ? "; the angles are whole turns apart, and are not wrapped" : ""));
}

}  // namespace dynamics
