// Chapter 6: the prismatic joint, which lets a body slide along a rail without turning on it.
//
// The rail is fixed in the world and inclined, or, with --spin, a body of its own that turns about
// a pin while the block slides outwards on it. See scene.hpp.

#include <string_view>

#include "app/chapter.hpp"
#include "exact.hpp"
#include "pictures.hpp"
#include "scene.hpp"
#include "stability.hpp"

int main(int argc, char** argv) {
  prismatic::Scene scene;
  // On the incline RK4 is exact, so `report` measures the spinning rail unless told otherwise.
  if (argc > 1 && std::string_view(argv[1]) == "report") scene.spin = 5.0;

  app::Chapter chapter;
  chapter.directory = "06_prismatic";
  chapter.title = "Prismatic joint";

  const app::Range inclines{-90.0, 90.0}, spins{-1e6, 1e6};
  chapter.parameters = {
      {"--incline", "deg", "of the fixed rail; positive: down to the right", &scene.incline,
       inclines},
      {"--mass", "kg", "of the block", &scene.mass, app::positive, app::acts},
      {"--gravity", "m/s²", "gravity, downwards; on the fixed rail only", &scene.gravity,
       app::not_negative, app::acts},
      {"--spin", "rad/s", "of a free rail at the start, for example 5; 0: it is fixed", &scene.spin,
       spins},
  };
  chapter.defaults = {.duration = 2.0, .step = 0.002};
  chapter.constraint_unit = "m or rad";
  chapter.fastest = [&scene] { return std::abs(scene.spin); };

  chapter.start = [&scene](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<mechanics::Mechanism>>(
        prismatic::make_mechanism(scene, method), method);
  };

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"force", "N"}, {"moment", "N·m"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return prismatic::errors(scene, row); };

  chapter.ladder = {.methods = measure::methods_to_compare(100.0, 20.0),
                    .duration = 1.0,
                    .coarsest = 0.1,
                    .rungs = 15};

  chapter.stability = prismatic::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return prismatic::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) { return prismatic::stage(scene, run); };
  return app::run_chapter(argc, argv, chapter);
}
