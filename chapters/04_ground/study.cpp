#include "study.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/chapter.hpp"
#include "cost.hpp"
#include "instruments/files/files.hpp"
#include "mechanics/joints/ground.hpp"
#include "mechanism.hpp"

namespace ground {
namespace {

using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<mechanics::Mechanism>;

const Scene off{.offset_x = 0.05, .offset_y = -0.03, .offset_theta = 0.2};
enum { place, angle, force, moment };  // what errors() returns

measure::Start of(const Scene& scene) {
  return measure::start_of([=](const Method& method) { return make_mechanism(scene, method); });
}

/// One of the errors at the end of so many steps.
std::function<double()> error(std::size_t quantity, const Scene& scene, const Method& method,
                              long steps, double h) {
  return measure::final_error(
      of(scene), [=](const mechanics::Row& row) { return errors(scene, method, row); }, quantity,
      method, steps, h);
}

measure::Start scene_in(const measure::Units& units) {
  Scene there = off;
  measure::scale({&there.offset_x, &there.offset_y, &there.width, &there.height}, units.length);
  there.load *= units.force();
  there.mass *= units.mass;
  there.gravity *= units.acceleration();
  there.load_rate /= units.time;
  return of(there);
}

/// What leaving the ground out saves: a table, printed and saved as left_out.txt.
void report_left_out(const std::filesystem::path& out) {
  const std::string table = left_out_table();
  files::write_file(out / "left_out.txt", table);
  fmt::print("\n{}\n{}\n", table, (out / "left_out.txt").string());
}

}  // namespace

Exact exact(const Scene& scene, const Method& method, double t) {
  switch (method.stabilization) {
    case Stabilization::none:
      break;
    case Stabilization::feedback:
      return exact(scene, decay(method.ks, method.kd, t), t);
    case Stabilization::projection:
      if (t > 0.0) return exact(scene, Decay{0.0, 0.0}, t);
  }
  return exact(scene, Decay{1.0, 0.0}, t);
}

std::vector<double> errors(const Scene& scene, const mechanics::Method& method,
                           const mechanics::Row& row) {
  const Exact truth = exact(scene, method, row.t);
  const Eigen::Vector3d q(row.state[0], row.state[1], row.state[2]);
  const Eigen::Vector3d reaction(row.reactions[0], row.reactions[1], row.reactions[2]);
  return {(q - truth.q).head<2>().norm(), std::abs(q.z() - truth.q.z()),
          (reaction - truth.reaction).head<2>().norm(),
          std::abs(reaction.z() - truth.reaction.z())};
}

measure::Stability stability() {
  using namespace measure;
  using namespace measure::usual;

  Stability stability;
  stability.cases = {
      {"held in its place for 1e5 steps", "place, m", accurate(1e-12),
       error(place, {}, rk4, 100000, 0.01)},
      {"a load of 1e12 N", "reaction, N", accurate(1e-2),
       error(force, {.load = 1e12}, rk4, 500, 0.01)},
      {"put back from 1e6 m away", "place, m", accurate(1e-6),
       error(place, {.offset_x = 1e6}, feedback(25, 10), 500, 0.01)},
      {"turned by 1e6 rad", "angle, rad", accurate(1e-3),
       error(angle, {.offset_theta = 1e6}, feedback(25, 10), 500, 0.01)},
      {"without damping, kd = 0, 1e5 steps", "place, m", accurate(1e-3),
       error(place, off, feedback(25, 0), 100000, 0.002)},
      {"overdamped, kd = 1e3 1/s, ks = 1 1/s²", "place, m", accurate(1e-9),
       error(place, off, feedback(1, 1000), 2500, 0.002)},
      {"ks = 1e10 1/s², implicit_midpoint", "place, m", degraded(1e-9, 1e-6),
       error(place, off, feedback(1e10, 2e5, Scheme::implicit_midpoint), 4000, 0.01)},
      {"ks = 1e10 1/s², rk4", "", refused("the constraint error"),
       error(place, off, feedback(1e10, 2e5), 500, 0.01)},
      {"critical, h√ks = 2.78, below the limit", "place, m", accurate(1e-6),
       error(place, off, feedback(2.78 * 2.78, 2 * 2.78), 20000, 1.0)},
      {"critical, h√ks = 2.79, above the limit", "", refused("the constraint error"),
       error(place, off, feedback(2.79 * 2.79, 2 * 2.79), 20000, 1.0)},
      {"held twice: the second joint adds nothing", "place, m", accurate(1e-12),
       [=] {
         mechanics::Mechanism mechanism = make_mechanism({}, rk4);
         mechanism.system.add("again", joints::Ground{},
                              mechanism.system.thing<dynamics::Body>("plate"));
         Motion motion(std::move(mechanism), rk4);
         motion.advance(1000, 0.01);
         motion.row();
         if (motion.model().evaluation().dependent_rows().size() != 3) return 1.0;
         return motion.measures().constraint_error;
       }},
  };
  stability.add_units(scene_in,
                      {feedback(25, 10),
                       feedback(25, 10, Scheme::implicit_midpoint),
                       {Scheme::dop853, Stabilization::feedback, 25, 10, 1e-8}},
                      100, 0.01);

  stability.add_feedback(of({}), {.step = 1e-3, .nudge = 1e-3});
  stability.map_remark = "With J = I each coordinate obeys the test equation exactly.";
  return stability;
}

int study(int argc, char** argv) {
  Scene scene;
  Method current;  // of the simulation last started: the exact answer depends on it
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

  chapter.start = [&](const Method& method) {
    current = method;
    return of(scene)(method);
  };

  chapter.quantities = {
      {"position", "m"}, {"angle", "rad"}, {"reaction force", "N"}, {"reaction moment", "N·m"}};
  chapter.errors = [&](const mechanics::Row& row) { return errors(scene, current, row); };

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

}  // namespace ground
