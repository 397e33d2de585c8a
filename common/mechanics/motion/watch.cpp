#include "mechanics/motion/watch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string_view>

#include "mechanics/integrators/amplification.hpp"

namespace mechanics {
namespace {

std::string said(double value, const char* unit) { return in_digits(value) + " " + unit; }

std::string percent(double part) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), part < 0.1 ? "%.2g %%" : "%.0f %%", 100.0 * part);
  return text.data();
}

constexpr double closed = 1e-9;     // of the coordinates: a start that is no further off
constexpr double rounding = 1e-12;  // of an energy, gathered over a long run
constexpr double rounding_of_a_run = 1e-11;
constexpr double of_nothing = 1e3;      // a larger part is one of next to nothing, and not told
constexpr double unstable_may = 100.0;  // times the start, before feedback that grows is stopped

}  // namespace

void Growth::take(double t, double value) {
  if (!(value > most_)) return;
  most_ = value;
  t_ = t;
  if (notes_.empty() || value > 1.05 * notes_.back().value) notes_.push_back({t, value});
}

double Growth::since(double level) const {
  const auto note = std::upper_bound(notes_.begin(), notes_.end(), level,
                                     [](double l, const Note& n) { return l < n.value; });
  return note == notes_.end() ? t_ : note->t;
}

std::string Verdict::text() const {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += "; ";
    text += fault.words;
  }
  return text;
}

std::string Verdict::words() const {
  std::string words;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    if (i > 0) words += i + 1 < faults.size() ? ", " : " and ";
    words += faults[i].what;
  }
  return words;
}

Watch::Watch(Simulation& simulation)
    : simulation_(simulation),
      start_(simulation.measures()),
      last_(start_),
      speed_(std::sqrt(2.0 * start_.kinetic)),
      distance_(0.0),
      t_(simulation.time()),
      balance_(start_.kept()),
      largest_kinetic_(start_.kinetic),
      largest_energy_(0.0),
      largest_load_(start_.load),
      largest_state_(simulation.state_size()),
      largest_speed_(start_.speed) {
  simulation_.cover(reach_);
  const double off = closed * std::max(reach_.size(), reach_.furthest());
  open_ = simulation_.method().stabilization != Stabilization::none && start_.opening > off;
  if (simulation_.method().stabilization == Stabilization::feedback)
    distance_ = simulation_.distance();
  if (simulation_.method().tolerance == 0.0) return;
  look_inside_ =
      std::make_shared<const std::function<void()>>([this] { look(simulation_.measures()); });
  simulation_.watch_steps(look_inside_);
}

// Feedback swings higher than its start before it decays: by the method's own factor at this step.
double Watch::speed_of_feedback() const {
  const Method& method = simulation_.method();
  if (distance_ == 0.0) return 0.0;
  double swing = 1.0;
  if (method.tolerance == 0.0)
    swing = integrators::largest_swing(method.integrator, simulation_.step(), method.ks, method.kd);
  if (!std::isfinite(swing)) swing = unstable_may;
  return 4.0 * swing * std::sqrt(method.ks) * distance_;
}

bool Watch::feedback_is_stable() const {
  const Method& method = simulation_.method();
  return method.tolerance > 0.0 || integrators::amplification(method.integrator, simulation_.step(),
                                                              method.ks, method.kd) <= 1.0 + 1e-12;
}

// What feedback without a stable step makes of an open start does not end well, though the forces
// of the scene may for long be able to do as much.
void Watch::stop_unstable_feedback() {
  if (!open_ || simulation_.method().stabilization != Stabilization::feedback ||
      feedback_is_stable())
    return;
  const double now = simulation_.distance();
  if (!(now <= unstable_may * distance_))
    throw Diverged(at(t_) + "the feedback has made the constraint error " +
                   said(now / distance_, "times") + " what it was at the start; " +
                   simulation_.culprit());
}

void Watch::look(const Measures& now) {
  const double t = simulation_.time();
  if (!now.finite()) throw Diverged(at(t) + "the energy or an error is no longer finite");
  if (!moved_ && t > t_) {  // now the step is known, and the start is closed that projection closes
    moved_ = true;
    speed_ += speed_of_feedback();
    taken_away_ = !(open_ && feedback_is_stable());
    if (open_ && simulation_.method().stabilization == Stabilization::projection)
      balance_ = now.kept();
  }
  speed_ += (t - t_) * std::max(last_.drive, now.drive);
  if (const double power = std::max(std::abs(last_.power), std::abs(now.power)); power > 0)
    speed_ = std::sqrt(speed_ * speed_ + 2 * (t - t_) * power);
  t_ = t;
  last_ = now;
  stop_unstable_feedback();
  const double most = 0.5 * speed_ * speed_;
  if (!(now.kinetic <= 2.0 * most + std::numeric_limits<double>::min()))
    throw Diverged(at(t) + "the kinetic energy is " + said(now.kinetic, "J") +
                   ", where its start and the forces can have made at most " + said(most, "J") +
                   "; " + simulation_.culprit());
  simulation_.cover(reach_);
  taken_away_ |= now.opening < far * start_.opening;
  if (taken_away_) opening_.take(t, now.opening - start_.opening);
  largest_kinetic_ = std::max(largest_kinetic_, now.kinetic);
  largest_load_ = std::max(largest_load_, now.load);
  largest_speed_ = std::max(largest_speed_, now.speed);
  largest_state_ = std::max(largest_state_, simulation_.state_size());
  largest_energy_ =
      std::max(largest_energy_, std::abs(now.energy) + std::abs(now.balances() ? now.work : 0.0));
  energy_.take(t, std::abs(now.balance() - balance_));
}

