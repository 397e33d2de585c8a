// IFToMM benchmark A01, the simple pendulum: a mass at the end of a massless rod.

#include "exact.hpp"
#include "program/chapter.hpp"

int main(int argc, char** argv) {
  iftomm::Pendulum scene;
  program::Chapter chapter;
  chapter.directory = "iftomm_a01";
  chapter.title = "IFToMM A01, simple pendulum";
  chapter.parameters = {
      {"--length", "m", "of the rod", &scene.length, {1e-6, 1e6}},
      {"--mass", "kg", "at its end", &scene.mass, program::positive},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, program::not_negative},
  };
  chapter.defaults = {.duration = 10.0, .step = 0.001};
  chapter.constraint_unit = "m²";
  chapter.start = [&scene](const measure::Method& method) {
    return std::make_unique<measure::Motion<program::Mechanism>>(
        iftomm::make_mechanism(scene, method), method);
  };
  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}};
  chapter.errors = [&scene](const measure::Row& row) { return iftomm::errors(scene, row); };
  chapter.ladder = {.methods = measure::methods_to_compare(100.0, 20.0),
                    .duration = 10.0,
                    .coarsest = 0.1,
                    .rungs = 14};
  return program::run_chapter(argc, argv, chapter);
}
