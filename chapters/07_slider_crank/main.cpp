// Chapter 7: the slider-crank. One ground, three revolute joints, one prismatic joint, and a torque
// that can be switched off. The scene is put together in scene.hpp from the parts of chapters 4, 5
// and 6.

#include "exact.hpp"
#include "pictures.hpp"
#include "program/chapter.hpp"
#include "scene.hpp"
#include "stability.hpp"

int main(int argc, char** argv) {
  slider_crank::Scene scene;
  program::Chapter chapter;
  chapter.directory = "07_slider_crank";
  chapter.title = "Slider-crank";

  const program::Range angle{-1e6, 1e6};
  chapter.parameters = {
      {"--crank", "m", "from the wheel's centre to the crank pin", &scene.crank, program::positive},
      {"--rod", "m", "length of the rod, at least the crank", &scene.rod, program::positive},
      {"--torque", "N·m", "on the wheel, from outside; 0 switches it off", &scene.torque,
       program::any, program::acts | program::switchable},
      {"--theta0", "rad", "angle of the crank at the start", &scene.theta0, angle},
      {"--omega0", "rad/s", "its rate at the start", &scene.omega0, program::any},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, program::not_negative,
       program::acts},
      {"--wheel-mass", "kg", "mass of the wheel", &scene.wheel_mass, program::positive,
       program::acts},
      {"--rod-mass", "kg", "mass of the rod", &scene.rod_mass, program::positive, program::acts},
      {"--slider-mass", "kg", "mass of the slider", &scene.slider_mass, program::positive,
       program::acts},
      {"--simulate-frame",
       "",
       "1: the frame is a body held by a ground joint; 0: left out",
       &scene.simulate_frame,
       {0.0, 1.0},
       program::whole},
  };
  chapter.defaults = {.duration = 2.0, .step = 0.001};
  chapter.constraint_unit = "m or rad";
  chapter.fastest = [&] { return scene.fastest(chapter.defaults.duration); };

  chapter.start = [&scene](const measure::Method& method) {
    return std::make_unique<measure::Motion<program::Mechanism>>(
        slider_crank::make_mechanism(scene, method), method);
  };

  chapter.quantities = {
      {"wheel angle", "rad"}, {"angular velocity", "rad/s"}, {"joint forces", "N"}};
  chapter.errors = [&scene](const measure::Row& row) {
    return slider_crank::errors(scene, slider_crank::make_mechanism(scene, {}).columns(), row);
  };

  chapter.ladder = {.methods = measure::methods_to_compare(625.0, 50.0),
                    .duration = 2.0,
                    .coarsest = 0.02,
                    .rungs = 14};

  chapter.stability = slider_crank::stability;

  chapter.pictures = [&scene](const program::RunOptions& run) {
    return slider_crank::pictures(scene, run);
  };
  chapter.stage = [&scene](const program::RunOptions& run) {
    return slider_crank::stage(scene, run);
  };
  return program::run_chapter(argc, argv, chapter);
}
