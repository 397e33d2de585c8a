// Chapter 4: ground. A plate held in its place: the reaction to a load, the way back from a wrong
// start, and what it saves to leave out of the system what does not move. See scene.hpp.

#include "app/chapter.hpp"
#include "cost.hpp"
#include "exact.hpp"
#include "instruments/files/files.hpp"
#include "pictures.hpp"
#include "scene.hpp"
#include "stability.hpp"

namespace {

/// What leaving the ground out saves: a table, printed and saved as left_out.txt.
void report_left_out(const std::filesystem::path& out) {
  const std::string table = ground::left_out_table();
  files::write_file(out / "left_out.txt", table);
  fmt::print("\n{}\n{}\n", table, (out / "left_out.txt").string());
}

}  // namespace

int main(int argc, char** argv) {
  using mechanics::Stabilization;
  ground::Scene scene;
  mechanics::Method current;  // of the simulation last started: the exact answer depends on it
  app::Chapter chapter;
  chapter.directory = "04_ground";
  chapter.title = "Ground";

  const app::Range length{-1e6, 1e6};
  chapter.parameters = {
      {"--load", "N", "largest load at the right edge's midpoint, load·sin 2t", &scene.load,
       app::any, app::acts},
      {"--offset-x", "m", "start off the place, along x", &scene.offset_x, length},
      {"--offset-y", "m", "start off the place, along y", &scene.offset_y, length},
      {"--offset-theta", "rad", "start turned", &scene.offset_theta, length},
  };
  chapter.defaults = {.duration = 5.0, .step = 0.01};
  chapter.constraint_unit = "m or rad";

  chapter.start = [&](const mechanics::Method& method) {
    current = method;
    return std::make_unique<mechanics::Motion<mechanics::Mechanism>>(
        ground::make_mechanism(scene, method), method);
  };

  chapter.quantities = {
      {"position", "m"}, {"angle", "rad"}, {"reaction force", "N"}, {"reaction moment", "N·m"}};
  chapter.errors = [&](const mechanics::Row& row) { return ground::errors(scene, current, row); };

  chapter.ladder = {.methods = measure::every_integrator(Stabilization::feedback, 25.0, 10.0),
                    .duration = 1.0,
                    .coarsest = 0.05,
                    .rungs = 15};
  chapter.ladder.methods.push_back({integrators::Scheme::dop853, Stabilization::feedback, 25.0,
                                    10.0, mechanics::coarsest_tolerance});
  chapter.before_report = [&] {  // a plate in its place has no error to measure
    if (scene.offset().isZero())
      scene.offset_x = 0.05, scene.offset_y = -0.03, scene.offset_theta = 0.2;
  };
  chapter.also_report = report_left_out;

  chapter.stability = ground::stability;

  chapter.pictures = [&](const measure::RunOptions& run) { return ground::pictures(scene, run); };
  chapter.stage = [&](const measure::RunOptions& run) { return ground::stage(scene, run); };
  return app::run_chapter(argc, argv, chapter);
}
