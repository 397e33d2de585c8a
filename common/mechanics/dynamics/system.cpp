#include "mechanics/dynamics/system.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <string_view>

namespace dynamics {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double infinity = std::numeric_limits<double>::infinity();

std::size_t index(int i) { return static_cast<std::size_t>(i); }

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

double largest(const VectorXd& x) {
  return x.size() == 0 ? 0 : x.cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

// 0, or NaN where an entry is not finite: to be added to what must not hide that.
double nan_of(const VectorXd& x) {
  double sum = 0;
  for (const double entry : x) sum += 0 * entry;
  return sum;
}

void append(VectorXd& x, const VectorXd& tail) {
  x.conservativeResize(x.size() + tail.size());
  x.tail(tail.size()) = tail;
}

}  // namespace

// ---- Setting up ----

Handle<Particle> System::add_particle(const std::string& name, double mass, const Vector2d& x,
                                      const Vector2d& v) {
  auto& slots = things_.particles.slots;
  const Handle<Particle> handle{static_cast<int>(slots.size()), static_cast<int>(q0_.size()),
                                identity_.number};
  add_thing(name, handle.index, Vector2d(mass, mass), x, v);
  slots.push_back({{x, v}, handle.column});
  return handle;
}

Handle<Body> System::add_body(const std::string& name, double mass, double inertia,
                              const Vector2d& x, double theta, const Vector2d& v, double omega) {
  auto& slots = things_.bodies.slots;
  const Handle<Body> handle{static_cast<int>(slots.size()), static_cast<int>(q0_.size()),
                            identity_.number};
  add_thing(name, handle.index, Vector3d(mass, mass, inertia), Vector3d(x.x(), x.y(), theta),
            Vector3d(v.x(), v.y(), omega));
  slots.push_back({{x, v, theta, omega, rotation(theta)}, handle.column});
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
  if (!thing_of_name_.emplace(name, thing_info_.size()).second)
    throw std::invalid_argument(name + ": another thing has this name");
  thing_info_.push_back({name, static_cast<int>(q0_.size()), static_cast<int>(q.size()), index});
  append(q0_, q);
  append(v0_, v);
  append(M_, mass);
  append(W_, mass.cwiseInverse());
  append(constant_, VectorXd::Zero(q.size()));
  ready_ = false;
}

JointHandle System::add_joint(const std::string& name, std::unique_ptr<AnyJoint> rows, int r,
                              const char* const* unit, Side first, Side second) {
  if (first.column == second.column)
    throw std::invalid_argument(name + ": joins a thing to itself");
  if (!joint_names_.insert(name).second)
    throw std::invalid_argument(name + ": another joint has this name");
  const int joint = static_cast<int>(joints_.size()), row = static_cast<int>(C_.size());
  joints_.push_back({name, std::move(rows), unit, r, row, static_cast<int>(J_.size()), 0});
  for (const Side& side : {first, second}) {
    if (side.dof == 0) continue;
    J_blocks_.push_back({joint, r, row, side.dof, side.column, static_cast<int>(J_.size())});
    J_.conservativeResize(J_.size() + r * side.dof);
  }
  C_.conservativeResize(row + r);
  ready_ = false;
  return {joint, identity_.number};
}

JointHandle System::joint(int number) const {
  if (number < 0 || number >= static_cast<int>(joints_.size()))
    throw std::invalid_argument("joint " + std::to_string(number) + ": there is none");
  return {number, identity_.number};
}

void System::set_gravity(const Vector2d& g) {
  if (!g.allFinite()) throw std::invalid_argument("gravity must be finite");
  for (const auto& [name, column, dof, index] : thing_info_)
    check_load(name, M_[column], g, constant_.segment(column, dof));
  gravity_ = g;
  ready_ = false;
}

void System::add_load(int column, const VectorXd& F) {
  const auto thing = std::find_if(thing_info_.begin(), thing_info_.end(),
                                  [&](const ThingInfo& info) { return info.column == column; });
  const VectorXd sum = constant_.segment(column, thing->dof) + F;
  check_load(thing->name, M_[column], gravity_, sum);
  constant_.segment(column, thing->dof) = sum;
  ready_ = false;
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

// The weight and the constant forces of a thing.
void System::check_load(const std::string& name, double mass, const Vector2d& g,
                        const VectorXd& F) const {
  if (!F.allFinite() || !(mass * g + F.head<2>()).allFinite())
    throw std::invalid_argument(name + ": its weight and constant forces must be finite");
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

void System::check_solved() const {
  if (!ready_ || !solved_)
    throw std::logic_error("asked of the last acceleration(), but there was none, or the joints " +
                           std::string("were evaluated elsewhere since"));
}

// ---- One evaluation ----

// Finds which blocks of J meet in which block of K = J W J^T, and gives everything its storage.
void System::prepare() {
  if (ready_) return;
  std::map<int, std::vector<JBlock>> blocks_of_column;
  for (const JBlock& block : J_blocks_) blocks_of_column[block.column].push_back(block);
  std::vector<int> dofs;
  for (const ThingInfo& thing : thing_info_) dofs.push_back(thing.dof);
  dof_ = in_common(dofs);

  std::vector<int> sizes;
  for (const Joint& joint : joints_) sizes.push_back(joint.r);
  std::vector<std::pair<int, int>> edges;
  for (const auto& [column, blocks] : blocks_of_column)
    for (const JBlock& a : blocks)
      for (const JBlock& b : blocks)
        if (a.joint < b.joint) edges.emplace_back(a.joint, b.joint);
  K_.analyse(sizes, edges);

  pairs_.clear();
  for (const auto& [column, blocks] : blocks_of_column)
    for (const JBlock& a : blocks)
      for (const JBlock& b : blocks)
        if (a.joint != b.joint && K_.after(a.joint, b.joint))
          pairs_.push_back({a.r, b.r, a.dof, column, a.J, b.J, K_.block(a.joint, b.joint)});

  for (int i = 0; i < static_cast<int>(joints_.size()); ++i) joints_[index(i)].K = K_.block(i, i);

  F0_ = constant_;
  for (const ThingInfo& thing : thing_info_)
    F0_.segment<2>(thing.column) += gravity_ * M_[thing.column];
  F_.setZero(q0_.size());
  a_ = q_ = F_;
  for (VectorXd* x : {&C_, &size_, &per_size_, &per_root_K_, &b_, &Jv_, &lambda_, &mu_})
    x->setZero(C_.size());
  J_.setZero();
  factored_ = solved_ = false;
  ready_ = true;
}

// The things as they are in state q, v. The only place where sin and cos are taken: once for each
// angle, since the rate alone often changes.
void System::load(const VectorXd& q, const VectorXd& v) {
  check_lengths(q, v);
  for (auto& [particle, column] : things_.particles.slots)
    particle = {q.segment<2>(column), v.segment<2>(column)};
  for (auto& [body, column] : things_.bodies.slots) {
    body.x = q.segment<2>(column);
    body.v = v.segment<2>(column);
    if (body.theta != q[column + 2]) body.A = rotation(q[column + 2]);
    body.theta = q[column + 2];
    body.omega = v[column + 2];
  }
}

JointPlace System::place(const Joint& joint) {
  return {C_.data() + joint.row, size_.data() + joint.row, Jv_.data() + joint.row,
          b_.data() + joint.row, K_.K().data() + joint.K,  J_.data() + joint.J};
}

// All that concerns each joint alone, with a_ = W F: C, J, b and the diagonal blocks of K.
void System::find_equation() {
  K_.K().setZero();
  for (const Joint& joint : joints_) joint.rows->equation(things_, W_, a_, place(joint));
}

// C, its sizes, J and J v in state q, v.
void System::evaluate(const VectorXd& q, const VectorXd& v) {
  load(q, v);
  solved_ = false;
  for (const Joint& joint : joints_) joint.rows->constraint(things_, v, place(joint));
}

// Calls f(block, r, dof) for each block of J, its size as constants.
template <class F>
void System::for_each_block_of_J(F&& f) const {
  alike(K_.size(), [&](auto all_r) {
    alike(dof_, [&](auto all_dof) {
      for (const JBlock& block : J_blocks_)
        fixed<all_r>(block.r, [&](auto r) {
          fixed<all_dof>(block.dof, [&](auto dof) { f(block, r, dof); });
        });
    });
  });
}

// y += sign J x
void System::add_J(double sign, const VectorXd& x, VectorXd& y) const {
  for_each_block_of_J([&](const JBlock& block, auto r, auto dof) {
    const ConstBlock<r, dof> J(J_.data() + block.J);
    const ConstBlock<dof, 1> x_thing(x.data() + block.column);
    Block<r, 1>(y.data() + block.row) += sign * J.lazyProduct(x_thing);
  });
}

// x += J^T y
void System::add_Jt(const VectorXd& y, VectorXd& x) const {
  for_each_block_of_J([&](const JBlock& block, auto r, auto dof) {
    const ConstBlock<r, dof> J(J_.data() + block.J);
    const ConstBlock<r, 1> y_joint(y.data() + block.row);
    Block<dof, 1>(x.data() + block.column) += J.transpose().lazyProduct(y_joint);
  });
}

// K = J W J^T, factored: the joints wrote its diagonal blocks, here are those between two joints.
void System::factor(double damping) {
  double* const K = K_.K().data();
  alike(K_.size(), [&](auto all_r) {
    alike(dof_, [&](auto all_dof) {
      for (const Pair& pair : pairs_)
        fixed<all_dof>(pair.dof, [&](auto dof) {
          fixed<all_r>(pair.r_a, [&](auto r_a) {
            fixed<all_r>(pair.r_b, [&](auto r_b) {
              const ConstBlock<dof, 1> W(W_.data() + pair.column);
              const ConstBlock<r_a, dof> J_a(J_.data() + pair.J_a);
              const ConstBlock<r_b, dof> J_b(J_.data() + pair.J_b);
              const Eigen::Matrix<double, r_a, dof> J_a_W = J_a * W.asDiagonal();
              Block<r_a, r_b>(K + pair.K) += J_a_W.lazyProduct(J_b.transpose());
            });
          });
        });
    });
  });
  K_.factor(damping);
  factored_ = true;
}

// The same where K is not known yet, in the state that was evaluated last. Nobody asks for b.
void System::factor_here(double damping) {
  find_equation();
  factor(damping);
}

// The things as they are, and the applied forces F on them.
void System::find_forces(double t, const VectorXd& q, const VectorXd& v) {
  prepare();
  load(q, v);
  F_ = F0_;
  for (const auto& [thing, F, V] : things_.particles.laws)
    F_.segment<2>(thing.column) += F(t, things_[thing]);
  for (const auto& [thing, F, V] : things_.bodies.laws)
    F_.segment<3>(thing.column) += F(t, things_[thing]);
}

void System::acceleration(double t, const VectorXd& q, const VectorXd& v, VectorXd& a) {
  find_forces(t, q, v);
  a_ = W_.cwiseProduct(F_);
  find_equation();
  lambda_ = b_;
  if (ks_ != 0) lambda_ -= ks_ * C_;
  if (kd_ != 0) add_J(-kd_, v, lambda_);
  factor();
  K_.solve(lambda_);

  add_Jt(lambda_, F_);
  a = W_.cwiseProduct(F_) + 0 * q + 0 * v;  // NaN where q or v is not finite
  solved_ = true;
}

VectorXd System::lambda(JointHandle joint) const {
  check("lambda", joint);
  check_solved();
  const Joint& j = joints_[index(joint.index)];
  return lambda_.segment(j.row, j.r);
}

Vector3d System::reaction(JointHandle joint, int column) const {
  check("reaction", joint);
  check_solved();
  Vector3d reaction = Vector3d::Zero();
  for (const JBlock& b : J_blocks_)
    if (b.joint == joint.index && b.column == column)
      reaction.head(b.dof) =
          Eigen::Map<const Eigen::MatrixXd>(J_.data() + b.J, b.r, b.dof).transpose() *
          lambda_.segment(b.row, b.r);
  return reaction;
}

// ---- Back onto the constraints ----

// The largest |x_k| / sqrt(K_kk). The root carries the row's units, so rows of all units compare.
double System::residual(const VectorXd& x) const {
  return x.size() == 0 ? 0 : x.cwiseProduct(per_root_K_).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

// Takes down 1 / sqrt(K_kk), the measure of each row; 0 for a row that nothing can move.
void System::find_metric() {
  for (Eigen::Index k = 0; k < per_root_K_.size(); ++k)
    per_root_K_[k] = 1 / std::sqrt(K_.diagonal()[k] > 0 ? K_.diagonal()[k] : infinity);
}

// Takes down how large C may be by rounding: about epsilon times the terms that it is the
// difference of. Where these are 0, say for a wheel at the origin, what a correction of C from
// `start` leaves there by its own rounding counts instead.
void System::measure_rounding(double start) {
  per_size_ = (size_.array() + start * K_.diagonal().array().sqrt())
                  .max(std::numeric_limits<double>::min())
                  .inverse();
}

// The largest |C| in these terms: about epsilon, whatever the units, when C is rounding.
double System::relative_error() const {
  return C_.size() == 0 ? 0 : C_.cwiseProduct(per_size_).cwiseAbs().maxCoeff<Eigen::PropagateNaN>();
}

// x -= W J^T K^-1 error
void System::correct(const VectorXd& error, VectorXd& x) {
  mu_ = error;
  K_.solve(mu_);
  F_.setZero();
  add_Jt(mu_, F_);
  x -= W_.cwiseProduct(F_);
}

// Needs J and J v at q, v, and a factor of K from near them; one from q itself is made when that is
// not enough. J v of a row is compared, through sqrt(K_kk), with the velocity in the mass metric.
bool System::project_velocities(VectorXd& v) {
  for (int pass = 1;;
       ++pass) {  // one is always made: in this metric a light thing's error is small
    correct(Jv_, v);
    Jv_.setZero();
    add_J(1, v, Jv_);
    const double rounding = epsilon * std::sqrt(2 * kinetic_energy(v));
    const double error = residual(Jv_);
    if (error <= rounding) return true;
    if (pass == 3) return error <= 16 * rounding;
    if (pass == 1) factor_here();
  }
}

Projection System::project(VectorXd& q, VectorXd& v) {
  prepare();
  evaluate(q, v);
  // One factor serves all steps: that of the acceleration before, from very near q, or else one
  // from q itself. It is renewed when they converge slowly; when that does not help either, C is at
  // its rounding or cannot be closed.
  bool renewed = !factored_;
  if (renewed) factor_here();
  find_metric();
  measure_rounding(residual(C_));
  q_ = q;
  const double error_before = relative_error();
  double error = error_before;
  int steps = 0;
  for (; error > epsilon && steps < 12; ++steps) {
    correct(C_, q);
    evaluate(q, v);
    const double before = std::exchange(error, relative_error());
    if (renewed && !(error < before / 2)) break;
    renewed = !(error < before / 100);
    if (renewed && steps == 0) {  // from further away than was thought
      q = q_;
      evaluate(q, v);
      error = before;
    }
    if (renewed) factor_here();
  }
  if (!(error <= error_before) || !C_.allFinite()) {
    q = q_;
    return {false, steps};
  }
  // A row whose own terms vanish for a moment, as at the origin, has the rounding of its
  // neighbours.
  const bool converged = project_velocities(v);
  return {converged && (error <= 16 * epsilon || residual(C_) <= 16 * epsilon * residual(size_)) &&
              q.allFinite() && v.allFinite(),
          steps};
}

Assembly System::assemble(VectorXd& q, VectorXd& v) {
  prepare();
  check_lengths(q, v);
  if (!q.allFinite() || !v.allFinite())
    throw AssemblyError("cannot assemble: q and v must be finite");
  constexpr double closed = 64 * epsilon;
  VectorXd best = q, trial = q, C_best;
  evaluate(q, v);
  Assembly report{};
  report.C_before = largest(C_);
  factor_here();
  find_metric();
  const double start = residual(C_);

  // Newton's method; whenever a step does not reduce C, K's diagonal is raised (Levenberg and
  // Marquardt), which shortens the step and turns it to the steepest descent. C is measured
  // through the diagonal of K, so that rows of all units count alike.
  measure_rounding(0);
  report.projected = relative_error() > closed;
  double damping = 0;
  for (int step = 0; report.projected && step < 300 && damping < 1e9; ++step) {
    evaluate(best, v);
    measure_rounding(std::min(start, residual(size_)));
    if (relative_error() <= epsilon) break;
    factor_here(damping);
    find_metric();
    C_best = C_;
    trial = best;
    correct(C_, trial);
    evaluate(trial, v);
    if (C_.cwiseProduct(per_root_K_).stableNorm() < C_best.cwiseProduct(per_root_K_).stableNorm()) {
      best = trial;
      damping = damping > 1e-6 ? damping / 10 : 0;
    } else {
      damping = std::max(10 * damping, 1e-3);
    }
  }

  evaluate(best, v);
  measure_rounding(std::min(start, residual(size_)));
  if (!(relative_error() <= closed) || !C_.allFinite()) {
    Eigen::Index worst = 0;
    C_.cwiseProduct(per_size_).cwiseAbs().maxCoeff(&worst);
    refuse(worst);
  }
  check_closed(best);
  report.moved = largest(best - q);
  q = best;
  factor_here();  // at q; velocity_error leaves the factor alone
  find_metric();
  report.Jv_before = largest(Jv_);
  project_velocities(v);
  return report;
}

// Throws unless the joints of state q are closed by the scene's own measure too. Rounding, the
// measure until here, grows with the distance from the origin and with the turns of a body.
void System::check_closed(const VectorXd& q) const {
  constexpr double angle_step = 1e-8, widest = 1e-6;
  // The size of the scene (m): what it spans, a radius of gyration, a lever. A J in m is one too.
  double size = 0;
  for (const ThingInfo& a : thing_info_) {
    const ThingInfo& b = thing_info_.front();
    size = std::max(size, largest(q.segment<2>(a.column) - q.segment<2>(b.column)));
    if (a.dof == 2) continue;
    size = std::max(size, std::sqrt(M_[a.column + 2] / M_[a.column]));
    if (epsilon * std::abs(q[a.column + 2]) > angle_step)
      throw AssemblyError("cannot assemble: " + a.name + " is turned by " +
                          number(q[a.column + 2]) + " rad, too far for its angle to be exact");
  }
  VectorXd J_x = VectorXd::Zero(C_.size()), J_theta = J_x;
  for (const JBlock& block : J_blocks_)
    for (int k = 0; k < block.r; ++k) {
      const double* J = J_.data() + block.J + k;
      double &x = J_x[block.row + k], &theta = J_theta[block.row + k];
      x = std::max({x, std::abs(J[0]), std::abs(J[block.r])});
      if (block.dof == 3) theta = std::max(theta, std::abs(J[2 * block.r]));
    }
  for (const Joint& joint : joints_)
    for (int k = 0; k < joint.r; ++k) {
      const double x = J_x[joint.row + k], lever = J_theta[joint.row + k] / x;
      if (x > 0) size = std::max({size, lever, std::string_view(joint.unit[k]) == "m^2" ? x : 0});
    }
  for (Eigen::Index k = 0; size > 0 && k < C_.size(); ++k)
    if (std::abs(C_[k]) > widest * std::max(size * J_x[k], J_theta[k])) refuse(k);
}

// Throws the AssemblyError of a row that stays open. Around a loop of rows that compare angles the
// gap is shared, so that they have a whole turn between them.
void System::refuse(Eigen::Index open_row) const {
  const RowState open = row_state(open_row);
  double angles = 0;
  for (const Joint& joint : joints_)
    for (int k = 0; k < joint.r; ++k)
      if (std::string_view(joint.unit[k]) == "rad") angles += std::abs(C_[joint.row + k]);
  const double turns = angles / (2 * std::acos(-1.0));
  const bool whole = turns > 0.5 && std::abs(turns - std::round(turns)) < 1e-6 * turns;
  throw AssemblyError("cannot assemble: " + open.row.joint + " row " +
                      std::to_string(open.row.row) + " (" + open.unit + ") stays open by " +
                      number(std::abs(open.C)) +
                      (whole ? "; the angles are whole turns apart, and are not wrapped" : ""));
}

// ---- What a scene tells about itself ----

double System::energy(const VectorXd& q, const VectorXd& v) {
  prepare();
  load(q, v);
  double energy = kinetic_energy(v);
  for (const ThingInfo& thing : thing_info_)
    energy -= gravity_.dot(q.segment<2>(thing.column)) * M_[thing.column];
  for (const auto& [thing, F, V] : things_.particles.laws)
    if (V) energy += V(things_[thing]);
  for (const auto& [thing, F, V] : things_.bodies.laws)
    if (V) energy += V(things_[thing]);
  return energy + nan_of(q);
}

double System::kinetic_energy(const ThingInfo& thing, const VectorXd& v) const {
  check_lengths(v, v);
  const auto part = Eigen::seqN(thing.column, thing.dof);
  return (v(part).array().square() * M_(part).array()).sum() / 2;
}

double System::kinetic_energy(const VectorXd& v) const {
  check_lengths(v, v);
  return (v.array().square() * M_.array()).sum() / 2;
}

double System::drive(double t, const VectorXd& q, const VectorXd& v) {
  find_forces(t, q, v);
  return std::sqrt((F_.array().square() * W_.array()).sum()) + nan_of(q) + nan_of(v);
}

double System::load(double t, const VectorXd& q, const VectorXd& v) {
  find_forces(t, q, v);
  double load = nan_of(q) + nan_of(v);
  for (const ThingInfo& thing : thing_info_) {
    load += F_.segment<2>(thing.column).norm();
    if (thing.dof == 3) load += std::abs(F_[thing.column + 2]) / radius_at(thing.column);
  }
  return load;
}

double System::free_acceleration(double t, const VectorXd& q, const VectorXd& v) {
  find_forces(t, q, v);
  return W_.cwiseProduct(F_).norm() + nan_of(q) + nan_of(v);
}

double System::distance(const VectorXd& q) {
  prepare();
  evaluate(q, v0_);
  factor_here();
  mu_ = C_;
  K_.solve(mu_);
  return std::sqrt(std::max(C_.dot(mu_), 0.0)) + nan_of(q);  // max keeps a NaN that comes first
}

double System::radius(const ThingInfo& thing) const {
  return thing.dof == 3 ? radius_at(thing.column) : 0;
}

double System::radius_at(int column) const { return std::sqrt(3 * M_[column + 2] * W_[column]); }

// A row that holds points moves them by C over the size of its gradient there, wherever they are on
// their things; one that holds angles alone turns its things by C, each as its inertia lets it.
double System::opening(const VectorXd& q) {
  prepare();
  evaluate(q, v0_);
  mu_.setZero();  // of each row, |J| in the places, and in the angles
  b_.setZero();
  lambda_.setZero();  // the radius by which the angles count, times that
  for (const JBlock& block : J_blocks_) {
    const Eigen::Map<const Eigen::MatrixXd> J(J_.data() + block.J, block.r, block.dof);
    const double W_I = block.dof == 3 ? W_[block.column + 2] : 0;
    const double lever = block.dof == 3 ? radius_at(block.column) : 0;
    for (int k = 0; k < block.r; ++k) {
      const Eigen::Index row = block.row + k;
      mu_[row] = std::max(mu_[row], std::hypot(J(k, 0), J(k, 1)));
      const double turns = block.dof == 3 ? W_I * J(k, 2) * J(k, 2) : 0;
      b_[row] += turns;
      lambda_[row] += turns * lever;
    }
  }
  double opening = 0;
  for (Eigen::Index row = 0; row < C_.size(); ++row) {
    const double per_C = mu_[row] > 0 ? 1 / mu_[row] : b_[row] > 0 ? lambda_[row] / b_[row] : 0;
    opening = std::max(opening, std::abs(C_[row]) * per_C);
  }
  return opening;
}

double System::constraint_error(const VectorXd& q) {
  prepare();
  evaluate(q, v0_);
  return largest(C_) + nan_of(q);
}

double System::velocity_error(const VectorXd& q, const VectorXd& v) {
  prepare();
  evaluate(q, v);
  return largest(Jv_) + nan_of(q) + nan_of(v);
}

Eigen::MatrixXd System::jacobian(const VectorXd& q) {
  prepare();
  evaluate(q, v0_);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(C_.size(), q0_.size());
  for (const JBlock& b : J_blocks_)
    J.block(b.row, b.column, b.r, b.dof) =
        Eigen::Map<const Eigen::MatrixXd>(J_.data() + b.J, b.r, b.dof);
  J.array() += nan_of(q);
  return J;
}

Counts System::counts() const {
  check_solved();
  const auto bytes = [](const auto&... x) { return (... + (sizeof(x[0]) * index(int(x.size())))); };
  const int coordinates = static_cast<int>(q0_.size()), rank = K_.rank();
  return {.things = static_cast<int>(thing_info_.size()),
          .coordinates = coordinates,
          .rows = static_cast<int>(C_.size()),
          .rank = rank,
          .degrees_of_freedom = coordinates - rank,
          .jacobian_blocks = static_cast<int>(J_blocks_.size()),
          .factor_blocks = K_.blocks(),
          .state_bytes = bytes(q0_, v0_),
          .workspace_bytes = bytes(things_.particles.slots, things_.bodies.slots, joints_,
                                   J_blocks_, pairs_, M_, W_, F0_, F_, a_, q_, C_, size_, per_size_,
                                   per_root_K_, b_, Jv_, lambda_, mu_, J_) +
                             K_.bytes()};
}

std::vector<JointRow> System::dependent_rows() const {
  check_solved();
  std::vector<JointRow> rows;
  for (const Joint& joint : joints_)
    for (int k = 0; k < joint.r; ++k)
      if (K_.independence(joint.row + k) == 0) rows.push_back({joint.name, k + 1});
  return rows;
}

RowState System::row_state(Eigen::Index row) const {
  if (joints_.empty()) throw std::logic_error("a scene without joints has no rows");
  const auto joint =
      std::find_if(joints_.rbegin(), joints_.rend(), [&](auto& j) { return j.row <= row; });
  const int k = static_cast<int>(row) - joint->row;
  return {{joint->name, k + 1}, joint->unit[k], C_[row], K_.independence(row)};
}

RowState System::worst_row() const {
  check_solved();
  Eigen::Index worst = 0;
  double largest = 0;
  for (Eigen::Index row = 0; row < C_.size(); ++row) {
    const double square = K_.diagonal()[row] > 0 ? C_[row] * C_[row] / K_.diagonal()[row] : 0;
    if (square > largest) worst = row, largest = square;
  }
  return row_state(worst);
}

RowState System::weakest_row() const {
  check_solved();
  Eigen::Index weakest = 0;
  for (Eigen::Index row = 1; row < C_.size(); ++row)
    if (K_.independence(row) < K_.independence(weakest)) weakest = row;
  return row_state(weakest);
}

}  // namespace dynamics