double Watch::largest_energy_error() const {
  return start_.balances() ? energy_.most() : std::numeric_limits<double>::quiet_NaN();
}

double Watch::energy_rounding() const {
  return rounding * (largest_load_ * reach_.size() + largest_energy_);
}

Verdict::Fault Watch::fault(const char* what, const std::string& which, double value,
                            const char* unit, double part, double since) const {
  const char* whole = std::string_view(what) == "energy"     ? "of the largest kinetic energy"
                      : std::string_view(what) == "velocity" ? "of the largest speed"
                                                             : "of the scene's size";
  std::string words = which + " " + said(value, unit);
  if (part < of_nothing) words += ", " + percent(part) + " " + whole;
  if (part < of_nothing && std::isfinite(since))
    words += " (above 1 % since t = " + said(since, "s") + ")";
  return {what, words, std::isfinite(since) ? Trouble::wrong : Trouble::late};
}

Verdict Watch::verdict(double position_error, double angle_error, double velocity_error) const {
  constexpr double at_the_end = std::numeric_limits<double>::infinity();
  Verdict verdict;
  const double size = reach_.size(),
               far_off = std::max(far * size, rounding_of_a_run * reach_.furthest());
  if (const double opening = opening_.most(); opening > far_off)
    verdict.faults.push_back(fault("joints", "joints are open by", opening, "m", opening / size,
                                   opening_.since(far_off)));
  const bool balances = start_.balances();
  const double energy = balances ? energy_.most() : last_.kept() - balance_,
               allowed = std::max(far * largest_kinetic_, energy_rounding());
  const bool feedback = simulation_.method().stabilization == Stabilization::feedback;
  if (energy > allowed && !(open_ && feedback))
    verdict.faults.push_back(fault(
        "energy",
        balances ? "the energy balance is off by"
                 : "the energy, from which the loads only take, is above that of the start by",
        energy, "J", energy / largest_kinetic_, balances ? energy_.since(allowed) : at_the_end));
  const double error = std::max(position_error, angle_error * reach_.largest_radius());
  if (error > far_off)
    verdict.faults.push_back(
        fault("position", "the position is off by", error, "m", error / size, at_the_end));
  const double slow = rounding_of_a_run * size / t_;  // crosses the scene in 1e11 such runs
  if (!balances && velocity_error > std::max(far * largest_speed_, slow))
    verdict.faults.push_back(fault("velocity", "the velocity is off by", velocity_error, "m/s",
                                   velocity_error / largest_speed_, at_the_end));
  if (simulation_.method().tolerance > 0.0)
    judge_tolerance(std::max(position_error, angle_error), verdict);
  return verdict;
}

void Watch::judge_tolerance(double error, Verdict& verdict) const {
  const double tolerance = simulation_.method().tolerance, size = largest_state_ + reach_.size();
  const double steps = static_cast<double>(std::max(1L, simulation_.steps())),
               mean = simulation_.time() / steps;
  const bool collapsed = simulation_.shortest_step() < 1e-3 * mean;
  const double allowed = (collapsed ? 20.0 : 200.0) * tolerance * largest_kinetic_;
  const bool feedback = simulation_.method().stabilization == Stabilization::feedback;
  const bool energy_off =
      energy_.most() > std::max(allowed, energy_rounding()) && !(open_ && feedback);
  // Where each step's error shifts the energy a little, the phase falls behind as their square.
  const double grown = tolerance * std::max(50.0, 1e-3 * steps * steps);
  const bool state_off = error > std::max(grown, rounding_of_a_run) * size;
  if (!energy_off && !state_off) return;
  std::string words = "the tolerance of " + in_digits(tolerance) + " was not kept: ";
  words += energy_off ? "the energy balance is off by " +
                            (energy_.most() < of_nothing * largest_kinetic_
                                 ? in_digits(energy_.most() / largest_kinetic_) +
                                       " of the largest kinetic energy"
                                 : said(energy_.most(), "J"))
                      : "the state is off by " + in_digits(error / size) + " of its size";
  if (collapsed)
    words += ", and the steps fell to " + in_digits(simulation_.shortest_step() / mean) +
             " of their mean";
  verdict.faults.push_back({"tolerance", words, collapsed ? Trouble::tolerance : Trouble::late});
}

}  // namespace mechanics
