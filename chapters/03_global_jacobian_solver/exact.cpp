#include "exact.hpp"

#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace dumbbell {
namespace {

constexpr long double pi = std::numbers::pi_v<long double>;

long double c(long double s) { return std::hypot(1.0L, s); }
/// tan(φ/2), where tan φ = s.
long double half_tan(long double s) { return s / (1 + c(s)); }

}  // namespace

ExactMotion::ExactMotion(const Scene& scene)
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

double ExactMotion::period() const {
  return moves() ? static_cast<double>(2 * half_period_) : std::numeric_limits<double>::infinity();
}

Exact ExactMotion::at(double t) const {
  if (!moves()) return state(sigma0_, 0);
  // Only the way there is ever inverted: the way back is the same, run backwards.
  const Real halves = std::floor(t / half_period_);
  const Real rest = std::clamp(t - halves * half_period_, Real(0), half_period_);
  const bool back = std::fmod(halves, Real(2)) != 0;
  const Real u = invert(back ? half_period_ - rest : rest);
  const Real rate = -(sigma0_ - sigma1_) / 2 * std::sin(u) / dt_du(u);
  return state(sigma(u), back ? -rate : rate);
}

ExactMotion::Bead ExactMotion::bead(Real s, int side) const {
  const Real C = c(s), h = static_cast<Real>(side) * L_ / 2;
  return {p_ * s + h / C, p_ - h * s / (C * C * C), h * (2 * s * s - 1) / std::pow(C, Real(5))};
}

ExactMotion::Real ExactMotion::inertia(Real s) const {
  const auto part = [&](Real m, const Bead& b) {
    return m * std::pow(b.dx * c(b.x / p_), Real(2));
  };
  return part(m1_, bead(s, -1)) + part(m2_, bead(s, 1));
}

ExactMotion::Real ExactMotion::slope(Real s) const {
  const Real C0 = c(sigma0_), C = c(s), tt = half_tan(sigma0_) * half_tan(s);
  return A_ * (sigma0_ + s) + B_ / (C0 * C) * (1 - tt) / (1 + tt) -
         D_ * (sigma0_ + s) / (C0 * C0 * C * C);
}

ExactMotion::Bend ExactMotion::bend(Real s) const {
  const Real C = c(sigma0_) * c(s) * c(sigma1_);
  const Real a = half_tan(sigma0_), b = half_tan(s), d = half_tan(sigma1_);
  const Real pairs = a * b + b * d + d * a;
  const Real sine = ((a + b + d) - a * b * d * pairs) / ((1 + a * b) * (1 + b * d) * (1 + d * a));
  const Real square = (sigma0_ * s + s * sigma1_ + sigma1_ * sigma0_ - 1) / (C * C);
  return {A_ - B_ * sine / C + D_ * square, A_ + std::abs(B_ * sine / C) + std::abs(D_ * square)};
}

ExactMotion::Real ExactMotion::turning_point() const {
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

ExactMotion::Real ExactMotion::sigma(Real u) const {
  return (sigma0_ + sigma1_) / 2 + (sigma0_ - sigma1_) / 2 * std::cos(u);
}

ExactMotion::Real ExactMotion::integrate(Real from, Real to, Real* error) const {
  using Rule = boost::math::quadrature::gauss_kronrod<Real, 61>;
  Real doubt = 0;  // of the mean, times 2
  const Real sum =
      Rule::integrate([this](Real u) { return dt_du(u); }, from, to, 0, Real(0), &doubt);
  if (error != nullptr) *error = doubt * std::abs(to - from) / 2;
  return sum;
}

void ExactMotion::add_pieces(Real from, Real to, Real about) {
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

ExactMotion::Real ExactMotion::invert(Real t) const {
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

Exact ExactMotion::state(Real s, Real rate) const {
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

ExactMotion::Real ExactMotion::dt_du(Real u) const {
  return std::sqrt(inertia(sigma(u)) / (2 * bend(sigma(u)).Q));
}

}  // namespace dumbbell
