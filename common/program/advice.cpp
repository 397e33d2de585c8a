#include "program/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "integrators/amplification.hpp"

namespace program {
namespace {

/// A number rounded down to three digits: a limit must not be rounded up.
double rounded_down(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
  return std::floor(value / unit) * unit;
}

/// The step up to which the feedback is stable, 0 where none is; nothing where it is stable as it
/// is.
std::optional<double> limit_of_feedback(const RunOptions& run) {
  const auto& method = run.method;
  if (method.stabilization != measure::Stabilization::feedback || method.tolerance > 0.0 ||
      integrators::amplification(method.integrator, run.step, method.ks, method.kd) <= 1.0 + 1e-12)
    return std::nullopt;
  const double limit = integrators::largest_stable_step(method.integrator, method.ks, method.kd);
  // Bisection ends somewhere even where nothing but 0 is stable.
  const bool never = limit * std::max(std::sqrt(method.ks), method.kd) < 1e-4;
  return never ? 0.0 : rounded_down(limit);
}

}  // namespace

std::optional<std::string> fault_of_gains(const RunOptions& run) {
  const auto limit = limit_of_feedback(run);
  if (!limit) return std::nullopt;
  const measure::Method& method = run.method;
  return fmt::format("feedback with ks = {:g} 1/s², kd = {:g} 1/s cannot be stable with {} at {}",
                     method.ks, method.kd, integrators::method(method.integrator).text,
                     *limit == 0.0
                         ? std::string("any step")
                         : fmt::format("a step of {:g} s, only up to {:.3g} s", run.step, *limit));
}

std::string advice(const Chapter& chapter, const RunOptions& run) {
  if (const auto limit = limit_of_feedback(run))
    return *limit == 0.0 ? std::string("another --integrator, or --stabilization projection")
                         : fmt::format(
                               "a --step of {:.3g} s or less, smaller gains, or "
                               "--stabilization projection",
                               *limit);
  std::string text = run.method.tolerance > 0.0 ? "a larger --tolerance" : "a smaller --step";
  if (chapter.has_constraints && run.method.stabilization == measure::Stabilization::none)
    text += ", --stabilization projection";
  return text + " or another --integrator";
}

}  // namespace program
