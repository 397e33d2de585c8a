#include "study.hpp"

#include "app/chapter.hpp"
#include "exact.hpp"
#include "implicit_bead.hpp"

namespace particle_on_curve {
namespace {

using mechanics::Method;
using parabola::Scene;

measure::Start of(const Scene& scene) {
  return measure::start_of(
      [=](const Method& method) { return parabola::ImplicitBead(scene, method.ks, method.kd); });
}

/// How far from the exact place [m] the bead is at the end of so many steps.
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
  const Exact truth = exact(scene, parabola::ExactMotion(scene), row.t);
  const Eigen::Vector2d x(row.state[0], row.state[1]), v(row.state[2], row.state[3]);
  const Eigen::Vector2d force(row.reactions[0], row.reactions[1]);
  return {(x - truth.x).norm(), (v - truth.v).norm(), (force - truth.constraint_force).norm()};
}

measure::Stability stability() {
  using namespace measure;
  using namespace measure::usual;

  Stability stability;
  stability.cases = {
      // λ∇C balances gravity to some roundings of g: three of them over 10 s are 1.6e-13 m.
      {"at rest at the bottom", "place, m", accurate(2e-13), place({.x0 = 0.0}, rk4, 1000, 0.01)},
      {"a swing of 1e-6 m", "place, m", accurate(1e-13), place({.x0 = 1e-6}, rk4, 2000, 0.01)},
      {"from 1e4 m, where the slope is 200", "energy error, relative", accurate(1e-6),
       energy_error(of({.x0 = 1e4}), projected, 20000, 0.01)},
      {"p = 0.05 m: radius 0.05 m, start at 1 m", "place, m", accurate(1e-6),
       place({.x0 = 1.0, .p = 0.05}, projected, 40000, 5e-5)},
      {"the same with steps of 1e-2 s", "place, m", degraded(1e-4, 2.0),
       place({.x0 = 1.0, .p = 0.05}, projected, 200, 1e-2)},
      {"mass 1e8 kg", "place, m", accurate(1e-6), place({.mass = 1e8}, projected, 2000, 0.01)},
      {"mass 1e-8 kg", "place, m", accurate(1e-6), place({.mass = 1e-8}, projected, 2000, 0.01)},
      {"gravity 1e6 m/s², steps of 1e-5 s", "place, m", accurate(1e-6),
       place({.gravity = 1e6}, projected, 20000, 1e-5)},
      {"force of 1e6 N across, steps of 1e-5 s", "place, m", accurate(1e-6),
       place({.force_x = 1e6}, projected, 2000, 1e-5)},
      {"feedback past its limit: h√ks = 3", "", refused("kinetic energy"),
       energy_error(of({}), feedback(9e4, 600), 20000, 0.01)},
      {"steps of 5 s with explicit_euler", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::explicit_euler}, 1000, 5.0)},
      {"1e6 steps, rk4 + projection", "energy error, relative", accurate(1e-8),
       energy_error(of({}), projected, 1000000, 0.01)},
      {"1e6 steps, rk4 alone: off the curve", "|C|, m²", degraded(1e-3, 1e3),
       drift(of({}), rk4, 1000000, 0.01)},
      {"1e6 steps, rk4 + feedback", "|C|, m²", accurate(1e-4),
       drift(of({}), feedback(4, 4), 1000000, 0.01)},
  };
  stability.add_units(scene_in, {rk4, projected, feedback(4, 4), midpoint, adaptive}, 1000, 0.01);

  stability.add_feedback(of({}), {.step = 1e-3, .nudge = 0.01});
  stability.map_remark = "Curved or not, the constraint obeys the test equation.";
  return stability;
}

int study(int argc, char** argv) {
  Scene scene;
  app::Chapter chapter;
  chapter.directory = "01_particle_on_curve_implicit";
  chapter.title = "Particle on a curve, implicit";

  chapter.parameters = {
      {"--x0", "m", "start, at rest", &scene.x0, app::any},
      {"--mass", "kg", "mass of the particle", &scene.mass, app::positive, app::acts},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
      {"--p", "m", "half the parameter of the parabola x² + 2py = 0", &scene.p, app::positive},
      {"--force-x", "N", "constant horizontal force", &scene.force_x, app::any, app::acts},
      {"--without=jdotv", "", "2 m vx², which bends the path", &scene.without_velocity_term,
       app::on_or_off, app::acts},
  };
  chapter.defaults = {.duration = 20.0, .step = 0.01};
  chapter.constraint_unit = "m²";
  chapter.fastest = [&scene] { return scene.fastest(); };

  chapter.start = measure::start_of([&scene](const Method& method) {
    return parabola::ImplicitBead(scene, method.ks, method.kd);
  });

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"constraint force", "N"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return errors(scene, row); };

  chapter.ladder = {.methods = measure::methods_to_compare(4.0, 4.0),
                    .duration = 10.0,
                    .coarsest = 0.5,
                    .rungs = 16};

  chapter.stability = particle_on_curve::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return particle_on_curve::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) {
    return particle_on_curve::stage(scene, run);
  };
  return app::run_chapter(argc, argv, chapter);
}

}  // namespace particle_on_curve
