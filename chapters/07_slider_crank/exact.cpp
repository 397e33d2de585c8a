#include "exact.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace slider_crank {

Reduced::Reduced(const Scene& scene)
    : R(scene.crank),
      L(scene.rod),
      torque(scene.torque),
      g(scene.gravity),
      wheel_mass(scene.wheel_mass),
      rod_mass(scene.rod_mass),
      slider_mass(scene.slider_mass),
      wheel_inertia(wheel_mass * Real(scene.wheel_radius) * Real(scene.wheel_radius) / 2),
      rod_inertia(rod_mass * L * L / 12),
      pull(rod_mass * g * R / 2) {}

Reduced::Pose Reduced::pose(Real theta) const {
  const Real sine = std::sin(theta), cosine = std::cos(theta);
  if (L == R)  // c = R cos θ with its sign: the branch that momentum keeps through θ = ±π/2
    return {{2 * R * cosine, -2 * R * sine, -2 * R * cosine},
            {3 * R * cosine / 2, -3 * R * sine / 2, -3 * R * cosine / 2},
            {R * sine / 2, R * cosine / 2, -R * sine / 2},
            {-theta, -1, 0}};
  const Real c = std::sqrt(L * L - R * R * sine * sine);
  const Real c1 = -R * R * sine * cosine / c;
  const Real c2 = -R * R * ((cosine * cosine - sine * sine) * c - sine * cosine * c1) / (c * c);
  return {{R * cosine + c, -R * sine + c1, -R * cosine + c2},
          {R * cosine + c / 2, -R * sine + c1 / 2, -R * cosine + c2 / 2},
          {R * sine / 2, R * cosine / 2, -R * sine / 2},
          {-std::asin(R * sine / L), -R * cosine / c, R * (sine * c + cosine * c1) / (c * c)}};
}

Real Reduced::mu(const Pose& at) const {
  return wheel_inertia + rod_mass * (at.x.first * at.x.first + at.y.first * at.y.first) +
         rod_inertia * at.phi.first * at.phi.first + slider_mass * at.xs.first * at.xs.first;
}

Real Reduced::angular_acceleration(const Pose& at, Real omega) const {
  const Real half_dmu = rod_mass * (at.x.first * at.x.second + at.y.first * at.y.second) +
                        rod_inertia * at.phi.first * at.phi.second +
                        slider_mass * at.xs.first * at.xs.second;
  return (torque + rod_mass * g * at.y.first - half_dmu * omega * omega) / mu(at);
}

Reduced::Mark Reduced::mark(Real theta) const {
  const Real sine = std::sin(theta), cosine = std::cos(theta);
  return {theta, sine, cosine, torque + pull * cosine};
}

Reduced::Mark Reduced::moved(const Mark& from, Real delta) const {
  const Real sine = std::sin(delta), half = std::sin(delta / 2), versine = 2 * half * half;
  return {from.theta + delta, from.sine * std::cos(delta) + from.cosine * sine,
          from.cosine * std::cos(delta) - from.sine * sine,
          from.moment - pull * (from.cosine * versine + from.sine * sine)};
}

Real Reduced::work(const Mark& from, Real delta) const {
  const Real half = std::sin(delta / 2);
  if (std::abs(delta) > 1)
    return torque * delta +
           2 * pull * half * (from.cosine * std::cos(delta / 2) - from.sine * half);
  Real lag = 0, term = -delta * delta * delta / 6;  // sin δ − δ, by its series
  for (int n = 5; n < 27; n += 2) {
    lag += term;
    term *= -delta * delta / static_cast<Real>(n * (n - 1));
  }
  return from.moment * delta + pull * (from.cosine * lag - from.sine * 2 * half * half);
}

namespace {

/// A part of the motion on which the crank turns one way, from `from` in the direction `way` (±1).
/// There the angle gives the speed, by energy, and the time is a quadrature, ∫ dθ/θ̇. A place where
/// the crank comes to rest is a singularity of it, which a parameter ξ of the angle takes away:
///
///     from a speed          |θ − from| = ξ
///     from rest             |θ − from| = x²
///     from rest to rest     |θ − from| = length sin²(ξ/2), ξ from 0 to π
///
/// Close to a place of rest the energy is counted from there, so that it keeps its digits.
class Way {
 public:
  /// A parameter, and the time at which it is reached [s].
  struct Point {
    Real xi, t;
  };
  static constexpr Real pi = std::numbers::pi_v<Real>;
  static constexpr Real infinity = std::numeric_limits<Real>::infinity();

  static Way moving(const Reduced& reduced, const Reduced::Mark& from, Real way, Real kinetic) {
    return {reduced, from, way, kinetic, 0};
  }
  static Way from_rest(const Reduced& reduced, const Reduced::Mark& from, Real way) {
    return {reduced, from, way, 0, infinity};
  }
  static Way between(const Reduced& reduced, const Reduced::Mark& from, Real way, Real length) {
    return {reduced, from, way, 0, length};
  }

