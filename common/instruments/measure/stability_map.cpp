#include "instruments/measure/stability_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "mechanics/integrators/amplification.hpp"
#include "mechanics/motion/watch.hpp"

namespace measure {
namespace {

/// Theory's verdicts at 1 exactly, on an axis of the plane, must not hang on rounding.
bool stable_in_theory(double growth) { return growth <= 1.0 + 1e-12; }

/// How large the plane of each integrator is: somewhat more than where it is stable.
struct Extent {
  double kd_h, ks_h2;
};
constexpr Extent extents[] = {{5.0, 5.0}, {3.0, 5.0}, {20.0, 100.0}, {7.0, 11.0}, {16.0, 56.0}};
static_assert(std::size(extents) == integrators::schemes.size());

mechanics::Method with_gains(integrators::Scheme name, double kd_h, double ks_h2, double h) {
  return {name, mechanics::Stabilization::feedback, ks_h2 / (h * h), kd_h / h};
}

}  // namespace

Largest run_and_watch(mechanics::Simulation& simulation, long steps, double h) {
  mechanics::Watch watch(simulation);
  Largest largest(simulation.measures());
  run(simulation, {steps, h}, watch, largest);
  return largest;
}

int Map::compared() const {
  return static_cast<int>(
      std::count_if(cells.begin(), cells.end(), [](const Cell& cell) { return cell.compared; }));
}

int Map::agreeing() const {
  return static_cast<int>(std::count_if(cells.begin(), cells.end(), [](const Cell& cell) {
    return cell.compared && cell.stable == cell.theory;
  }));
}

Map measure_map(const Plan& plan, int across, const Progress& progress) {
  Map map{plan, across, {}};
  const double width = plan.x_max / across, height = plan.y_max / across;
  const auto theory = [&](double x, double y) { return stable_in_theory(plan.growth(x, y)); };
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < across; ++i) {
      const double x = (i + 0.5) * width, y = (j + 0.5) * height;
      Cell cell{x, y, plan.stable(x, y), theory(x, y), y <= plan.theory_to};
      for (const double dx : {-0.5, 0.0, 0.5})
        for (const double dy : {-0.5, 0.0, 0.5})
          cell.compared &= theory(x + dx * width, y + dy * height) == cell.theory;
      map.cells.push_back(cell);
      if (progress)
        progress(static_cast<double>(map.cells.size()) / (across * across), plan.title());
    }
  return map;
}

bool feedback_decays(const Start& start, const mechanics::Method& method,
                     const FeedbackTrial& trial) {
  constexpr long looks = 32;  // in each quarter
  const long stride = std::max(1L, trial.steps / (4 * looks));
  const auto simulation = start(method);
  simulation->nudge(trial.nudge);
  const double at_start = simulation->measures().constraint_error;
  std::array<double, 4> largest{};  // of each quarter
  try {
    for (double& most : largest)
      if (!run(*simulation, {looks * stride, trial.step, stride},
               [&](const mechanics::Measures& now) {
                 most = std::max(most, now.constraint_error);
                 return now.finite() && now.constraint_error <= 1e6 * at_start;
               }))
        return false;
  } catch (const mechanics::Diverged&) {
    return false;
  }
  // What is left far below the start is what the motion itself makes, step by step.
  return largest[3] < largest[1] || largest[3] < 0.01 * at_start;
}

std::vector<Plan> feedback_plans(const Start& start, const FeedbackTrial& trial) {
  std::vector<Plan> plans;
  for (const auto& scheme : integrators::schemes) {
    const Extent& extent = extents[static_cast<std::size_t>(scheme.id)];
    plans.push_back({scheme.id, "k_d h", "k_s h²", extent.kd_h, extent.ks_h2,
                     [=, name = scheme.id](double kd_h, double ks_h2) {
                       return feedback_decays(start, with_gains(name, kd_h, ks_h2, trial.step),
                                              trial);
                     },
                     [name = scheme.id](double kd_h, double ks_h2) {
                       return integrators::amplification(name, 1.0, ks_h2, kd_h);
                     }});
    plans.back().of_gains = true;
  }
  return plans;
}

double measured_limit(integrators::Scheme name, const Start& start, const FeedbackTrial& trial) {
  double stable = 0.0, unstable = 8.0;
  for (int i = 0; i < 14; ++i) {
    const double s = 0.5 * (stable + unstable);
    const mechanics::Method method = with_gains(name, 2.0 * s, s * s, trial.step);
    (feedback_decays(start, method, trial) ? stable : unstable) = s;
  }
  return stable;
}

double theoretical_limit(integrators::Scheme name) {
  return std::min(8.0, integrators::largest_stable_step(name, 1.0, 2.0));
}

double LongCurve::exponent() const {
  const Look& last = looks.back();
  const auto tenth = std::find_if(looks.begin(), looks.end(),
                                  [&](const Look& look) { return look.t >= 0.1 * last.t; });
  return std::log(last.energy_error / tenth->energy_error) / std::log(last.t / tenth->t);
}

LongCurve long_run(mechanics::Simulation& simulation, const LongMethod& method, long steps,
                   double h) {
  constexpr int looks = 40;           // in the curve
  constexpr long most_measures = 64;  // between two of them
  constexpr long swings = 1000;       // steps, in which the scene has moved as fast as it does
  LongCurve curve{.method = method.method.label(), .expected_bounded = method.bounded};
  Largest largest(simulation.measures());
  double kinetic = largest.kinetic;  // in the first steps alone
  long done = 0;
  try {
    mechanics::Watch watch(simulation);
    for (int look = 1; look <= looks; ++look) {
      const double part = std::pow(static_cast<double>(steps), static_cast<double>(look) / looks);
      const long until = std::max(done + 1, std::lround(part));
      const long stride = std::max(1L, (until - done) / most_measures);
      run(simulation, {until - done, h, stride}, watch, largest, [&](const mechanics::Measures&) {
        done = std::min(until, done + stride);
        if (done <= swings) kinetic = largest.kinetic;
      });
      curve.looks.push_back({simulation.time(), largest.energy_error});
    }
  } catch (const mechanics::Diverged& diverged) {
    curve.failure = diverged.what();
  }
  for (LongCurve::Look& look : curve.looks) look.energy_error /= kinetic;
  return curve;
}

}  // namespace measure
