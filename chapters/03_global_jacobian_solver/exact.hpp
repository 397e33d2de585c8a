#pragma once

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "mechanics/motion/motion.hpp"
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
  explicit ExactMotion(const Scene& scene)
      : m1_(scene.m1), m2_(scene.m2), p_(scene.p), g_(scene.gravity) {
    const Real x1 = scene.x1, x2 = scene.x2;
    sigma0_ = (x1 + x2) / (2 * p_);
    L_ = (x2 - x1) * c(sigma0_);
    A_ = (m1_ + m2_) * g_ * p_ / 2;
    B_ = (m2_ - m1_) * g_ * L_ / 2;
    D_ = (m1_ + m2_) * g_ * L_ * L_ / (8 * p_);
    if (!moves()) return;
    sigma1_ = turning_point();
    // Far up the valley dt/du bends sharply where σ = 0: a cut there.
    const Real cosine = -(sigma0_ + sigma1_) / (sigma0_ - sigma1_);
    const Real cut = std::abs(cosine) < 1 ? std::acos(cosine) : pi;
    const Real about = integrate(0, cut) + integrate(cut, pi);
    add_pieces(0, cut, about);
    add_pieces(cut, pi, about);
  }

  /// Whether anything pulls the dumbbell away from its start.
  bool moves() const { return slope(sigma0_) != 0; }

  /// Time from one turning point back to it [s]; infinite at rest.
  double period() const {
    return moves() ? static_cast<double>(2 * half_period_)
                   : std::numeric_limits<double>::infinity();
  }

  /// At t ≥ 0 [s].
  Exact at(double t) const {
    if (!moves()) return state(sigma0_, 0);
    // Only the way there is ever inverted: the way back is the same, run backwards.
    const Real halves = std::floor(t / half_period_);
    const Real rest = std::clamp(t - halves * half_period_, Real(0), half_period_);
    const bool back = std::fmod(halves, Real(2)) != 0;
    const Real u = invert(back ? half_period_ - rest : rest);
    const Real rate = -(sigma0_ - sigma1_) / 2 * std::sin(u) / dt_du(u);
    return state(sigma(u), back ? -rate : rate);
  }

 private:
  using Real = long double;
  static constexpr Real pi = std::numbers::pi_v<Real>;

  static Real c(Real s) { return std::hypot(Real(1), s); }
  /// tan(φ/2), where tan φ = s.
  static Real half_tan(Real s) { return s / (1 + c(s)); }

  /// A bead's x and its first two derivatives by σ; side −1 for bead1, +1 for bead2.
  struct Bead {
    Real x, dx, ddx;
  };
  Bead bead(Real s, int side) const {
    const Real C = c(s), h = static_cast<Real>(side) * L_ / 2;
    return {p_ * s + h / C, p_ - h * s / (C * C * C), h * (2 * s * s - 1) / std::pow(C, Real(5))};
  }
  Real inertia(Real s) const {  // μ
    const auto part = [&](Real m, const Bead& b) {
      return m * std::pow(b.dx * c(b.x / p_), Real(2));
    };
    return part(m1_, bead(s, -1)) + part(m2_, bead(s, 1));
  }

  /// V[σ0, s] = (V(s) − V(σ0))/(s − σ0): zero at the other turning point; V'(σ0) at σ0.
  Real slope(Real s) const {
    const Real C0 = c(sigma0_), C = c(s), tt = half_tan(sigma0_) * half_tan(s);
    return A_ * (sigma0_ + s) + B_ / (C0 * C) * (1 - tt) / (1 + tt) -
           D_ * (sigma0_ + s) / (C0 * C0 * C * C);
  }
  /// Q = V[σ0, s, σ1], and the size of the terms that it is the sum of.
  struct Bend {
    Real Q, size;
  };
  Bend bend(Real s) const {
    const Real C = c(sigma0_) * c(s) * c(sigma1_);
    const Real a = half_tan(sigma0_), b = half_tan(s), d = half_tan(sigma1_);
    const Real pairs = a * b + b * d + d * a;
    const Real sine = ((a + b + d) - a * b * d * pairs) / ((1 + a * b) * (1 + b * d) * (1 + d * a));
    const Real square = (sigma0_ * s + s * sigma1_ + sigma1_ * sigma0_ - 1) / (C * C);
    return {A_ - B_ * sine / C + D_ * square, A_ + std::abs(B_ * sine / C) + std::abs(D_ * square)};
  }

  /// The first zero of V[σ0, s] on the side to which V falls. With z = s/c it is a cubic in z,
  /// which is monotonous between the zeros of its derivative: each piece is searched by bisection.
  Real turning_point() const {
    const bool falls_left = slope(sigma0_) > 0;
    const Real way = falls_left ? -1 : 1;
    const Real z0 = sigma0_ / c(sigma0_), k = 1 / (c(sigma0_) * c(sigma0_));
    std::vector<Real> ends;
    const Real a = 3 * k * D_, b = -k * (B_ - D_ * z0), root = b * b - a * (A_ - k * D_);
    if (root > 0 && a > 0)
      for (const Real z : {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a})
        if (std::abs(z) < 1) ends.push_back(z / std::sqrt((1 - z) * (1 + z)));
    // Beyond this A s² alone is above V(σ0).
    ends.push_back(way * (std::sqrt(sigma0_ * sigma0_ + (2 * std::abs(B_) + D_) / A_) + 1));
    std::sort(ends.begin(), ends.end(), [&](Real x, Real y) { return way * x < way * y; });
    Real low = sigma0_, high = sigma0_;
    for (const Real end : ends) {
      if (way * end <= way * sigma0_) continue;
      low = high;
      high = end;
      if ((slope(high) > 0) != falls_left) break;
    }
    for (int i = 0; i < 200; ++i) {
      const Real middle = low + (high - low) / 2;
      ((slope(middle) > 0) == falls_left ? low : high) = middle;
    }
    return high;
  }

  Real sigma(Real u) const {
    return (sigma0_ + sigma1_) / 2 + (sigma0_ - sigma1_) / 2 * std::cos(u);
  }
  Real dt_du(Real u) const { return std::sqrt(inertia(sigma(u)) / (2 * bend(sigma(u)).Q)); }

  /// ∫ dt/du du by a rule of 61 points. `error` is how far the rule of 30 points inside it is off.
  Real integrate(Real from, Real to, Real* error = nullptr) const {
    using Rule = boost::math::quadrature::gauss_kronrod<Real, 61>;
    Real doubt = 0;  // of the mean, times 2
    const Real sum =
        Rule::integrate([this](Real u) { return dt_du(u); }, from, to, 0, Real(0), &doubt);
    if (error != nullptr) *error = doubt * std::abs(to - from) / 2;
    return sum;
  }

  /// Cuts [from, to] into pieces on which the rule is as good as the rounding of Q allows. That is
  /// large where the dumbbell all but rests on the top of a hill. A piece that it crosses in next
  /// to no time, of the `about` that half a period takes, need not be good in itself.
  void add_pieces(Real from, Real to, Real about) {
    if (!(from < to)) return;
    const Real middle = from + (to - from) / 2;
    Real rounding = 0, error = 0;
    for (const Real u : {from, middle, to}) {
      const auto [Q, size] = bend(sigma(u));
      rounding = std::max(rounding, 1e-17L * size / Q);
    }
    const Real sum = integrate(from, to, &error);
    constexpr std::size_t most = 4000;
    if (error <= rounding * (sum + about / 100) || pieces_.size() > most || to - from < 1e-12L) {
      pieces_.push_back({from, half_period_});
      half_period_ += sum;
    } else {
      add_pieces(from, middle, about);
      add_pieces(middle, to, about);
    }
  }

  /// The u at which t(u) = t, by Newton's steps inside a bracket.
  Real invert(Real t) const {
    const auto later = [](Real time, const Piece& piece) { return time < piece.t; };
    const auto next_piece = std::upper_bound(pieces_.begin() + 1, pieces_.end(), t, later);
    const Piece& piece = *(next_piece - 1);
    Real low = piece.u, high = next_piece == pieces_.end() ? pi : next_piece->u;
    Real u = low + (t - piece.t) / dt_du(low);
    for (int i = 0; i < 200; ++i) {
      if (!(u >= low && u <= high)) u = low + (high - low) / 2;
      const Real excess = piece.t + integrate(piece.u, u) - t;
      (excess > 0 ? high : low) = u;
      const Real next = u - excess / dt_du(u);
      if (std::abs(next - u) <= 4 * std::numeric_limits<Real>::epsilon() * pi) return next;
      u = next;
    }
    return u;
  }

  /// Positions and velocities at σ, σ̇; and the forces by Newton's law for each bead. The curve
  /// pushes across itself only, so the rod's force is what moves the beads along the curve.
  Exact state(Real s, Real rate) const {
    using Vector = Eigen::Matrix<Real, 2, 1>;
    const std::array beads{bead(s, -1), bead(s, 1)};
    const std::array masses{m1_, m2_};
    const Real C = c(s);
    Real inertia_slope = 0;  // dμ/dσ
    for (int i = 0; i < 2; ++i) {
      const auto& [x, dx, ddx] = beads[static_cast<std::size_t>(i)];
      inertia_slope += masses[static_cast<std::size_t>(i)] * 2 * dx *
                       (ddx * (1 + x * x / (p_ * p_)) + x * dx * dx / (p_ * p_));
    }
    const Real force = -(2 * A_ * s + B_ / (C * C * C) - 2 * D_ * s / (C * C * C * C));
    const Real acceleration = (force - inertia_slope * rate * rate / 2) / inertia(s);

    const Vector along = Vector(1, -s) / C;  // the rod, up to its sense
    std::array<Vector, 2> place, velocity, needed, tangent;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto& [x, dx, ddx] = beads[i];
      const Real vx = dx * rate, ax = dx * acceleration + ddx * rate * rate;
      place[i] = {x, -x * x / (2 * p_)};
      velocity[i] = {vx, -x * vx / p_};
      needed[i] = masses[i] * Vector(ax, -(vx * vx + x * ax) / p_ - g_);
      tangent[i] = Vector(1, -x / p_).normalized();
    }
    const Real e1 = along.dot(tangent[0]), e2 = along.dot(tangent[1]);
    const Vector rod = (needed[0].dot(tangent[0]) * e1 - needed[1].dot(tangent[1]) * e2) /
                       (e1 * e1 + e2 * e2) * along;
    const auto rounded = [](const Vector& v) { return Vector2d(v.cast<double>()); };
    return {rounded(place[0]),    rounded(place[1]),        rounded(velocity[0]),
            rounded(velocity[1]), rounded(needed[0] - rod), rounded(needed[1] + rod),
            rounded(rod)};
  }

  Real m1_, m2_, p_, g_, sigma0_ = 0, sigma1_ = 0, L_ = 0, A_ = 0, B_ = 0, D_ = 0;
  struct Piece {
    Real u, t;  ///< where it begins
  };
  std::vector<Piece> pieces_;
  Real half_period_ = 0;
};

/// Distance to the exact state, over both beads, for position [m], velocity [m/s] and the forces of
/// both curves and the rod [N].
inline std::vector<double> errors(const Scene& scene, const mechanics::Row& row) {
  const Exact truth = ExactMotion(scene).at(row.t);
  const auto off = [](const std::vector<double>& values, std::size_t i, const Vector2d& exact) {
    return (Vector2d(values[i], values[i + 1]) - exact).squaredNorm();
  };
  const auto& [x1, x2, v1, v2, curve1, curve2, rod1] = truth;
  return {std::sqrt(off(row.state, 0, x1) + off(row.state, 4, x2)),
          std::sqrt(off(row.state, 2, v1) + off(row.state, 6, v2)),
          std::sqrt(off(row.reactions, 0, curve1) + off(row.reactions, 3, curve2) +
                    off(row.reactions, 6, rod1))};
}

}  // namespace dumbbell
