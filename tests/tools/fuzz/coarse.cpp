#include "coarse.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "instruments/files/table.hpp"
#include "random.hpp"

namespace fuzz {
namespace {

constexpr double g = 9.81;

/// Writes the scene's options and returns the fastest rate of its motion [rad/s].
class Maker {
 public:
  Maker(Coarse& coarse, Random& random) : coarse_(coarse), random_(random) {}

  double scene() {
    switch (coarse_.chapter) {
      case 0:
      case 1:
        return bead();
      case 2:
        return dumbbell();
      case 3:
        return plate();
      case 4:
        return chain();
      case 5:
        return block();
      default:
        return slider_crank();
    }
  }

  void give(const std::string& option, double value) {
    coarse_.arguments.push_back(fmt::format("{}={:.6g}", option, value));
  }

 private:
  /// A value about the default, now and then the default itself.
  double some(const std::string& option, double usual, double decades = 0.5) {
    if (random_.chance(0.5)) return usual;
    const double value = std::stod(fmt::format("{:.6g}", usual * random_.scale(-decades, decades)));
    give(option, value);
    return value;
  }

  double bead() {
    const double x0 = some("--x0", 100.0), p = some("--p", 50.0), gravity = some("--gravity", g);
    coarse_.masses["particle"] = {some("--mass", 1.0), 0.0};
    coarse_.gradient = 2.0 * p;
    coarse_.bottom = 1.0;
    return std::sqrt(gravity / p) * std::hypot(1.0, x0 / p);
  }
  double dumbbell() {
    const double p = some("--p", 50.0, 0.2), gravity = some("--gravity", g);
    coarse_.masses["bead1"] = {some("--m1", 1.0), 0.0};
    coarse_.masses["bead2"] = {some("--m2", 2.0), 0.0};
    coarse_.gradient = std::min(2.0 * p, 40.0);
    return std::sqrt(gravity / p) * std::hypot(1.0, 60.0 / p);
  }
  double plate() {
    coarse_.masses["plate"] = {2.0, 2.0 * 0.52 / 12.0};
    coarse_.radius = 0.36;
    if (random_.chance(0.5)) give("--load", 0.0);
    if (random_.chance(0.7)) give("--offset-x", random_.scale(-4.0, 0.0));
    if (random_.chance(0.3)) give("--offset-theta", random_.scale(-4.0, 0.0));
    return 1.0;
  }
  double chain() {
    const int links = random_.chance(0.5) ? 1 : 1 + static_cast<int>(random_.below(6));
    give("--links", links);
    const double length = some("--length", 1.0), mass = some("--mass", 1.0);
    give("--angle0", random_.between(-3.0, 3.0));
    coarse_.radius = 0.5 * length / links;
    for (int i = 1; i <= links; ++i)
      coarse_.masses[links == 1 ? "rod" : fmt::format("rod{}", i)] = {
          mass / links, mass / links * std::pow(length / links, 2) / 12.0};
    return std::sqrt(1.5 * some("--gravity", g) / length) * links;
  }
  double block() {
    const double mass = some("--mass", 1.0);
    coarse_.masses["block"] = {mass, mass * 0.05 / 12.0};
    coarse_.radius = 0.11;
    some("--incline", 30.0);
    if (random_.chance(0.5)) return 1.0;
    const double spin = random_.scale(0.0, 1.3);
    give("--spin", spin);
    coarse_.masses["rail"] = {std::numeric_limits<double>::quiet_NaN(), 1.0};
    return spin;
  }
  double slider_crank() {
    const double crank = some("--crank", 0.3, 0.2), gravity = some("--gravity", g);
    const double torque = random_.chance(0.5) ? 0.0 : 2.0;
    give("--torque", torque);
    const double omega = random_.chance(0.5) ? 0.0 : random_.scale(0.0, 1.5);
    give("--omega0", omega);
    coarse_.masses["wheel"] = {2.0, 0.16};
    coarse_.masses["rod"] = {1.0, 1.0 / 12.0};
    coarse_.masses["slider"] = {1.5, 1.5 * 0.13 / 12.0};
    coarse_.radius = 0.5;
    return omega + std::sqrt(gravity / crank) + 5.0 * torque;
  }

