// Chapter 2: the same particle, described by the one coordinate that it really has.
//
// With q the way along x, the curve is built into the coordinates: no constraint, no constraint
// force, no drift off the curve. See parametric_bead.hpp for the equation of motion.

#include "exact.hpp"
#include "parametric_bead.hpp"
#include "pictures.hpp"
#include "program/chapter.hpp"
#include "stability.hpp"

int main(int argc, char** argv) {
  parabola::Scene scene;
  program::Chapter chapter;
  chapter.directory = "02_parametric_lagrangian";
  chapter.title = "Particle on a curve, parametric Lagrangian";

  chapter.parameters = {
      {"--x0", "m", "start, at rest", &scene.x0, program::any},
      {"--mass", "kg", "mass of the particle", &scene.mass, program::positive, program::acts},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, program::not_negative,
       program::acts},
      {"--p", "m", "half the parameter of the parabola x² + 2py = 0", &scene.p, program::positive},
      {"--force-x", "N", "constant horizontal force", &scene.force_x, program::any, program::acts},
  };
  chapter.defaults = {.duration = 20.0, .step = 0.01};
  chapter.has_constraints = false;
  chapter.constraint_unit = "m²";
  chapter.fastest = [&scene] { return scene.fastest(); };

  using parametric_lagrangian::ParametricBead;
  chapter.start = [&scene](const measure::Method& method) {
    return std::make_unique<measure::Motion<ParametricBead>>(ParametricBead(scene), method);
  };

  chapter.quantities = {{"q", "m"}, {"dq/dt", "m/s"}};
  chapter.errors = [&scene](const measure::Row& row) {
    return parametric_lagrangian::errors(scene, row);
  };

  chapter.ladder = {
      .methods = measure::every_integrator(), .duration = 10.0, .coarsest = 0.5, .rungs = 16};
  chapter.ladder.methods.push_back(
      {.integrator = integrators::Name::dop853, .tolerance = measure::coarsest_tolerance});

  chapter.stability = parametric_lagrangian::stability;

  chapter.pictures = [&scene](const program::RunOptions& run) {
    return parametric_lagrangian::pictures(scene, run);
  };
  chapter.stage = [&scene](const program::RunOptions& run) {
    return parametric_lagrangian::stage(scene, run);
  };
  return program::run_chapter(argc, argv, chapter);
}
