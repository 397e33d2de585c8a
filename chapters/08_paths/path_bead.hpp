#pragma once

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "mechanics/motion/motion.hpp"
#include "mechanics/paths/by_length.hpp"
#include "wire.hpp"

namespace any_wire {

using Eigen::Vector2d;

/// Where the bead is on its wire, and its speed along growing q [m/s].
struct Now {
  double q, speed;
};

/// What both descriptions of the bead share; `Self` gives its state a meaning by now(state, rate).
template <class Self>
class BeadOnWire {
 public:
  using Vector = double;  // one coordinate is the whole state
  /// A force [N] besides the weight, as a hand's, of place and velocity; empty: none.
  std::function<Vector2d(const Vector2d& x, const Vector2d& v)> pull;

  double initial_position() const { return start_; }
  double initial_velocity() const { return start_rate_; }

  Vector2d force(const Vector2d& x, const Vector2d& v) const {
    const Vector2d weight(0.0, mass_ * gravity_);
    return pull ? Vector2d(weight + pull(x, v)) : weight;
  }

  /// The force of the wire [N]: what keeps the bead on its curvature, and what answers the force
  /// across it. Not a number where the curvature is infinite.
  Vector2d constraint_force(const Now& now) const {
    if (on(now) == On::none) return -force(path()(now.q).x, Vector2d::Zero());
    const auto [x, d, dd] = place(now);
    const Vector2d t = tangent(now), n(-t.y(), t.x());
    const double curvature = n.dot(dd) / d.squaredNorm();
    return (mass_ * curvature * now.speed * now.speed - n.dot(force(x, now.speed * t))) * n;
  }

  /// It cannot leave its curve, only the end of it, if its energy takes it there: Throws Diverged
  /// with the time at which the last step went over it.
  void check(double t, double state, double rate) const {
    if (path().closed) return;
    const double over = state < first_ ? state - first_ : state > last_ ? state - last_ : 0.0;
    if (over == 0.0) return;
    const double end = over < 0.0 ? path().first : path().last;
    const double fall = 2.0 * gravity_ * (path()(end).x.y() - path()(start_q_).x.y());
    if (!pull && !(start_speed_ * start_speed_ + fall > 0.0))
      throw mechanics::Diverged(
          mechanics::at(t) +
          fmt::format("its steps take the bead over the end of the wire, q = {:.6g}, which its "
                      "energy does not reach",
                      end));
    double a = 0.0;  // in the step: over = rate τ − a τ²/2
    self().acceleration(t, state, rate, a);
    const double root = std::sqrt(std::max(0.0, rate * rate - 2.0 * a * over));
    const double since = 2.0 * over / (rate + std::copysign(root, rate));
    throw mechanics::Diverged(
        fmt::format("where the bead leaves the wire at t = {:.9g} s, at its end q = {:.6g}",
                    std::max(0.0, std::isfinite(since) ? t - since : t), end),
        mechanics::Trouble::ended);
  }

  mechanics::Measures measures(double, double state, double rate) const {
    const Now now = self().now(state, rate);
    const Vector2d x = path()(now.q).x, v = now.speed * tangent(now);
    const double kinetic = 0.5 * mass_ * now.speed * now.speed;
    return {.energy = kinetic - mass_ * gravity_ * x.y(),
            .constraint_error = 0.0,  // there is none to break
            .velocity_error = 0.0,
            .kinetic = kinetic,
            .load = force(x, v).norm(),
            .drive = force(x, v).norm() / std::sqrt(mass_)};
  }
  void cover(double state, mechanics::Reach& reach) const {
    const Vector2d x = path()(self().now(state, 0.0).q).x;
    reach.cover(x.x(), x.y());
  }
  double free_acceleration(double, double, double) const { return gravity_; }
  std::string culprit(double, double state, double rate) const {
    const Now now = self().now(state, rate);
    return fmt::format("q = {:.3g}, speed {:.2g} m/s", now.q, now.speed);
  }

  mechanics::Columns columns() const {
    return {{"q", "speed", "particle.x", "particle.y", "particle.vx", "particle.vy"},
            {"particle_path.fx", "particle_path.fy", "particle_path.moment"}};
  }
  mechanics::Uses uses() const {
    return {.things = 1,
            .coordinates = 1,
            .rows = 0,
            .rank = 0,
            .state_bytes = 2 * sizeof(Vector),
            .workspace_bytes = sizeof(Self),
            .left_out = {"the constraint and its force", "all matrices"}};
  }
  void observe(double, double state, double rate, mechanics::Row& row) const {
    const Now now = self().now(state, rate);
    const Vector2d x = path()(now.q).x, v = now.speed * tangent(now);
    row.state = {now.q, now.speed, x.x(), x.y(), v.x(), v.y()};
    Vector2d on_bead = constraint_force(now);
    if (!on_bead.allFinite()) on_bead.setConstant(std::numeric_limits<double>::quiet_NaN());
    row.reactions = {on_bead.x(), on_bead.y(), 0.0};
  }

