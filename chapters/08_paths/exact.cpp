#include "exact.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <limits>
#include <numbers>

namespace any_wire {
namespace {

constexpr double pi = std::numbers::pi;

}  // namespace

std::optional<State> on_cycloid(double R, double g, const State& start, double t) {
  const double s0 = 4 * R * std::sin(start.q / 2), v0 = start.speed, omega = std::sqrt(g / (4 * R));
  const double c = std::cos(omega * t), s = std::sin(omega * t);
  const double way = g > 0 ? s0 * c + v0 / omega * s : s0 + v0 * t,
               speed = g > 0 ? v0 * c - s0 * omega * s : v0;
  const double widest = g > 0 ? std::hypot(s0, v0 / omega) : std::abs(way);
  if (widest > 4 * R * (1 + 1e-12)) {  // it leaves, sooner or later; the others may tell when
    return std::nullopt;
  }
  return State{2 * std::asin(std::clamp(way / (4 * R), -1.0, 1.0)), speed};
}

EnergyMotion::EnergyMotion(Wire wire, double g, const State& start)
    : wire_(std::move(wire)), g_(g), start_(start) {
  // A closed wire is the same after each round.
  if (wire_.closed) {
    const double round = wire_.last - wire_.first;
    before_ = std::floor((start.q - wire_.first) / round) * round;
    start_.q -= before_;
  }
  const double q0 = start_.q, v0_given = start_.speed;
  const double little = 1e-9 * (wire_.last - wire_.first);
  // A speed that is spent within rounding of the start is none.
  const double spent = v0_given * v0_given / (2 * g_ * std::abs(wire_.slope(q0)));
  const double v0 = spent < 1e-6 * little ? 0.0 : v0_given;
  const auto falls = [&](int direction) {
    const double q = q0 + direction * little;
    return g_ > 0.0 && (wire_.closed || (q >= wire_.first && q <= wire_.last)) &&
           direction * wire_.slope(q) > 1e-12 * wire_.stretch(q);
  };
  const bool level = std::abs(wire_.slope(q0)) <= 1e-14 * wire_.stretch(q0),
             ridge = falls(1) && falls(-1), knot = is_knot(q0);
  rests_ = v0 == 0.0 && (ridge ? level && !knot : !falls(1) && !falls(-1));
  holds_ = v0 != 0.0 || !(ridge && knot);  // else it may fall to either side
  if (rests_ || !holds_) return;
  const int direction = v0 != 0.0 ? (v0 > 0.0 ? 1 : -1)
                        : ridge   ? (wire_.slope(q0) > 0.0 ? 1 : -1)
                                  : (falls(1) ? 1 : -1);
  legs_.push_back(leg(q0, direction, wire_.depth(q0), v0 * v0));
  for (int i = 1; i < 3 && legs_.back().turns; ++i) {
    const double turn = legs_.back().from + legs_.back().whole;
    legs_.push_back(leg(turn, i == 1 ? -direction : direction, wire_.depth(turn), 0.0));
  }
}

double EnergyMotion::Leg::way(double phi) const {
  // From both ends, so that what is left to them is exact.
  const double part = std::pow(std::sin(phi / 2), 2), rest = std::pow(std::cos(phi / 2), 2);
  return phi < pi / 2 ? whole * part : whole - whole * rest;
}

double EnergyMotion::energy(const Leg& leg, double way) const {
  if (std::abs(way) > 0.05 * (wire_.last - wire_.first) ||
      (leg.ends.size() > 2 && std::abs(way) > std::abs(leg.ends[2])))
    return leg.v2 + 2 * g_ * (wire_.depth(leg.from + way) - leg.y0);
  // A small fall, which would be lost in the rounding of its two depths, from knot to knot.
  double fall = 0.0, begin = 0.0;
  for (std::size_t i = 0; i <= leg.ends.size() && begin != way; ++i) {
    const bool last = i == leg.ends.size() || std::abs(leg.ends[i]) > std::abs(way);
    const double end = last ? way : leg.ends[i], half = (end - begin) / 2;
    fall += half * boost::math::quadrature::gauss<double, 10>::integrate(
                       [&](double x) { return wire_.slope(leg.from + (begin + half + half * x)); });
    begin = end;
  }
  return leg.v2 + 2 * g_ * fall;
}

bool EnergyMotion::is_knot(double q) const {
  const double near = 1e-14 * (wire_.last - wire_.first);
  return (wire_.closed && std::min(q - wire_.first, wire_.last - q) <= near) ||
         std::any_of(wire_.knots.begin(), wire_.knots.end(),
                     [=](double knot) { return std::abs(q - knot) <= near; });
}

double EnergyMotion::dt_dphi(const Leg& leg, double phi) const {
  const double way = leg.way(phi), v2 = energy(leg, way);
  return std::abs(leg.whole) / 2 * std::sin(phi) * wire_.stretch(leg.from + way) /
         std::sqrt(std::max(v2, std::numeric_limits<double>::min()));
}

double EnergyMotion::time(const Leg& leg, double from, double to) const {
  return boost::math::quadrature::gauss<double, 20>::integrate(
      [&](double phi) { return dt_dphi(leg, phi); }, from, to);
}

EnergyMotion::Leg EnergyMotion::leg(double from, int direction, double y0, double v2) {
  const double width = wire_.last - wire_.first;
  // Knots and, on a closed wire, where it begins again, in the order of the way, from its
  // beginning.
  std::vector<double> ends;
  for (const double turn :
       wire_.closed ? std::vector{-2.0, -1.0, 0.0, 1.0, 2.0} : std::vector{0.0}) {
    const double shift =
        (turn + (wire_.closed ? std::floor((from - wire_.first) / width) : 0)) * width;
    for (const double knot : wire_.knots) ends.push_back(knot + shift - from);
    ends.push_back(wire_.first + shift - from);
    ends.push_back(wire_.last + shift - from);
  }
  if (wire_.closed) ends.push_back(direction * width);
  std::sort(ends.begin(), ends.end(),
            [&](double a, double b) { return direction * a < direction * b; });
  std::erase_if(ends, [&](double q) {
    return direction * q <= 0.0 || (wire_.closed && direction * q > width * (1 + 1e-15));
  });

  Leg leg{from, ends.empty() ? 0.0 : ends.back(), false, y0, v2, ends};
  const auto moves = [&](double way) { return energy(leg, way) > 0.0; };
  const int looks =  // between two knots
      std::clamp(20000 / static_cast<int>(wire_.knots.size() + 1), 20, 1000);
  double before = 0.0;
  bool moved = v2 > 0.0;
  for (const double end : ends) {
    const double begin = before;
    for (int k = begin == 0.0 ? -40 : 1; k <= looks && !leg.turns; ++k) {  // small swings, too
      const double part = k > 0 ? k : std::ldexp(1.0, k - 1);
      const double way = k == looks ? end : begin + (end - begin) * part / looks;
      moved = moved || k > 1 || moves(way);
      if (moved && !moves(way)) {
        double low = before, high = way;
        for (int i = 0; i < 200; ++i) {
          const double middle = low + (high - low) / 2;
          (moves(middle) ? low : high) = middle;
        }
        leg.whole = high;
        leg.turns = true;
      }
      if (!leg.turns) before = way;
    }
    if (leg.turns) break;
  }

  std::vector<double> cuts;
  constexpr int pieces = 64;
  for (int i = 0; i <= pieces; ++i) cuts.push_back(pi * i / pieces);
  for (const double end : ends) {
    const double cosine = 1 - 2 * end / leg.whole;
    if (std::abs(cosine) < 1) cuts.push_back(std::acos(cosine));
  }
  std::sort(cuts.begin(), cuts.end());
  leg.cuts.push_back({0.0, 0.0});
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const double a = cuts[i - 1], b = cuts[i], t = time(leg, a, b), m = (a + b) / 2;
    holds_ =
        holds_ && std::abs(time(leg, a, m) + time(leg, m, b) - t) <= 1e-9 * (t + leg.cuts.back().t);
    leg.cuts.push_back({b, leg.cuts.back().t + t});
  }
  return leg;
}

