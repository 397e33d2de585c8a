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
  layout_.joints.push_back({name, unit, r, row, layout_.size_of_J, 0});
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

void System::set_gravity(const Vector2d& g) {
  if (!g.allFinite()) throw std::invalid_argument("gravity must be finite");
  for (const auto& [name, column, dof, index] : layout_.things)
    check_load(name, layout_.M[column], g, constant_.segment(column, dof));
  gravity_ = g;
  ++revision_;
}

ForceHandle System::add_load(int column, const VectorXd& F) {
  const ThingInfo& thing = thing_at(layout_.things, column);
  const VectorXd sum = constant_.segment(column, thing.dof) + F;
  check_load(thing.name, layout_.M[column], gravity_, sum);
  constant_.segment(column, thing.dof) = sum;
  loads_.push_back({column, F, ++forces_});
  return applied();
}

void System::remove(ForceHandle force) {
  check("remove", JointHandle{force.number, force.system});
  const auto is_meant = [&](const auto& other) { return other.number == force.number; };
  if (const auto load = std::find_if(loads_.begin(), loads_.end(), is_meant);
      load != loads_.end()) {
    // Not subtracted, but summed anew: nothing of it is left, not even its rounding.
    const ThingInfo& thing = thing_at(layout_.things, load->column);
    VectorXd sum = VectorXd::Zero(thing.dof);
    for (const Load& other : loads_)
      if (other.column == load->column && !is_meant(other)) sum += other.F;
    check_load(thing.name, layout_.M[thing.column], gravity_, sum);
    constant_.segment(thing.column, thing.dof) = sum;
    loads_.erase(load);
  } else if (std::erase_if(particle_laws_, is_meant) + std::erase_if(body_laws_, is_meant) +
                 std::erase_if(mutual_laws_, is_meant) ==
             0) {
    throw std::invalid_argument("remove: this force is not applied any more");
  }
  ++revision_;
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

// ---- One evaluation ----

// The weight of each thing and the constant forces on it.
VectorXd System::weights() const {
  VectorXd F = constant_;
  for (const ThingInfo& thing : layout_.things)
    F.segment<2>(thing.column) += gravity_ * layout_.M[thing.column];
  return F;
}

// The things as they are in state q, v. The only place where sin and cos are taken: once for each
// angle, since the rate alone often changes.
void System::enter(const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  check_lengths(q, v);
  if (e.system_ != identity_.number)
    throw std::invalid_argument("an Evaluation of another System, or of none");
  if (e.revision_ != revision_) e.analyse(*this);
  e.solved_ = false;
  for (auto& [particle, column] : e.things_.particles)
    particle = {q.segment<2>(column), v.segment<2>(column)};
  for (auto& [body, column] : e.things_.bodies) {
    body.x = q.segment<2>(column);
    body.v = v.segment<2>(column);
    if (body.theta != q[column + 2]) body.A = rotation(q[column + 2]);
    body.theta = q[column + 2];
    body.omega = v[column + 2];
  }
}

void System::find_forces(double t, Evaluation& e) const {
  e.F_ = e.F0_;
  for (const auto& [thing, F, V, number] : particle_laws_)
    e.F_.segment<2>(thing.column) += F(t, e.things_[thing]);
  for (const auto& [thing, F, V, number] : body_laws_)
    e.F_.segment<3>(thing.column) += F(t, e.things_[thing]);
  for (const AnyMutualLaw& law : mutual_laws_) law.add(t, e.things_, e.F_);
}

// All that concerns each joint alone, with a_ = W F: C, J, b and the diagonal blocks of K.
void System::find_equation(Evaluation& e) const {
  e.K_.K().setZero();
  for (std::size_t i = 0; i < joints_.size(); ++i)
    joints_[i]->equation(e.things_, layout_.W, e.a_, e.place(e.layout_.joints[i]));
}

// C, its sizes, J and J v in state q, v.
void System::find_constraint(const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  enter(q, v, e);
  for (std::size_t i = 0; i < joints_.size(); ++i)
    joints_[i]->constraint(e.things_, v, e.place(e.layout_.joints[i]));
}

// All of equation 1 but the solution: F, a_ = W F, J, b and C, and the factor of K.
void System::set_up(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  enter(q, v, e);
  find_forces(t, e);
  e.a_ = layout_.W.cwiseProduct(e.F_);
  find_equation(e);
  e.factor();
}

void System::evaluate(double t, const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  set_up(t, q, v, e);
  if (e.nearly_dependent_rows() > 0 && (!e.wholly_dependent() || is_singular_pose(t, q, v, e)))
    return evaluate_on_constraints(t, q, v, e);
  solve_for_a(q, v, e);
}

void System::solve_for_a(const VectorXd& q, const VectorXd& v, Evaluation& e) const {
  e.lambda_ = e.b_;
  if (ks_ != 0) e.lambda_ -= ks_ * e.C_;
  if (kd_ != 0) e.add_J(-kd_, v, e.lambda_);
  e.solve(e.lambda_, e.F_);
  e.a_ = layout_.W.cwiseProduct(e.F_) + 0 * q + 0 * v;  // NaN where q or v is not finite
  e.solved_ = true;
}

// ---- What a scene tells of a state without its joints ----

// All things in state q, v, where no evaluation holds them.
Things System::things_at(const VectorXd& q, const VectorXd& v) const {
  Things things;
  for (const auto& [name, column, dof, index] : layout_.things)
    if (dof == 2)
      things.particles.push_back({at(Handle<Particle>{index, column}, q, v), column});
    else
      things.bodies.push_back({at(Handle<Body>{index, column}, q, v), column});
  return things;
}

VectorXd System::forces(double t, const VectorXd& q, const VectorXd& v) const {
  check_lengths(q, v);
  VectorXd forces = weights();
  for (const auto& [thing, F, V, number] : particle_laws_)
    forces.segment<2>(thing.column) += F(t, at(thing, q, v));
  for (const auto& [thing, F, V, number] : body_laws_)
    forces.segment<3>(thing.column) += F(t, at(thing, q, v));
  if (!mutual_laws_.empty()) {
    const Things things = things_at(q, v);
    for (const AnyMutualLaw& law : mutual_laws_) law.add(t, things, forces);
  }
  return forces + 0 * q + 0 * v;
}

double System::energy(const VectorXd& q, const VectorXd& v) const {
  check_lengths(q, v);
  double energy = kinetic_energy(v);
  for (const ThingInfo& thing : layout_.things)
    energy -= gravity_.dot(q.segment<2>(thing.column)) * layout_.M[thing.column];
  for (const auto& [thing, F, V, number] : particle_laws_)
    if (V) energy += V(at(thing, q, v));
  for (const auto& [thing, F, V, number] : body_laws_)
    if (V) energy += V(at(thing, q, v));
  if (!mutual_laws_.empty()) {
    const Things things = things_at(q, v);
    for (const AnyMutualLaw& law : mutual_laws_)
      if (law.V) energy += law.V(things);
  }
  return energy + nan_of(q);
}

double System::kinetic_energy(const ThingInfo& thing, const VectorXd& v) const {
  check_lengths(v, v);
  const auto part = Eigen::seqN(thing.column, thing.dof);
  return (v(part).array().square() * layout_.M(part).array()).sum() / 2;
}

double System::kinetic_energy(const VectorXd& v) const {
  check_lengths(v, v);
  return (v.array().square() * layout_.M.array()).sum() / 2;
}

double System::drive(const VectorXd& F) const {
  check_lengths(F, F);
  return std::sqrt((F.array().square() * layout_.W.array()).sum());
}

double System::load(const VectorXd& F) const {
  check_lengths(F, F);
  double load = 0;
  for (const ThingInfo& thing : layout_.things) {
    load += F.segment<2>(thing.column).norm();
    if (thing.dof == 3) load += std::abs(F[thing.column + 2]) / radius(thing);
  }
  return load;
}

double System::radius(const ThingInfo& thing) const {
  return thing.dof == 3 ? layout_.radius(thing.column) : 0;
}

}  // namespace dynamics
