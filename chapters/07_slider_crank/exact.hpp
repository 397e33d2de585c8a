#pragma once

#include <Eigen/Core>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <optional>
#include <vector>

#include "measure/simulation.hpp"
#include "scene.hpp"

namespace slider_crank {

using Real = long double;

/// The mechanism by its one degree of freedom, the wheel's angle θ: places of its bodies, their
/// first and second derivatives with respect to θ, and what follows from them.
///
///     crank pin  P = r (cos θ, sin θ)
///     slider     s = r cos θ + c,  c = √(L² − r² sin²θ)          on the rail y = 0
///     rod        centre (r cos θ + c/2, r sin θ/2), angle φ with sin φ = −r sin θ/L, cos φ = c/L
///
///     M(θ) = Iw + mr (x'² + y'²) + Ir φ'² + ms s'²               T = ½ M θ̇²
///     M θ̈ + ½ M' θ̇² = τ + mr g y'                                 Lagrange's equation
class Reduced {
 public:
  struct Derivatives {
    Real value, first, second;
  };

  explicit Reduced(const Scene& scene)
      : r(scene.crank),
        L(scene.rod),
        torque(scene.torque),
        g(scene.gravity),
        wheel_mass(scene.wheel_mass),
        rod_mass(scene.rod_mass),
        slider_mass(scene.slider_mass),
        wheel_inertia(wheel_mass * Real(scene.wheel_radius) * Real(scene.wheel_radius) / 2),
        rod_inertia(rod_mass * L * L / 12) {}

  struct Pose {
    Derivatives s, x, y, phi;
  };

  Pose pose(Real theta) const {
    const Real sine = std::sin(theta), cosine = std::cos(theta);
    if (L == r)  // c = r cos θ with its sign: the branch that momentum keeps through θ = ±π/2
      return {{2 * r * cosine, -2 * r * sine, -2 * r * cosine},
              {3 * r * cosine / 2, -3 * r * sine / 2, -3 * r * cosine / 2},
              {r * sine / 2, r * cosine / 2, -r * sine / 2},
              {-theta, -1, 0}};
    const Real c = std::sqrt(L * L - r * r * sine * sine);
    const Real c1 = -r * r * sine * cosine / c;
    const Real c2 = -r * r * ((cosine * cosine - sine * sine) * c - sine * cosine * c1) / (c * c);
    return {{r * cosine + c, -r * sine + c1, -r * cosine + c2},
            {r * cosine + c / 2, -r * sine + c1 / 2, -r * cosine + c2 / 2},
            {r * sine / 2, r * cosine / 2, -r * sine / 2},
            {-std::asin(r * sine / L), -r * cosine / c, r * (sine * c + cosine * c1) / (c * c)}};
  }

  Real M(const Pose& at) const {
    return wheel_inertia + rod_mass * (at.x.first * at.x.first + at.y.first * at.y.first) +
           rod_inertia * at.phi.first * at.phi.first + slider_mass * at.s.first * at.s.first;
  }

  Real angular_acceleration(const Pose& at, Real omega) const {
    const Real half_dM = rod_mass * (at.x.first * at.x.second + at.y.first * at.y.second) +
                         rod_inertia * at.phi.first * at.phi.second +
                         slider_mass * at.s.first * at.s.second;
    return (torque + rod_mass * g * at.y.first - half_dM * omega * omega) / M(at);
  }

  /// τ (θ − θ0) − (V(θ) − V(θ0)) = τ δ + ½ mr g r (sin θ − sin θ0), the difference written as a
  /// product so that it keeps its digits where δ is small.
  Real work(Real theta0, Real delta) const {
    return torque * delta + rod_mass * g * r * std::cos(theta0 + delta / 2) * std::sin(delta / 2);
  }

  Real r, L, torque, g, wheel_mass, rod_mass, slider_mass, wheel_inertia, rod_inertia;
};

/// The exact motion. Energy gives the speed at every angle, ½ M(θ) θ̇² = ½ M(θ0) ω0² + work(θ), so
/// where the crank turns one way t(θ) is a quadrature, which is inverted; with θ = θ0 ± u² it has
/// no singularity at a start from rest. Where the crank turns back the reduced equation is
/// integrated with a relative tolerance of 1e-17, which keeps the energy to about 1e-14 of itself.
/// All of it in long double.
class Exact {
 public:
  struct State {
    Real theta, omega;
  };

  explicit Exact(const Scene& scene)
      : reduced_(scene),
        theta0_(scene.theta0),
        omega0_(scene.omega0),
        start_(reduced_.M(reduced_.pose(theta0_)) * omega0_ * omega0_ / 2) {
    const Real push = reduced_.angular_acceleration(reduced_.pose(theta0_), 0);
    sign_ = omega0_ != 0 ? (omega0_ > 0 ? 1 : -1) : (push < 0 ? -1 : 1);
    at_rest_for_ever_ = omega0_ == 0 && push == 0;
  }

  /// The state at t ≥ 0 [s].
  State at(double t) const {
    if (t == 0 || at_rest_for_ever_) return {theta0_, omega0_};
    if (const auto state = by_quadrature(t)) return *state;
    return by_integration(t);
  }

  /// By the inverted quadrature; nothing where the crank turns back before t.
  std::optional<State> by_quadrature(double t) const {
    Real sum = 0;
    for (int piece = 0;; ++piece) {
      const Real a = std::sqrt(step * piece), b = std::sqrt(step * (piece + 1));
      const auto whole = time(a, b);
      if (!whole || piece > most_pieces) return std::nullopt;
      if (sum + *whole < t) {
        sum += *whole;
        continue;
      }
      Real low = a, high = b, u = a + (b - a) * (t - sum) / *whole;
      for (int i = 0; i < 100; ++i) {
        const auto part = time(a, u);
        if (!part) return std::nullopt;
        const Real excess = sum + *part - t;
        (excess > 0 ? high : low) = u;
        Real next = u - excess / *dt_du(u);
        if (!(next >= low && next <= high)) next = (low + high) / 2;
        const bool done = std::abs(next - u) <= 4 * std::numeric_limits<Real>::epsilon() * b;
        u = next;
        if (done) break;
      }
      const Real delta = sign_ * u * u;
      return State{theta0_ + delta, sign_ * speed(delta)};
    }
  }

