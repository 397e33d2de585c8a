#include "study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "01_particle_on_curve_implicit/exact.hpp"
#include "app/chapter.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "parametric_bead.hpp"

namespace parametric_lagrangian {
namespace {

using mechanics::Method;
using parabola::Scene;

/// Whether a swing stays what it is: its energy grows neither from the second quarter of 4000 steps
/// to the last, nor to more than `most_growth` times the first. h_omega: the step times √(g/p), the
/// rate of small swings; part: the start as a part of p.
bool swing_stays(integrators::Scheme name, double h_omega, double part, double most_growth) {
  const Scene scene{.x0 = part * 50.0};
  const double h = h_omega * std::sqrt(scene.p / scene.gravity);
  mechanics::Motion<ParametricBead> bead(ParametricBead(scene), {name});
  const double start = bead.measures().energy;
  double quarters[4] = {};
  try {
    for (double& most : quarters)
      for (int step = 0; step < 1000; ++step) {
        bead.advance(1, h);
        most = std::max(most, bead.measures().energy);
      }
  } catch (const mechanics::Diverged&) {
    return false;
  }
  return quarters[3] <= 1.5 * quarters[1] && quarters[3] <= most_growth * start;
}

/// The largest h√(g/p) at which small swings stay, by bisection in 0 … 8.
template <class Stays>
double limit_of_swings(const Stays& stays) {
  double stable = 0.0, unstable = 8.0;
  for (int i = 0; i < 14; ++i) {
    const double h_omega = 0.5 * (stable + unstable);
    (stays(h_omega) ? stable : unstable) = h_omega;
  }
  return stable;
}

measure::Start of(const Scene& scene) {
  return measure::start_of([=](const Method&) { return ParametricBead(scene); });
}

/// How far from the exact place [m] q is at the end of so many steps.
std::function<double()> place(const Scene& scene, const Method& method, long steps, double h) {
  return measure::final_error(
      of(scene), [=](const mechanics::Row& row) { return errors(scene, row); }, 0, method, steps,
      h);
}

measure::Start scene_in(const measure::Units& units) {
  return of(Scene{.force_x = 2.0}.scaled(units.length, units.time, units.mass));
}

}  // namespace

std::vector<double> errors(const parabola::Scene& scene, const mechanics::Row& row) {
  const auto [q, qdot] = parabola::ExactMotion(scene).at(row.t);
  return {std::abs(row.state[0] - q), std::abs(row.state[1] - qdot)};
}

measure::Stability stability() {
  using namespace measure;
  using namespace measure::usual;

  Stability stability;
  stability.cases = {
      {"at rest at the bottom", "place, m", accurate(0.0), place({.x0 = 0.0}, rk4, 1000, 0.01)},
      {"a swing of 1e-6 m", "place, m", accurate(1e-14), place({.x0 = 1e-6}, rk4, 2000, 0.01)},
      {"from 1e4 m, where the slope is 200", "energy error, relative", accurate(1e-9),
       energy_error(of({.x0 = 1e4}), rk4, 20000, 0.01)},
      {"p = 0.05 m: radius 0.05 m, start at 1 m", "place, m", accurate(1e-6),
       place({.x0 = 1.0, .p = 0.05}, rk4, 40000, 5e-5)},
      {"mass 1e8 kg", "place, m", accurate(1e-6), place({.mass = 1e8}, rk4, 2000, 0.01)},
      {"mass 1e-8 kg", "place, m", accurate(1e-6), place({.mass = 1e-8}, rk4, 2000, 0.01)},
      {"gravity 1e6 m/s², steps of 1e-5 s", "place, m", accurate(1e-6),
       place({.gravity = 1e6}, rk4, 20000, 1e-5)},
      {"force of 1e6 N across, steps of 1e-5 s", "place, m", accurate(1e-6),
       place({.force_x = 1e6}, rk4, 2000, 1e-5)},
      {"steps of 1 s with explicit_euler", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::explicit_euler}, 1000, 1.0)},
      {"swings of 100 m, steps of 5 s with rk4", "", refused("kinetic energy"),
       energy_error(of({}), rk4, 1000, 5.0)},
  };
  stability.add_units(
      scene_in, {rk4, {Scheme::implicit_midpoint}, {Scheme::dop853, {}, 0, 0, 1e-8}}, 1000, 0.01);
  constexpr double small = 1e-6;
  for (const auto& scheme : integrators::schemes) {
    const double theory = limit_of_swings([&](double h_omega) {
      return integrators::amplification(scheme.id, h_omega, 1.0, 0.0) <= 1.0 + 1e-6;
    });
    const std::string name = theory > 7.9
                                 ? fmt::format("{}: small swings, any step (to 8)", scheme.text)
                                 : fmt::format("{}: small swings to h√(g/p) = {:.3g}", scheme.text,
                                               theory < 0.01 ? 0.0 : theory);
    stability.cases.push_back(
        {name, "limit found, off theory's", accurate(0.02), [=, integrator = scheme.id] {
           return std::abs(limit_of_swings([&](double h_omega) {
                             return swing_stays(integrator, h_omega, small, 1e4);
                           }) -
                           theory);
         }});
  }

  // Small swings are those of the test equation without damping, whatever their size.
  constexpr double extents[] = {2.0, 3.0, 8.0, 4.0, 8.0};  // of the steps, for each integrator
  static_assert(std::size(extents) == integrators::schemes.size());
  for (const auto& scheme : integrators::schemes)
    stability.plans.push_back({scheme.id, "h √(g/p)", "start x0/p",
                               extents[static_cast<std::size_t>(scheme.id)], 1.0,
                               [name = scheme.id](double h_omega, double part) {
                                 return swing_stays(name, h_omega, part, 100.0);
                               },
                               [name = scheme.id](double h_omega, double) {
                                 return integrators::amplification(name, h_omega, 1.0, 0.0);
                               },
                               0.1, scheme.id == Scheme::rk4 ? 2 : 0});
  stability.map_remark =
      "Theory is that of small swings, the bottom rows; RK4 may swing on past its limit. Wide "
      "swings have limits of their own, and the implicit method an equation without a solution.";

  stability.long_run = {.steps = 1000000,
                        .step = 0.05,
                        .methods = {{{Scheme::semi_implicit_euler}, false},
                                    {{Scheme::implicit_midpoint}, true},
                                    {rk4, false},
                                    {{Scheme::dop853}, false}},
                        .start = of({})};
  return stability;
}

