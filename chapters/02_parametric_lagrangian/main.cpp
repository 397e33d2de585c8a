// Chapter 2: the same particle, described by the one coordinate that it really has.
//
// With q the way along x, the curve is built into the coordinates: no constraint, no constraint
// force, no drift off the curve. See parametric_bead.hpp for the equation of motion.

#include "app/chapter.hpp"
#include "exact.hpp"
#include "parametric_bead.hpp"
#include "pictures.hpp"
#include "stability.hpp"

int main(int argc, char** argv) {
  parabola::Scene scene;
  app::Chapter chapter;
  chapter.directory = "02_parametric_lagrangian";
  chapter.title = "Particle on a curve, parametric Lagrangian";

  chapter.parameters = {
      {"--x0", "m", "start, at rest", &scene.x0, app::any},
      {"--mass", "kg", "mass of the particle", &scene.mass, app::positive, app::acts},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
      {"--p", "m", "half the parameter of the parabola x² + 2py = 0", &scene.p, app::positive},
      {"--force-x", "N", "constant horizontal force", &scene.force_x, app::any, app::acts},
  };
  chapter.defaults = {.duration = 20.0, .step = 0.01};
  chapter.has_constraints = false;
  chapter.constraint_unit = "m²";
  chapter.fastest = [&scene] { return scene.fastest(); };

  using parametric_lagrangian::ParametricBead;
  chapter.start = [&scene](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<ParametricBead>>(ParametricBead(scene), method);
  };

  chapter.quantities = {{"q", "m"}, {"dq/dt", "m/s"}};
  chapter.errors = [&scene](const mechanics::Row& row) {
    return parametric_lagrangian::errors(scene, row);
  };

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