State EnergyMotion::in(const Leg& leg, double t) const {
  const auto next = std::upper_bound(leg.cuts.begin() + 1, leg.cuts.end() - 1, t,
                                     [](double time, const Leg::Cut& cut) { return time < cut.t; });
  double low = (next - 1)->phi, high = next->phi;
  double phi = low + (high - low) * (t - (next - 1)->t) / (next->t - (next - 1)->t);
  for (int i = 0; i < 100; ++i) {
    const double excess = (next - 1)->t + time(leg, (next - 1)->phi, phi) - t;
    (excess > 0 ? high : low) = phi;
    double step = phi - excess / dt_dphi(leg, phi);
    if (!(step >= low && step <= high)) step = low + (high - low) / 2;
    if (std::abs(step - phi) <= 1e-16 * pi) break;
    phi = step;
  }
  const double way = leg.way(phi);
  return {leg.from + way, std::copysign(std::sqrt(std::max(0.0, energy(leg, way))), leg.whole)};
}

std::optional<State> EnergyMotion::at(double t) const {
  std::optional<State> state = since_last_round(t);
  if (state) state->q += before_;
  return state;
}

std::optional<State> EnergyMotion::since_last_round(double t) const {
  if (rests_ || t <= 0.0) return start_;
  if (!holds_) return std::nullopt;
  if (legs_.size() == 1 && wire_.closed) {  // around and around
    const double round = legs_[0].duration(), rounds = std::floor(t / round);
    State state = in(legs_[0], t - rounds * round);
    state.q += rounds * legs_[0].whole;
    return state;
  }
  for (const Leg& leg : legs_) {
    if (t <= leg.duration()) return in(leg, t);
    t -= leg.duration();
  }
  if (legs_.size() < 3) return std::nullopt;
  // There and back between the two turning points, which the second way and the third have found.
  const double period = legs_[1].duration() + legs_[2].duration();
  t -= std::floor(t / period) * period;
  return t <= legs_[1].duration() ? in(legs_[1], t) : in(legs_[2], t - legs_[1].duration());
}

double EnergyMotion::end() const {
  if (rests_ || legs_.back().turns || wire_.closed) return std::numeric_limits<double>::infinity();
  double t = 0.0;
  for (const Leg& leg : legs_) t += leg.duration();
  return t;
}

}  // namespace any_wire