int study(int argc, char** argv) {
  Scene scene;
  app::Chapter chapter;
  chapter.directory = "02_parametric_lagrangian";
  chapter.title = "Particle on a curve, parametric Lagrangian";

  chapter.parameters = {
      {"--x0", "m", "start, at rest", &scene.x0, app::any},
      {"--mass", "kg", "mass of the particle", &scene.mass, app::positive, app::acts},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
      {"--p", "m", "half the parameter of the parabola x² + 2py = 0", &scene.p, app::positive},
      {"--force-x", "N", "constant horizontal force", &scene.force_x, app::any, app::acts},
      {"--without=velocity-term", "", "−q (dq/dt)², and 2 m vx² of the implicit particle",
       &scene.without_velocity_term, app::on_or_off, app::acts},
  };
  chapter.defaults = {.duration = 20.0, .step = 0.01};
  chapter.has_constraints = false;
  chapter.constraint_unit = "m²";
  chapter.fastest = [&scene] { return scene.fastest(); };

  chapter.start = measure::start_of([&scene](const Method&) { return ParametricBead(scene); });

  chapter.quantities = {{"q", "m"}, {"dq/dt", "m/s"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return errors(scene, row); };

  chapter.ladder = {
      .methods = measure::every_integrator(), .duration = 10.0, .coarsest = 0.5, .rungs = 16};
  chapter.ladder.methods.push_back(
      {.integrator = integrators::Scheme::dop853, .tolerance = mechanics::coarsest_tolerance});

  chapter.stability = parametric_lagrangian::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return parametric_lagrangian::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) {
    return parametric_lagrangian::stage(scene, run);
  };
  return app::run_chapter(argc, argv, chapter);
}

}  // namespace parametric_lagrangian