  /// By the reduced equation of motion.
  State by_integration(double t) const {
    using Pair = std::array<Real, 2>;
    boost::numeric::odeint::bulirsch_stoer<Pair, Real> stepper(1e-17L, 1e-17L);
    Pair state{theta0_, omega0_};
    const auto equation = [this](const Pair& now, Pair& rate, Real) {
      rate = {now[1], reduced_.angular_acceleration(reduced_.pose(now[0]), now[1])};
    };
    boost::numeric::odeint::integrate_adaptive(stepper, equation, state, Real(0), Real(t),
                                               Real(1e-3));
    return {state[0], state[1]};
  }

 private:
  static constexpr Real step = 0.25L;  // of θ, for each quadrature
  static constexpr int most_pieces = 4000000;

  /// ½ M θ̇² at θ0 + δ; negative where the crank cannot get.
  Real kinetic(Real delta) const { return start_ + reduced_.work(theta0_, delta); }
  Real speed(Real delta) const {
    return std::sqrt(2 * std::max<Real>(0, kinetic(delta)) /
                     reduced_.M(reduced_.pose(theta0_ + delta)));
  }
  std::optional<Real> dt_du(Real u) const {
    const Real delta = sign_ * u * u;
    if (!(kinetic(delta) > 0)) return std::nullopt;
    return 2 * u / speed(delta);
  }
  std::optional<Real> time(Real a, Real b) const {
    if (a == b) return 0;
    bool turns_back = false;
    Real error = 0;
    const Real result = boost::math::quadrature::gauss_kronrod<Real, 41>::integrate(
        [&](Real u) {
          const auto value = dt_du(u);
          turns_back |= !value;
          return value.value_or(0);
        },
        a, b, 5, Real(1e-16), &error);
    if (turns_back || !(error <= 1e-13L * result)) return std::nullopt;
    return result;
  }

  Reduced reduced_;
  Real theta0_, omega0_, start_;
  Real sign_ = 1;
  bool at_rest_for_ever_ = false;
};

/// What holds the mechanism together: force [N] and moment [N·m] on the body each joint's name
/// starts with.
struct Reactions {
  Eigen::Vector2d wheel_frame, rod_wheel, slider_rod, slider_frame, frame_ground;
  double frame_ground_moment;
};

/// From Newton's and Euler's laws, body by body, with the accelerations that θ, θ̇ and θ̈ give.
inline Reactions reactions(const Scene& scene, const Exact::State& state) {
  const Reduced reduced(scene);
  const auto at = reduced.pose(state.theta);
  const Real omega = state.omega, alpha = reduced.angular_acceleration(at, omega);
  const auto acceleration = [&](const Reduced::Derivatives& f) {
    return f.first * alpha + f.second * omega * omega;
  };
  const Real g = scene.gravity, m = scene.rod_mass, L = scene.rod;
  const Real ex = std::cos(at.phi.value), ey = std::sin(at.phi.value);
  // Slider along the rail; then the rod turns about its centre under the forces at both ends.
  const Real Rx = scene.slider_mass * acceleration(at.s);
  const Real px = m * acceleration(at.x), py = m * (acceleration(at.y) - g);
  const Real Ry =
      (-2 * reduced.rod_inertia * acceleration(at.phi) / L - (ex * py - ey * px) + 2 * ey * Rx) /
      (2 * ex);
  const Real N = -Ry - scene.slider_mass * g;
  const Eigen::Vector2d slider_rod(Rx, Ry), slider_frame(0, N);
  const Eigen::Vector2d rod_wheel(px + Rx, py + Ry);
  const Eigen::Vector2d wheel_frame = rod_wheel - Eigen::Vector2d(0, scene.wheel_mass * g);
  const Eigen::Vector2d frame_ground =
      wheel_frame + slider_frame - Eigen::Vector2d(0, scene.frame_mass * g);
  return {wheel_frame,  rod_wheel,    slider_rod,
          slider_frame, frame_ground, static_cast<double>(at.s.value * N)};
}

/// Errors of a row: wheel angle [rad], its rate [rad/s], and all joint forces together [N].
inline std::vector<double> errors(const Scene& scene, const measure::Columns& columns,
                                  const measure::Row& row) {
  const Exact::State state = Exact(scene).at(row.t);
  const Reactions truth = reactions(scene, state);
  const auto find = [](const std::vector<std::string>& names, const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const auto force = [&](const std::string& joint) {
    const std::size_t i = find(columns.reactions, joint + ".fx");
    return Eigen::Vector2d(row.reactions[i], row.reactions[i + 1]);
  };
  const double squares = (force("wheel_frame") - truth.wheel_frame).squaredNorm() +
                         (force("rod_wheel") - truth.rod_wheel).squaredNorm() +
                         (force("slider_rod") - truth.slider_rod).squaredNorm() +
                         (force("slider_frame") - truth.slider_frame).squaredNorm();
  const Real theta = row.state[find(columns.state, "wheel.theta")];
  const Real omega = row.state[find(columns.state, "wheel.omega")];
  return {static_cast<double>(std::abs(theta - state.theta)),
          static_cast<double>(std::abs(omega - state.omega)), std::sqrt(squares)};
}

}  // namespace slider_crank
