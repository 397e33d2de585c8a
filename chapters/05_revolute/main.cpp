// Chapter 5: the revolute joint, which pins a point of one body to a point of another.
//
// One rod pinned to the world is the compound pendulum. A chain of them (--links) is the scene in
// which the cost of the global solver can be watched as it grows. See scene.hpp.

#include "app/chapter.hpp"
#include "cost.hpp"
#include "exact.hpp"
#include "instruments/draw/image.hpp"
#include "instruments/draw/offscreen.hpp"
#include "instruments/files/files.hpp"
#include "pictures.hpp"
#include "scene.hpp"
#include "stability.hpp"

namespace {

/// The cost of a step against the number of links: a table, the same as CSV, and its plot.
void report_cost(const std::filesystem::path& out) {
  const revolute::CostTable costs = revolute::measure_costs();
  fmt::print("\n{}", revolute::table(costs));
  const auto write = [&](const std::string& name, const std::string& content) {
    files::write_file(out / name, content);
    fmt::print("{}\n", (out / name).string());
  };
  write("cost_vs_links.txt", revolute::table(costs));
  write("cost_vs_links.csv", revolute::csv(costs));
  const pictures::Picture picture =
      revolute::cost_picture(revolute::read_costs(out / "cost_vs_links.csv"));
  write(picture.name + ".png", draw::encode_png(draw::render({}, picture.draw)));
}

}  // namespace

int main(int argc, char** argv) {
  revolute::Scene scene;
  app::Chapter chapter;
  chapter.directory = "05_revolute";
  chapter.title = "Revolute joint";

  const app::Range lengths{1e-6, 1e6}, angles{-100.0, 100.0};
  chapter.parameters = {
      {"--links", "", "rods in the chain", &scene.links, {1, 1000}, app::whole},
      {"--length", "m", "of all rods together", &scene.length, lengths},
      {"--mass", "kg", "of all rods together", &scene.mass, app::positive, app::acts},
      {"--angle0", "rad", "start, at rest: from +x towards +y, which is down", &scene.angle0,
       angles},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
  };
  chapter.defaults = {.duration = 5.0, .step = 0.005};
  chapter.fastest = [&scene] { return scene.fastest(); };

  chapter.start = [&scene](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<mechanics::Mechanism>>(
        revolute::make_mechanism(scene, method), method);
  };

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"pin force", "N"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return revolute::errors(scene, row); };

  chapter.ladder = {.methods = measure::methods_to_compare(100.0, 20.0),
                    .duration = 2.0,
                    .coarsest = 0.1,
                    .rungs = 15};
  chapter.also_report = report_cost;

  chapter.stability = revolute::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return revolute::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) { return revolute::stage(scene, run); };
  return app::run_chapter(argc, argv, chapter);
}
