// Chapter 7: the slider-crank. One ground, three revolute joints, one prismatic joint, and a torque
// that can be switched off. The scene is put together in scene.hpp from the parts of chapters 4, 5
// and 6.

#include "app/chapter.hpp"
#include "exact.hpp"
#include "pictures.hpp"
#include "scene.hpp"
#include "stability.hpp"

int main(int argc, char** argv) {
  slider_crank::Scene scene;
  app::Chapter chapter;
  chapter.directory = "07_slider_crank";
  chapter.title = "Slider-crank";

  const app::Range angle{-1e6, 1e6};
  chapter.parameters = {
      {"--crank", "m", "from the wheel's centre to the crank pin", &scene.crank, app::positive},
      {"--rod", "m", "length of the rod, at least the crank", &scene.rod, app::positive},
      {"--torque", "N·m", "on the wheel, from outside; 0 switches it off", &scene.torque, app::any,
       app::acts | app::switchable},
      {"--theta0", "rad", "angle of the crank at the start", &scene.theta0, angle},
      {"--omega0", "rad/s", "its rate at the start", &scene.omega0, app::any},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
      {"--wheel-mass", "kg", "mass of the wheel", &scene.wheel_mass, app::positive, app::acts},
      {"--rod-mass", "kg", "mass of the rod", &scene.rod_mass, app::positive, app::acts},
      {"--slider-mass", "kg", "mass of the slider", &scene.slider_mass, app::positive, app::acts},
      {"--simulate-frame",
       "",
       "1: the frame is a body held by a ground joint; 0: left out",
       &scene.simulate_frame,
       {0.0, 1.0},
       app::whole},
  };
  chapter.defaults = {.duration = 2.0, .step = 0.001};
  chapter.constraint_unit = "m or rad";
  chapter.fastest = [&] { return scene.fastest(chapter.defaults.duration); };

  chapter.start = [&scene](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<mechanics::Mechanism>>(
        slider_crank::make_mechanism(scene, method), method);
  };

  chapter.quantities = {
      {"wheel angle", "rad"}, {"angular velocity", "rad/s"}, {"joint forces", "N"}};
  chapter.errors = [&scene](const mechanics::Row& row) {
    return slider_crank::errors(scene, slider_crank::make_mechanism(scene, {}).columns(), row);
  };

  chapter.ladder = {.methods = measure::methods_to_compare(625.0, 50.0),
                    .duration = 2.0,
                    .coarsest = 0.02,
                    .rungs = 14};

  chapter.stability = slider_crank::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return slider_crank::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) {
    return slider_crank::stage(scene, run);
  };
  return app::run_chapter(argc, argv, chapter);
}
