#include "app/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mechanics/integrators/amplification.hpp"

namespace app {
namespace {

/// A number rounded down to three digits: a limit must not be rounded up.
double rounded_down(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
  return std::floor(value / unit) * unit;
}

/// The step up to which the feedback is stable, 0 where none is; nothing where it is stable as it
/// is.
std::optional<double> limit_of_feedback(const measure::RunOptions& run) {
  const auto& method = run.method;
  if (method.stabilization != mechanics::Stabilization::feedback || method.tolerance > 0.0 ||
      integrators::amplification(method.integrator, run.step, method.ks, method.kd) <= 1.0 + 1e-12)
    return std::nullopt;
  const double limit = integrators::largest_stable_step(method.integrator, method.ks, method.kd);
  // Bisection ends somewhere even where nothing but 0 is stable.
  const bool never = limit * std::max(std::sqrt(method.ks), method.kd) < 1e-4;
  return never ? 0.0 : rounded_down(limit);
}

/// The options in effect that leave out a term, as they are given.
std::string left_out(const Chapter& chapter) {
  std::string options;
  for (const Parameter& parameter : chapter.parameters)
    if (parameter.option.starts_with(without) && parameter.value() != 0.0)
      options.append(options.empty() ? "" : " ")
          .append("--without ")
          .append(parameter.option.substr(without.size()));
  return options;
}

}  // namespace

std::optional<std::string> fault_of_gains(const measure::RunOptions& run) {
  const auto limit = limit_of_feedback(run);
  if (!limit) return std::nullopt;
  const mechanics::Method& method = run.method;
  return fmt::format("feedback with ks = {:g} 1/s², kd = {:g} 1/s cannot be stable with {} at {}",
                     method.ks, method.kd, integrators::info(method.integrator).text,
                     *limit < run.duration / mechanics::most_steps
                         ? std::string(*limit == 0.0 ? "any step" : "any step that is allowed")
                         : fmt::format("a step of {:g} s, only up to {:.3g} s", run.step, *limit));
}

std::string advice(const Chapter& chapter, const measure::RunOptions& run,
                   mechanics::Trouble trouble) {
  if (trouble == mechanics::Trouble::ended) return "try a shorter --duration";
  if (const std::string terms = left_out(chapter); !terms.empty())
    return terms + " leaves out a term of the equation, which no shorter step makes up for";
  const Cure cure = chapter.cure ? chapter.cure() : Cure{};
  if (cure.alone) return "try " + cure.option;
  const mechanics::Method& method = run.method;
  const bool feedback = method.stabilization == mechanics::Stabilization::feedback;
  const double shortest = run.duration / mechanics::most_steps;
  const char* const projection = feedback ? "--stabilization projection in place of --ks and --kd"
                                          : "--stabilization projection";
  if (trouble == mechanics::Trouble::singular) return "try " + std::string(projection);
  std::vector<std::string> ways;
  if (!cure.option.empty()) ways.push_back(cure.option);
  if (const auto limit = limit_of_feedback(run)) {
    if (*limit > shortest) ways.push_back(fmt::format("a --step of {:.3g} s or less", *limit));
    ways.emplace_back("smaller gains");
  } else if (trouble == mechanics::Trouble::tolerance) {
    if (method.tolerance < mechanics::coarsest_allowed) ways.emplace_back("a larger --tolerance");
    ways.emplace_back("a --step without --tolerance");
  } else if (method.tolerance > 0.0) {
    if (method.tolerance > 2.0 * mechanics::finest_tolerance)
      ways.emplace_back("a smaller --tolerance");
  } else if (run.step > 2.0 * shortest) {
    ways.emplace_back("a smaller --step");
  }
  if (chapter.has_constraints && trouble != mechanics::Trouble::late &&
      method.stabilization != mechanics::Stabilization::projection)
    ways.emplace_back(projection);
  if (method.tolerance == 0.0) ways.emplace_back("another --integrator");
  if (ways.empty()) ways.emplace_back("a shorter --duration");
  std::string text = "try " + ways[0];
  for (std::size_t i = 1; i < ways.size(); ++i)
    text += (i + 1 < ways.size() ? ", " : " or ") + ways[i];
  return text;
}

}  // namespace app
