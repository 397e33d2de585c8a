#pragma once

#include <Eigen/Core>
#include <vector>

#include "scene.hpp"

namespace dumbbell {

/// The exact state of the beads, and the exact forces that hold them.
struct Exact {
  Vector2d x1, x2, v1, v2;        ///< [m], [m/s]
  Vector2d curve1, curve2, rod1;  ///< of the curve on each bead, of the rod on bead1 [N]
};

/// The exact motion of the dumbbell, to rounding, at any time.
///
/// Two beads on x² + 2py = 0 have a chord of slope −σ, σ = (x1 + x2)/2p. A rod of length l makes it
/// x2 − x1 = L/c, with c = √(1 + σ²) and L = ±l. So σ alone says where both beads are,
///
///     x1 = pσ − L/2c,   x2 = pσ + L/2c,   y = −x²/2p,
///
/// and no value of σ is left out. With M = m1 + m2 the energies are
///
///     T = ½ μ(σ) σ̇²,   μ = Σ m (dx/dσ)² (1 + x²/p²)
///     V = A σ² + B σ/c + D/c²,   A = M g p/2,  B = (m2 − m1) g L/2,  D = M g L²/8p.
///
/// From rest at σ0 the dumbbell swings to the next place σ1 of the same V and back, for ever. There
/// V(σ0) − V(σ) = (σ0 − σ)(σ − σ1) Q(σ), and with σ = (σ0 + σ1)/2 + (σ0 − σ1)/2 cos u the roots
/// cancel: dt/du = √(μ/2Q) is smooth, from u = 0 to π there and on to 2π back. Q is the second
/// divided difference V[σ0, σ, σ1]; written out, nothing in it is a difference of close numbers.
///
/// All of it in long double, so that the rounding of t itself is what limits the positions.
class ExactMotion {
 public:
  explicit ExactMotion(const Scene& scene);

  /// Whether anything pulls the dumbbell away from its start.
  bool moves() const { return slope(sigma0_) != 0; }

  /// Time from one turning point back to it [s]; infinite at rest.
  double period() const;

  /// At t ≥ 0 [s].
  Exact at(double t) const;

 private:
  using Real = long double;

  /// A bead's x and its first two derivatives by σ; side −1 for bead1, +1 for bead2.
  struct Bead {
    Real x, dx, ddx;
  };
  Bead bead(Real s, int side) const;
  Real inertia(Real s) const;  // μ

  /// V[σ0, s] = (V(s) − V(σ0))/(s − σ0): zero at the other turning point; V'(σ0) at σ0.
  Real slope(Real s) const;
  /// Q = V[σ0, s, σ1], and the size of the terms that it is the sum of.
  struct Bend {
    Real Q, size;
  };
  Bend bend(Real s) const;

  /// The first zero of V[σ0, s] on the side to which V falls. With z = s/c it is a cubic in z,
  /// which is monotonous between the zeros of its derivative: each piece is searched by bisection.
  Real turning_point() const;

  Real sigma(Real u) const;
  Real dt_du(Real u) const;

  /// ∫ dt/du du by a rule of 61 points. `error` is how far the rule of 30 points inside it is off.
  Real integrate(Real from, Real to, Real* error = nullptr) const;

  /// Cuts [from, to] into pieces on which the rule is as good as the rounding of Q allows. That is
  /// large where the dumbbell all but rests on the top of a hill. A piece that it crosses in next
  /// to no time, of the `about` that half a period takes, need not be good in itself.
  void add_pieces(Real from, Real to, Real about);

  /// The u at which t(u) = t, by Newton's steps inside a bracket.
  Real invert(Real t) const;

  /// Positions and velocities at σ, σ̇; and the forces by Newton's law for each bead. The curve
  /// pushes across itself only, so the rod's force is what moves the beads along the curve.
  Exact state(Real s, Real rate) const;

  Real m1_, m2_, p_, g_, sigma0_ = 0, sigma1_ = 0, L_ = 0, A_ = 0, B_ = 0, D_ = 0;
  struct Piece {
    Real u, t;  ///< where it begins
  };
  std::vector<Piece> pieces_;
  Real half_period_ = 0;
};

}  // namespace dumbbell