  Real theta(Real xi) const { return from_.theta + way_ * distance(xi); }
  /// |θ̇|.
  Real speed(Real xi) const {
    return std::sqrt(2 * std::max<Real>(0, kinetic(xi)) / reduced_.mu(reduced_.pose(theta(xi))));
  }

  /// From ξ = 0 until `ξ` or the time `t` is reached, whichever comes first. Nothing where that
  /// takes more work than there is left.
  std::optional<Point> go(Real xi, Real t) {
    Point now{0, 0};
    for (Real piece = longest; now.xi < xi; piece = std::min(2 * piece, longest)) {
      Real next = 0;
      std::optional<Real> time;
      for (;; piece /= 4) {
        next = std::min(xi, after(now.xi, piece));
        if (evaluations_left_ <= 0 || !(next > now.xi)) return std::nullopt;
        if ((time = integrate(now.xi, next, true))) break;
      }
      if (now.t + *time >= t) return Point{invert(now, next, t - now.t), t};
      now = {next, now.t + *time};
    }
    return now;
  }

 private:
  static constexpr Real longest = 2;  // piece of θ for each quadrature
  static constexpr int points = 41;   // of each quadrature

  Way(const Reduced& reduced, const Reduced::Mark& from, Real way, Real kinetic, Real length)
      : reduced_(reduced),
        from_(from),
        to_(length > 0 && length < infinity ? reduced.moved(from, way * length) : from),
        way_(way),
        start_(kinetic),
        length_(length) {}

  bool to_rest() const { return length_ > 0 && length_ < infinity; }
  Real distance(Real xi) const {
    if (length_ == 0) return xi;
    return to_rest() ? length_ * std::pow(std::sin(xi / 2), Real(2)) : xi * xi;
  }
  Real distance_rate(Real xi) const {
    if (length_ == 0) return 1;
    return to_rest() ? length_ * std::sin(xi) / 2 : 2 * xi;
  }
  Real after(Real xi, Real piece) const {
    if (length_ == 0) return xi + piece;
    return to_rest() ? xi + piece / std::max(Real(1), length_) : std::sqrt(xi * xi + piece);
  }
  /// ½ μ θ̇².
  Real kinetic(Real xi) const {
    if (to_rest() && xi > pi / 2)
      return reduced_.work(to_, -way_ * length_ * std::pow(std::cos(xi / 2), Real(2)));
    return start_ + reduced_.work(from_, way_ * distance(xi));
  }
  Real dt_dxi(Real xi) const { return distance_rate(xi) / speed(xi); }

  /// ∫ dt/dx dx. Asked to doubt, nothing where the rule of half the points inside it is off by so
  /// much that the rule itself could be off by more than rounding.
  std::optional<Real> integrate(Real from, Real to, bool doubt) {
    using Rule = boost::math::quadrature::gauss_kronrod<Real, points>;
    if (from == to) return 0;
    evaluations_left_ -= points;
    Real error = 0;  // of the mean, times 2
    const Real sum =
        Rule::integrate([this](Real xi) { return dt_dxi(xi); }, from, to, 0, Real(0), &error);
    if (doubt && !(error * (to - from) / 2 <= 1e-13L * sum)) return std::nullopt;
    return sum;
  }

  /// The ξ, up to `high`, that is reached so long after a point: by Newton's steps in a bracket.
  Real invert(const Point& after, Real high, Real t) {
    const Real scale = high;
    Real low = after.xi, xi = low + (high - low) / 2;
    for (int i = 0; i < 100; ++i) {
      const Real excess = *integrate(after.xi, xi, false) - t;
      (excess > 0 ? high : low) = xi;
      Real next = xi - excess / dt_dxi(xi);
      if (!(next >= low && next <= high)) next = low + (high - low) / 2;
      const bool done = std::abs(next - xi) <= 4 * std::numeric_limits<Real>::epsilon() * scale;
      xi = next;
      if (done) break;
    }
    return xi;
  }

  Reduced reduced_;
  Reduced::Mark from_, to_;
  Real way_, start_, length_;        // length: 0, of a way from a speed; infinite, from rest
  long evaluations_left_ = 1000000;  // about a second
};

}  // namespace

Exact::Exact(const Scene& scene)
    : reduced_(scene),
      mark_(reduced_.mark(scene.theta0)),
      omega0_(scene.omega0),
      start_(reduced_.mu(reduced_.pose(mark_.theta)) * omega0_ * omega0_ / 2) {
  const Real push = mark_.moment;
  way_ = omega0_ != 0 ? (omega0_ > 0 ? 1 : -1) : (push < 0 ? -1 : 1);
  at_rest_for_ever_ = omega0_ == 0 && push == 0;
  if (at_rest_for_ever_) return;
  ahead_ = turn(way_);
  behind_ = omega0_ == 0 ? Real(0) : turn(-way_);
}

std::optional<Exact::State> Exact::at(double t) const {
  if (t == 0 || at_rest_for_ever_) return State{mark_.theta, omega0_};
  const auto state = ahead_ && behind_                   ? swinging(t)
                     : ahead_                            ? turning_back(t)
                     : behind_ && *behind_ < 2 * Way::pi ? running_away(t)
                                                         : revolving(t);
  if (!state || !(std::abs(state->theta - mark_.theta) < 1e10L)) return std::nullopt;
  return state;
}