  Coarse& coarse_;
  Random& random_;
};

/// The value behind a name in the summary, or nothing that is a number.
double printed(const std::string& out, const std::string& name) {
  const std::size_t at = out.find("  " + name + " ");
  return at == std::string::npos ? std::numeric_limits<double>::quiet_NaN()
                                 : std::strtod(out.c_str() + at + 2 + name.size(), nullptr);
}

/// What the trajectory shows: how far the scene reaches [m], and its largest kinetic energy [J].
struct Shown {
  double size = 0.0, kinetic = 0.0;
};

Shown read_table(const Coarse& coarse, const std::string& table) {
  std::istringstream stream(table);
  const double far = std::numeric_limits<double>::infinity();
  double left = coarse.bottom > 0.0 ? 0.0 : far, right = -left, top = left, low = -left;
  Shown shown;
  files::read_csv(stream, "the trajectory", [&](const files::SavedRow& row) {
    const auto value = [&](const std::string& name) {
      return std::strtod(row[name].c_str(), nullptr);
    };
    double kinetic = 0.0;
    for (const auto& [name, mass] : coarse.masses) {
      const double x = value(name + ".x"), y = value(name + ".y"), vx = value(name + ".vx"),
                   vy = value(name + ".vy"), omega = value(name + ".omega");
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), low = std::max(low, y);
      kinetic += 0.5 * mass.I * omega * omega;
      if (std::isfinite(mass.m)) kinetic += 0.5 * mass.m * (vx * vx + vy * vy);
    }
    shown.kinetic = std::max(shown.kinetic, kinetic);
  });
  shown.size = std::hypot(right - left, low - top) + 2.0 * coarse.radius;
  return shown;
}

}  // namespace

Coarse make_coarse(std::uint64_t seed, std::uint64_t index) {
  Random random(seed, index);
  Coarse coarse;
  coarse.chapter = random.below(7);
  coarse.arguments = {"run"};
  Maker maker(coarse, random);
  const double rate = maker.scene();

  struct Integrator {
    const char* name;
    double limit;  // of the step times the rate; of feedback, for s = h√ks at critical damping
  };
  static const std::vector<Integrator> integrators{{"explicit_euler", 2.0},
                                                   {"semi_implicit_euler", 0.828},
                                                   {"implicit_midpoint", 8.0},
                                                   {"rk4", 2.785},
                                                   {"dop853", 5.0}};
  const Integrator integrator = random.pick(integrators);
  coarse.arguments.push_back(fmt::format("--integrator={}", integrator.name));
  const double step =
      integrator.limit / rate * random.scale(std::log10(1.0 / 30.0), std::log10(3.0));
  double duration = random.scale(0.0, std::log10(400.0));
  duration = std::min(duration, 8000.0 * step);
  maker.give("--duration", duration);
  if (std::string(integrator.name) == "dop853" && random.chance(0.3))
    maker.give("--tolerance", random.scale(-9.0, -1.0));
  else
    maker.give("--step", step);
  if (coarse.chapter == 1) return coarse;
  const double stabilization = random.unit();
  if (stabilization < 0.3) {
    coarse.arguments.emplace_back("--stabilization=projection");
  } else if (stabilization < (coarse.chapter == 3 ? 0.9 : 0.5)) {
    const double s = integrator.limit * random.scale(std::log10(1.0 / 30.0), std::log10(1.5));
    maker.give("--ks", std::pow(s / step, 2));
  }
  return coarse;
}

std::string check_coarse(const Coarse& coarse, const Ended& ended) {
  if (ended.status != 0) return {};
  const bool warned = ended.err.find("warning: ") != std::string::npos;
  const auto [size, kinetic] = read_table(coarse, ended.table);
  const std::string errors =
      ended.out.substr(std::min(ended.out.size(), ended.out.find("error against")));
  double error = 0.0;  // [m]
  for (const char* name : {"position", "q"})
    if (const double metres = printed(errors, name); std::isfinite(metres)) error = metres;
  for (const char* name : {"angle", "wheel angle"})
    if (const double angle = printed(errors, name); std::isfinite(angle))
      error = std::max(error, angle * coarse.radius);
  if (!warned && error > 0.1 * size)
    return fmt::format("says nothing, and is {:.2g} m off in a scene of {:.2g} m", error, size);
  // A tolerance may be told that was not kept by far less than this.
  if (!warned || ended.err.find("was not kept") != std::string::npos ||
      ended.err.find("cannot be stable") != std::string::npos)
    return {};
  const double opening = printed(errors, "constraint error |C|") / coarse.gradient;
  const double energy = printed(errors, "energy error");
  if (error < 1e-3 * size && opening < 1e-3 * size && energy < 1e-3 * kinetic &&
      ended.out.find("no exact answer") == std::string::npos)
    return fmt::format("warns, and is right: {:.2g} m off, {:.2g} m open, {:.2g} J of {:.2g} J",
                       error, opening, energy, kinetic);
  return {};
}

}  // namespace fuzz