  const paths::Path& path() const { return wire_.path(); }
  Vector2d tangent(double q) const { return wire_.tangent(q); }

 protected:
  /// At a knot the bead is on the piece that it moves on to; at rest on that to which the force
  /// pulls it, or on none: it stays in the corner.
  enum class On { ahead, behind, none };
  On on(const Now& now) const {
    if (now.speed > 0.0 || !path().is_knot(now.q)) return On::ahead;
    if (now.speed < 0.0) return On::behind;
    const Vector2d F = force(path()(now.q).x, Vector2d::Zero());
    if (wire_.tangent(now.q).dot(F) > 0.0) return On::ahead;
    return wire_.tangent(now.q, true).dot(F) < 0.0 ? On::behind : On::none;
  }
  paths::Place place(const Now& now) const {
    return on(now) == On::behind ? path().behind(now.q) : path()(now.q);
  }
  /// Of that piece; zero on none. A state that is no number has none either: the run stops by it.
  Vector2d tangent(const Now& now) const {
    if (!std::isfinite(now.q)) return Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    const On piece = on(now);
    if (piece == On::none) return Vector2d::Zero();
    return wire_.tangent(now.q, piece == On::behind);
  }

  /// Throws std::invalid_argument where the start is not on the wire.
  explicit BeadOnWire(const Scene& scene)
      : wire_(wire_of(scene)),
        mass_(scene.mass),
        gravity_(scene.gravity),
        start_q_(scene.q0),
        start_speed_(scene.speed) {
    if (!path().closed && !(scene.q0 >= path().first && scene.q0 <= path().last))
      throw std::invalid_argument(
          fmt::format("q0 {:g}: allowed is a place on the wire, {:g} to {:g}", scene.q0,
                      path().first, path().last));
  }

  paths::ByLength wire_;
  double mass_, gravity_, start_q_, start_speed_;
  double start_ = 0.0, start_rate_ = 0.0;
  double first_ = 0.0, last_ = 0.0;  ///< of the state, on an open wire

 private:
  const Self& self() const { return static_cast<const Self&>(*this); }
};

/// The bead by the parameter of its path. Newton's law along x′, in which the wire has no part:
///
///     q̈ = (x′·F/m − x′·x″ q̇²) / x′·x′
class BeadByParameter : public BeadOnWire<BeadByParameter> {
 public:
  explicit BeadByParameter(const Scene& scene) : BeadOnWire(scene) {
    const double stretch = place({scene.q0, scene.speed}).d.norm();
    if (vanishes(stretch))
      throw std::invalid_argument(
          fmt::format("q0 {:g}: there x' = 0, and the equation of q divides by it; allowed is "
                      "another place, or --by length",
                      scene.q0));
    start_ = scene.q0;
    start_rate_ = scene.speed / stretch;
    first_ = path().first;
    last_ = path().last;
  }

  void acceleration(double t, double q, double qdot, double& qddot) const {
    const auto [x, d, dd] = place({q, qdot});
    if (d.allFinite() && vanishes(d.norm())) no_equation(t, q);
    qddot = (d.dot(force(x, qdot * d)) / mass_ - d.dot(dd) * qdot * qdot) / d.squaredNorm();
    if (on({q, qdot}) == On::none) qddot = 0.0;
  }

  Now now(double q, double qdot) const { return {q, qdot * place({q, qdot}).d.norm()}; }

 private:
  bool vanishes(double stretch) const {
    return !(stretch > 1e-9 * wire_.length() / (path().last - path().first));
  }
  [[noreturn]] static void no_equation(double t, double q) {
    throw mechanics::Diverged(
        mechanics::at(t) +
        fmt::format("x' = 0 at q = {:.6g}, and the equation of q divides by it", q));
  }
};

/// The bead by the length s of its wire. |dx/ds| = 1, so that nothing is left of it but
///
///     s̈ = t·F/m,
///
/// a force that depends on the place alone, and x″ is not needed.
class BeadByLength : public BeadOnWire<BeadByLength> {
 public:
  explicit BeadByLength(const Scene& scene) : BeadOnWire(scene) {
    start_ = wire_.s(scene.q0);
    start_rate_ = scene.speed;
    last_ = wire_.length();
  }

  // [by_length]
  void acceleration(double, double s, double sdot, double& sddot) const {
    const Now now{wire_.q(s), sdot};
    const Vector2d t = tangent(now);
    sddot = t.dot(force(path()(now.q).x, sdot * t)) / mass_;
  }
  // [by_length]

  Now now(double s, double sdot) const { return {wire_.q(s), sdot}; }
};

}  // namespace any_wire
