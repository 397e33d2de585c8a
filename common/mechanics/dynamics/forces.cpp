// Forces: gravity, constant loads, laws of one thing and of two; and the energies.
#include <algorithm>
#include <cmath>

#include "mechanics/dynamics/entries.hpp"
#include "mechanics/dynamics/system.hpp"

namespace dynamics {

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

// The weight and the constant forces of a thing.
void System::check_load(const std::string& name, double mass, const Vector2d& g,
                        const VectorXd& F) const {
  if (!F.allFinite() || !(mass * g + F.head<2>()).allFinite())
    throw std::invalid_argument(name + ": its weight and constant forces must be finite");
}

// The weight of each thing and the constant forces on it.
VectorXd System::weights() const {
  VectorXd F = constant_;
  for (const ThingInfo& thing : layout_.things)
    F.segment<2>(thing.column) += gravity_ * layout_.M[thing.column];
  return F;
}

void System::find_forces(double t, Evaluation& e) const {
  e.F_ = e.F0_;
  for (const auto& [thing, F, V, number] : particle_laws_)
    e.F_.segment<2>(thing.column) += F(t, e.things_[thing]);
  for (const auto& [thing, F, V, number] : body_laws_)
    e.F_.segment<3>(thing.column) += F(t, e.things_[thing]);
  for (const AnyMutualLaw& law : mutual_laws_) law.add(t, e.things_, e.F_);
}

// ---- Of a state, without its joints ----

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
