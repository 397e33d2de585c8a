#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "scene.hpp"

namespace revolute {

/// What the program is measured against.
struct Exact {
  Vector2d end, end_velocity;  ///< of the last rod's free end [m], [m/s]
  Vector2d pin_force;          ///< of the world on the first rod [N]
};

/// The angle of a single rod and its rate.
struct Swing {
  double theta, omega;  ///< [rad], [rad/s]
};

/// At time t [s], by Jacobi's elliptic functions. With φ = θ − π/2 from hanging straight down,
/// φ̈ = −Ω0² sin φ, and from rest sin(φ/2) = k cd(Ω0 t), k = sin(φ(0)/2). In 50 digits: close to
/// upright k is so close to 1 that its 17th digit decides, and after thousands of periods t has
/// lost digits too.
Swing swing(const Scene& scene, double t);

/// The single rod. The pin force is what Newton's law gives beyond the weight.
Exact exact_pendulum(const Scene& scene, double t);

/// A chain of two or more, which has no closed form. Lagrange's equations in the angles θi alone,
/// where no pin can open:
///
///   Σj Mij cos(θi − θj) θ̈j = − Σj Mij sin(θi − θj) θ̇j² + gi cos θi
///
/// Mij = m l² (N − max(i, j) − ½) off the diagonal (i from 0), and m l² (N − i − ⅔) on it;
/// gi = m g l (N − i − ½). Integrated with order 8 in long double, with an error of its own far
/// below the one that is measured.
class ChainReference {
 public:
  using Real = long double;
  using Vector = Eigen::Vector<Real, Eigen::Dynamic>;
  using State = std::vector<Real>;  // θ of each rod, then ω of each

  explicit ChainReference(const Scene& scene) : scene_(scene) {}

  Vector acceleration(const State& y) const;

  /// The angles and their rates at t [s]. Nothing where that would take more than about a second or
  /// where, in chaos, nothing holds any more: where an integration with a hundred times the
  /// tolerance is more than 1e-6 rad away, and so this one perhaps 1e-8.
  std::optional<State> at(double t) const;

  Real theta(const State& y, int i) const { return y[std::size_t(i)]; }
  Real omega(const State& y, int i) const { return y[std::size_t(scene_.links + i)]; }

  std::optional<Exact> exact(double t) const;

 private:
  /// From one time to another; false where that takes more evaluations than are left.
  bool integrate(State& y, Real now, Real end, Real tolerance, long& evaluations) const;

  Scene scene_;
};

/// Longer chains are left without an exact answer: the reference solves a full matrix.
inline constexpr int longest_with_exact_answer = 10;

}  // namespace revolute