std::optional<Real> Exact::turn(Real way) const {
  const Real torque = reduced_.torque, pull = reduced_.pull;
  Real low = 0, high = 0;
  if (std::abs(torque) < pull) {
    // Energy has a top and a valley in each revolution, which differs from the next by 2πτ.
    const auto to = [&](Real from, Real angle) {
      const Real rest = std::fmod(way * (angle - from), 2 * Way::pi);
      return rest < 0 ? rest + 2 * Way::pi : rest;
    };
    const Real top = std::acos(-torque / pull), valley = -top;
    const Real first = to(mark_.theta, valley);
    const Real least = start_ + reduced_.work(mark_, way * first);
    const Real loss = -2 * Way::pi * way * torque;
    if (least > 0 && loss <= 0) return std::nullopt;
    high = first + (least > 0 ? std::ceil(least / loss) * 2 * Way::pi : 0);
    low = std::max(Real(0), high - to(top, valley));
  } else if (way * torque < 0) {
    high = (start_ + 2 * pull) / std::abs(torque);
  } else {
    return std::nullopt;
  }
  const auto energy = [&](Real delta) { return start_ + reduced_.work(mark_, way * delta); };
  if (!(energy(low) > 0)) low = 0;
  for (int i = 0; i < 500; ++i) {
    const Real middle = low + (high - low) / 2;
    if (middle == low || middle == high) break;
    (energy(middle) > 0 ? low : high) = middle;
  }
  return high;
}

std::optional<Exact::State> Exact::swinging(Real t) const {
  const Real length = *behind_ + *ahead_;
  Way way = Way::between(reduced_, reduced_.moved(mark_, -way_ * *behind_), way_, length);
  const auto start = way.go(2 * std::atan2(std::sqrt(*behind_), std::sqrt(*ahead_)), Way::infinity);
  const auto half = way.go(Way::pi, Way::infinity);
  if (!start || !half) return std::nullopt;
  Real now = std::fmod(start->t + t, 2 * half->t);
  const bool back = now > half->t;
  if (back) now = 2 * half->t - now;
  const auto end = way.go(Way::pi, now);
  if (!end) return std::nullopt;
  return State{way.theta(end->xi), (back ? -way_ : way_) * way.speed(end->xi)};
}

std::optional<Exact::State> Exact::turning_back(Real t) const {
  if (*ahead_ > 4) {  // it may not come that far
    Way there = Way::moving(reduced_, mark_, way_, start_);
    const auto end = there.go(*ahead_ - 3, t);
    if (!end) return std::nullopt;
    if (end->t == t) return State{there.theta(end->xi), way_ * there.speed(end->xi)};
  }
  return from_rest(reduced_.moved(mark_, way_ * *ahead_), -way_, *ahead_, t, true);
}

std::optional<Exact::State> Exact::running_away(Real t) const {
  return from_rest(reduced_.moved(mark_, -way_ * *behind_), way_, *behind_, t, false);
}

std::optional<Exact::State> Exact::from_rest(const Reduced::Mark& place, Real way_out,
                                             Real distance, Real t, bool before) const {
  Way way = Way::from_rest(reduced_, place, way_out);
  const auto start = way.go(std::sqrt(distance), Way::infinity);
  if (!start) return std::nullopt;
  const Real now = before ? t - start->t : t + start->t;
  const auto end = way.go(Way::infinity, std::abs(now));
  if (!end) return std::nullopt;
  return State{way.theta(end->xi), (now < 0 ? -way_out : way_out) * way.speed(end->xi)};
}

std::optional<Exact::State> Exact::revolving(Real t) const {
  Way way = Way::moving(reduced_, mark_, way_, start_);
  Real turns = 0;
  if (reduced_.torque == 0) {
    const auto once = way.go(2 * Way::pi, Way::infinity);
    if (!once) return std::nullopt;
    turns = std::floor(t / once->t);
    t = std::fmod(t, once->t);
  }
  const auto end = way.go(Way::infinity, t);
  if (!end) return std::nullopt;
  return State{way.theta(end->xi) + way_ * turns * 2 * Way::pi, way_ * way.speed(end->xi)};
}

Reactions reactions(const Scene& scene, const Exact::State& state) {
  const Reduced reduced(scene);
  const auto at = reduced.pose(state.theta);
  const Real omega = state.omega, alpha = reduced.angular_acceleration(at, omega);
  const auto acceleration = [&](const Reduced::Derivatives& f) {
    return f.first * alpha + f.second * omega * omega;
  };
  const Real g = scene.gravity, m = scene.rod_mass, L = scene.rod;
  const Real ex = std::cos(at.phi.value), ey = std::sin(at.phi.value);
  // Slider along the rail; then the rod turns about its centre under the forces at both ends.
  const Real Rx = scene.slider_mass * acceleration(at.xs);
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
          slider_frame, frame_ground, static_cast<double>(at.xs.value * N)};
}

}  // namespace slider_crank
