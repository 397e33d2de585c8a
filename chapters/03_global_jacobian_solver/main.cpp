// Chapter 3: one solver for any set of constraints.
//
// Two beads on the parabola of chapter 1, joined by a rigid rod: three constraints that push
// against each other. Their rows form one Jacobian J, and one equation gives all forces at once,
//
//   (J W Jᵀ) λ = − J̇v − J W F;   see scene.hpp for the scene and dynamics/system.hpp for the
//   solver.

#include "exact.hpp"
#include "pictures.hpp"
#include "program/chapter.hpp"
#include "scene.hpp"
#include "stability.hpp"

int main(int argc, char** argv) {
  dumbbell::Scene scene;
  program::Chapter chapter;
  chapter.directory = "03_global_jacobian_solver";
  chapter.title = "The global Jacobian solver";

  chapter.parameters = {
      {"--x1", "m", "start of bead1, at rest", &scene.x1, program::any},
      {"--x2", "m", "start of bead2, at rest", &scene.x2, program::any},
      {"--m1", "kg", "mass of bead1", &scene.m1, program::positive, program::acts},
      {"--m2", "kg", "mass of bead2", &scene.m2, program::positive, program::acts},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, program::not_negative,
       program::acts},
      {"--p", "m", "half the parameter of the parabola x² + 2py = 0", &scene.p, program::positive},
  };
  chapter.defaults = {.duration = 20.0, .step = 0.01};
  chapter.constraint_unit = "m²";
  chapter.fastest = [&scene] {  // of a bead alone, from the higher start
    const double x0 = std::max(std::abs(scene.x1), std::abs(scene.x2));
    return parabola::Scene{.x0 = x0, .gravity = scene.gravity, .p = scene.p}.fastest();
  };

  chapter.start = [&scene](const measure::Method& method) {
    return std::make_unique<measure::Motion<program::Mechanism>>(
        dumbbell::make_mechanism(scene, method), method);
  };

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"constraint forces", "N"}};
  chapter.errors = [&scene](const measure::Row& row) { return dumbbell::errors(scene, row); };

  chapter.ladder = {.methods = measure::methods_to_compare(1.0, 2.0),
                    .duration = 10.0,
                    .coarsest = 0.5,
                    .rungs = 16};

  chapter.stability = dumbbell::stability;

  chapter.pictures = [&scene](const program::RunOptions& run) {
    return dumbbell::pictures(scene, run);
  };
  chapter.stage = [&scene](const program::RunOptions& run) { return dumbbell::stage(scene, run); };
  return program::run_chapter(argc, argv, chapter);
}
