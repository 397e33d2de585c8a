// Chapter 1: a particle on a curve, held there by the force that its constraint asks for.
//
// The particle has two coordinates, the curve takes one away: C(x, y) = x² + 2py = 0. The model
// computes the one force along ∇C that keeps C̈ = 0; see implicit_bead.hpp.

#include "app/chapter.hpp"
#include "exact.hpp"
#include "implicit_bead.hpp"
#include "pictures.hpp"
#include "stability.hpp"

int main(int argc, char** argv) {
  parabola::Scene scene;
  app::Chapter chapter;
  chapter.directory = "01_particle_on_curve_implicit";
  chapter.title = "Particle on a curve, implicit";

  chapter.parameters = {
      {"--x0", "m", "start, at rest", &scene.x0, app::any},
      {"--mass", "kg", "mass of the particle", &scene.mass, app::positive, app::acts},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
      {"--p", "m", "half the parameter of the parabola x² + 2py = 0", &scene.p, app::positive},
      {"--force-x", "N", "constant horizontal force", &scene.force_x, app::any, app::acts},
  };
  chapter.defaults = {.duration = 20.0, .step = 0.01};
  chapter.constraint_unit = "m²";
  chapter.fastest = [&scene] { return scene.fastest(); };

  chapter.start = [&scene](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<parabola::ImplicitBead>>(
        parabola::ImplicitBead(scene, method.ks, method.kd), method);
  };

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"constraint force", "N"}};
  chapter.errors = [&scene](const mechanics::Row& row) {
    return particle_on_curve::errors(scene, row);
  };

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
