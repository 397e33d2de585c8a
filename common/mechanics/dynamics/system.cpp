#include "mechanics/dynamics/system.hpp"

#include <algorithm>
#include <cmath>

#include "mechanics/dynamics/entries.hpp"

namespace dynamics {
namespace {

void append(VectorXd& x, const VectorXd& tail) {
  x.conservativeResize(x.size() + tail.size());
  x.tail(tail.size()) = tail;
}

}  // namespace

// ---- Setting up ----

Handle<Particle> System::add_particle(const std::string& name, double mass, const Vector2d& x,
                                      const Vector2d& v) {
  const Handle<Particle> handle{particles_, static_cast<int>(q0_.size()), identity_.number};
  add_thing(name, handle.index, Vector2d(mass, mass), x, v);
  ++particles_;
  return handle;
}

Handle<Body> System::add_body(const std::string& name, double mass, double inertia,
                              const Vector2d& x, double theta, const Vector2d& v, double omega) {
  const Handle<Body> handle{bodies_, static_cast<int>(q0_.size()), identity_.number};
  add_thing(name, handle.index, Vector3d(mass, mass, inertia), Vector3d(x.x(), x.y(), theta),
            Vector3d(v.x(), v.y(), omega));
  ++bodies_;
  return handle;
}

void System::add_thing(const std::string& name, int index, const VectorXd& mass, const VectorXd& q,
                       const VectorXd& v) {
  for (const double m : mass)
    if (!(m > 0) || !std::isnormal(m) || !std::isnormal(1 / m))
      throw std::invalid_argument(name + ": mass and inertia must be positive and finite, and so " +
                                  "must be their inverses");
  if (!q.allFinite() || !v.allFinite())
    throw std::invalid_argument(name + ": must start at a finite place with a finite velocity");
  check_load(name, mass[0], gravity_, VectorXd::Zero(q.size()));
  if (!thing_of_name_.emplace(name, layout_.things.size()).second)
    throw std::invalid_argument(name + ": another thing has this name");
  layout_.things.push_back({name, static_cast<int>(q0_.size()), static_cast<int>(q.size()), index});
  append(q0_, q);
  append(v0_, v);
  append(layout_.M, mass);
  append(layout_.W, mass.cwiseInverse());
  append(constant_, VectorXd::Zero(q.size()));
  ++revision_;
}

JointHandle System::add_joint(const std::string& name, std::unique_ptr<AnyJoint> rows, int r,
                              const char* const* unit, Side first, Side second) {
  if (first.column == second.column)
    throw std::invalid_argument(name + ": joins a thing to itself");
  if (!joint_names_.insert(name).second)
    throw std::invalid_argument(name + ": another joint has this name");
  const int joint = static_cast<int>(joints_.size()), row = layout_.rows;
  joints_.push_back(std::move(rows));
  layout_.joints.push_back({name, unit, r, {row, 0, layout_.size_of_J}});
  for (const Side& side : {first, second}) {
    if (side.dof == 0) continue;
    layout_.J_blocks.push_back({joint, r, row, side.dof, side.column, layout_.size_of_J});
    layout_.size_of_J += r * side.dof;
  }
  layout_.rows += r;
  ++revision_;
  return {joint, identity_.number};
}

JointHandle System::joint(int number) const {
  if (number < 0 || number >= static_cast<int>(joints_.size()))
    throw std::invalid_argument("joint " + std::to_string(number) + ": there is none");
  return {number, identity_.number};
}

void System::set_feedback(double ks, double kd) {
  if (!std::isfinite(ks) || !std::isfinite(kd))
    throw std::invalid_argument("the gains ks and kd must be finite");
  ks_ = ks;
  kd_ = kd;
}

// ---- What is refused ----

void System::check(const char* who, JointHandle handle) const {
  if (handle.system != identity_.number)
    throw std::invalid_argument(std::string(who) + ": a handle of another System, or of none");
}

// A row that cannot move anything, where J W J^T underflows, would hold nothing and not say so. One
// whose J is 0 is another matter: it may start to hold elsewhere.
void System::check_rows(const std::string& name, const VectorXd& C, const VectorXd& size,
                        const Eigen::MatrixXd& J, const VectorXd& W) const {
  const VectorXd K = J.cwiseAbs2() * W;
  bool usable = C.allFinite() && size.allFinite();
  for (Eigen::Index k = 0; k < K.size(); ++k)
    usable = usable && (std::isnormal(K[k]) || (J.row(k).array() == 0).all());
  if (!usable)
    throw std::invalid_argument(name + ": where its things start, C or J W J^T is not finite, or " +
                                "too small to be computed with");
}

void System::check_lengths(const VectorXd& q, const VectorXd& v) const {
  if (q.size() != q0_.size() || v.size() != q0_.size())
    throw std::invalid_argument("q and v must have one entry for each coordinate");
}

// ---- One evaluation ----

// The things as they are in state q, v. The only place where sin and cos are taken: once for each
// angle, since the rate alone often changes.
void System::enter(const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  check_lengths(q, v);
  if (e.system_ != identity_.number)
    throw std::invalid_argument("an Evaluation of another System, or of none");
  if (e.revision_ != revision_) e.analyse(*this);
  e.solved_ = false;
  double sum = 0;
  for (auto& [particle, column] : e.things_.particles) {
    particle = {q.segment<2>(column), v.segment<2>(column)};
    sum += (particle.x + particle.v).sum();
  }
  for (auto& [body, column] : e.things_.bodies) {
    body.x = q.segment<2>(column);
    body.v = v.segment<2>(column);
    if (body.theta != q[column + 2]) body.A = rotation(q[column + 2]);
    body.theta = q[column + 2];
    body.omega = v[column + 2];
    sum += (body.x + body.v).sum() + (body.theta + body.omega);
  }
  e.nan_of_state_ = 0 * sum;
}

// All that concerns each joint alone: C, J, b and the diagonal blocks of K.
void System::find_equation(double t, Evaluation& e) const {
  e.K_.K().setZero();
  const Equation all = e.equation();
  for (std::size_t i = 0; i < joints_.size(); ++i)
    joints_[i]->equation(t, e.things_, layout_.W, e.F_, all, e.layout_.joints[i].at);
}

// C, its sizes, J and Cdot at time t in state q, v.
void System::find_constraint(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  enter(q, v, e);
  const Equation all = e.equation();
  for (std::size_t i = 0; i < joints_.size(); ++i)
    joints_[i]->constraint(t, e.things_, v, all, e.layout_.joints[i].at);
}

// All of equation 1 but the solution: F, J, b and C, and the factor of K.
void System::set_up(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  enter(q, v, e);
  find_forces(t, e);
  find_equation(t, e);
  e.factor();
}

void System::evaluate(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  set_up(t, q, v, e);
  if (!e.weak_.empty() && e.nearly_dependent_rows() > 0 &&
      (!e.wholly_dependent() || is_singular_pose(t, q, v, e)))
    return evaluate_on_constraints(t, q, v, e);
  solve_for_a(q, v, e);
}

void System::solve_for_a(const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  e.lambda_.swap(e.b_);
  if (ks_ != 0) e.lambda_ -= ks_ * e.C_;
  if (kd_ != 0) {
    e.lambda_ -= kd_ * e.C_t_;
    e.add_J(-kd_, v, e.lambda_);
  }
  e.solve(e.lambda_, e.F_);
  e.a_ = layout_.W.cwiseProduct(e.F_);
  if (e.nan_of_state_ != 0) e.a_ += 0 * q + 0 * v;
  e.solved_ = true;
}

}  // namespace dynamics
