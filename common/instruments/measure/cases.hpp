#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "instruments/measure/stability_map.hpp"

namespace measure {

/// The methods that most cases are tried with.
namespace usual {
using integrators::Scheme;
using mechanics::Stabilization;
inline constexpr mechanics::Method rk4{Scheme::rk4};
inline constexpr mechanics::Method projected{Scheme::rk4, Stabilization::projection};
inline constexpr mechanics::Method midpoint{Scheme::implicit_midpoint, Stabilization::projection};
inline constexpr mechanics::Method dop853{Scheme::dop853, Stabilization::projection};
inline constexpr mechanics::Method adaptive{Scheme::dop853, Stabilization::projection, 0, 0, 1e-8};
constexpr mechanics::Method feedback(double ks, double kd, Scheme scheme = Scheme::rk4) {
  return {scheme, Stabilization::feedback, ks, kd};
}
}  // namespace usual

/// What a case is expected to end in, written beside the case.
struct Expected {
  enum class Outcome { accurate, degraded, refused } outcome;
  double least = 0.0, most = 0.0;  ///< the figure is in least … most; degraded: and no better
  std::string message = {};        ///< a part of what a refusal says
};
inline Expected accurate(double most) { return {Expected::Outcome::accurate, 0.0, most}; }
inline Expected degraded(double least, double most) {
  return {Expected::Outcome::degraded, least, most};
}
inline Expected refused(std::string message) {
  return {Expected::Outcome::refused, 0.0, 0.0, std::move(message)};
}

/// A stiff or extreme case of a scene.
struct Case {
  std::string name;    ///< "rod = crank, ten dead centres"
  std::string figure;  ///< what `run` returns, with its unit: "energy error, relative"
  Expected expected;
  std::function<double()> run;  ///< what it throws is a refusal
};

/// How a case ended.
struct CaseResult {
  std::string name, figure, expected, found;
  bool as_expected;
};

/// A run of very many steps, for each of some methods.
struct LongRun {
  long steps = 0;  ///< 0: the chapter has none
  double step = 0.0;
  std::vector<measure::LongMethod> methods = {};
  measure::Start start = {};
};

/// The same scene in two systems of units: the second's are so many of the first's.
struct Units {
  double length, time, mass;

  double acceleration() const { return length / (time * time); }
  double force() const { return mass * length / (time * time); }
  double moment() const { return mass * length * length / (time * time); }
  double inertia() const { return mass * length * length; }
};
/// Numbers of a scene in another unit.
inline void scale(std::initializer_list<double*> numbers, double unit) {
  for (double* number : numbers) *number *= unit;
}

/// What `stability` of a chapter tries.
struct Stability {
  std::vector<Case> cases;
  std::vector<measure::Plan> plans;
  std::string map_remark;  ///< said under the map: what it teaches
  LongRun long_run = {};

  /// Feedback in every integrator: its limit at critical damping, and the map of its gains.
  void add_feedback(const measure::Start& start, const measure::FeedbackTrial& trial);

  /// A case for each method: the scene, given in any units, moves alike in µm and 1e-8 kg, and in
  /// Mm and ms, over `steps` steps of h [s].
  void add_units(const std::function<measure::Start(const Units&)>& scene_in,
                 const std::vector<mechanics::Method>& methods, long steps, double h);
};

/// Runs one case.
CaseResult judge(const Case& trial);
/// How a map agrees with theory, as a case like the others.
CaseResult judge(const measure::Map& map);

/// What cases measure over `steps` steps of h [s]: the largest |C|; the largest energy error, as a
/// part of the kinetic energy; the error of a quantity against the exact answer at the end.
std::function<double()> drift(const measure::Start& start, const mechanics::Method& method,
                              long steps, double h);
std::function<double()> energy_error(const measure::Start& start, const mechanics::Method& method,
                                     long steps, double h);
std::function<double()> final_error(const measure::Start& start, const measure::Errors& errors,
                                    std::size_t quantity, const mechanics::Method& method,
                                    long steps, double h);

std::string table(const std::vector<CaseResult>& verdicts);
std::string table(const std::vector<measure::LongCurve>& curves);

/// Values with a header, separated by semicolons; and back, for the documents.
std::string csv(const std::vector<CaseResult>& verdicts);
std::string csv(const std::vector<measure::Map>& maps);
std::string csv(const std::vector<measure::LongCurve>& curves);
std::vector<CaseResult> read_verdicts(const std::filesystem::path& path);
std::vector<measure::LongCurve> read_curves(const std::filesystem::path& path);

}  // namespace measure
