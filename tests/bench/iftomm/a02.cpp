// IFToMM benchmark A02: N four-bar linkages in a row, through poses where J loses rank.

#include "app/chapter.hpp"
#include "exact.hpp"

int main(int argc, char** argv) {
  iftomm::FourBars scene;
  app::Chapter chapter;
  chapter.directory = "iftomm_a02";
  chapter.title = "IFToMM A02, N four-bar linkages";
  chapter.parameters = {
      {"--loops", "", "N, the number of linkages", &scene.loops, {1, 1000}},
      {"--speed", "m/s", "of the tops at the start", &scene.speed, {1e-3, 1e3}},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative},
  };
  chapter.defaults = {.duration = 10.0,
                      .step = 0.001,
                      .method = {integrators::Scheme::rk4, mechanics::Stabilization::projection}};
  chapter.start = [&scene](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<mechanics::Mechanism>>(
        iftomm::make_mechanism(scene, method), method);
  };
  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return iftomm::errors(scene, row); };
  chapter.ladder = {.methods = measure::methods_to_compare(100.0, 20.0),
                    .duration = 10.0,
                    .coarsest = 0.02,
                    .rungs = 12};
  chapter.remark =
      "Close to a pose in which J loses rank the acceleration is taken from both sides of it.";
  return app::run_chapter(argc, argv, chapter);
}
