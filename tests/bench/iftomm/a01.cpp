// IFToMM benchmark A01, the simple pendulum: a mass at the end of a massless rod.

#include "app/chapter.hpp"
#include "exact.hpp"

int main(int argc, char** argv) {
  iftomm::Pendulum scene;
  app::Chapter chapter;
  chapter.directory = "iftomm_a01";
  chapter.title = "IFToMM A01, simple pendulum";
  chapter.parameters = {
      {"--length", "m", "of the rod", &scene.length, {1e-6, 1e6}},
      {"--mass", "kg", "at its end", &scene.mass, app::positive},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative},
  };
  chapter.defaults = {.duration = 10.0, .step = 0.001};
  chapter.constraint_unit = "m²";
  chapter.start = [&scene](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<mechanics::Mechanism>>(
        iftomm::make_mechanism(scene, method), method);
  };
  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return iftomm::errors(scene, row); };
  chapter.ladder = {.methods = measure::methods_to_compare(100.0, 20.0),
                    .duration = 10.0,
                    .coarsest = 0.1,
                    .rungs = 14};
  return app::run_chapter(argc, argv, chapter);
}
