// Chapter 3: one solver for any set of constraints.
//
// Two beads on the parabola of chapter 1, joined by a rigid rod: three constraints that push
// against each other. Their rows form one Jacobian J, and one equation gives all forces at once,
//
//   (J W Jᵀ) λ = − J̇v − J W F;   see scene.hpp for the scene and dynamics/system.hpp for the
//   solver.

#include "app/chapter.hpp"
#include "exact.hpp"
#include "pictures.hpp"
#include "scene.hpp"
#include "stability.hpp"

int main(int argc, char** argv) {
  dumbbell::Scene scene;
  app::Chapter chapter;
  chapter.directory = "03_global_jacobian_solver";
  chapter.title = "The global Jacobian solver";

  chapter.parameters = {
      {"--x1", "m", "start of bead1, at rest", &scene.x1, app::any},
      {"--x2", "m", "start of bead2, at rest", &scene.x2, app::any},
      {"--m1", "kg", "mass of bead1", &scene.m1, app::positive, app::acts},
      {"--m2", "kg", "mass of bead2", &scene.m2, app::positive, app::acts},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
      {"--p", "m", "half the parameter of the parabola x² + 2py = 0", &scene.p, app::positive},
  };
  chapter.defaults = {.duration = 20.0, .step = 0.01};
  chapter.constraint_unit = "m²";
  chapter.fastest = [&scene] {  // of a bead alone, from the higher start
    const double x0 = std::max(std::abs(scene.x1), std::abs(scene.x2));
    return parabola::Scene{.x0 = x0, .gravity = scene.gravity, .p = scene.p}.fastest();
  };

  chapter.start = [&scene](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<mechanics::Mechanism>>(
        dumbbell::make_mechanism(scene, method), method);
  };

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"constraint forces", "N"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return dumbbell::errors(scene, row); };

  chapter.ladder = {.methods = measure::methods_to_compare(1.0, 2.0),
                    .duration = 10.0,
                    .coarsest = 0.5,
                    .rungs = 16};

  chapter.stability = dumbbell::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return dumbbell::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) { return dumbbell::stage(scene, run); };
  return app::run_chapter(argc, argv, chapter);
}
