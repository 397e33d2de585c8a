#include "study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/chapter.hpp"
#include "exact.hpp"
#include "instruments/draw/image.hpp"
#include "instruments/draw/offscreen.hpp"
#include "instruments/files/files.hpp"
#include "mechanism.hpp"

namespace revolute {
namespace {

using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<mechanics::Mechanism>;

/// A chain of `links` rods, together 0.5 m and `chain` kg, that carries a rod of 0.5 m and `load`
/// kg at its end; level and at rest.
mechanics::Mechanism make_loaded(int links, double chain, double load,
                                 const mechanics::Method& method) {
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  system.set_gravity({0.0, 9.81});
  double x = 0.0, length_before = 0.0;
  dynamics::Handle<dynamics::Body> before;
  for (int i = 0; i <= links; ++i) {
    const double l = i < links ? 0.5 / links : 0.5, m = i < links ? chain / links : load;
    const auto rod =
        system.add_body(fmt::format("rod{}", i + 1), m, m * l * l / 12.0, {x + l / 2, 0.0});
    const Vector2d start(-l / 2, 0.0), end(length_before / 2, 0.0);
    const std::string joint = fmt::format("pin{}", i + 1);
    if (i == 0)
      system.add(joint, joints::Revolute{start, {0.0, 0.0}}, rod, system.world);
    else
      system.add(joint, joints::Revolute{start, end}, rod, before);
    x += l;
    length_before = l;
    before = rod;
  }
  mechanism.assemble();
  return mechanism;
}

/// A chain pinned at both ends, straight: the last pin's row along the chain depends on the others.
/// Level under gravity it can neither fall nor carry its weight at finite tension; here it stands
/// upright, in the line of gravity, and hangs.
mechanics::Mechanism make_taut(int N, const mechanics::Method& method) {
  const Scene scene{.links = N, .angle0 = std::numbers::pi / 2};
  mechanics::Mechanism mechanism = make_mechanism(scene, method);
  mechanism.system.add("end_world", joints::Revolute{{scene.l() / 2, 0.0}, {0.0, scene.length}},
                       mechanism.system.thing<dynamics::Body>(fmt::format("rod{}", N)),
                       dynamics::System::world);
  mechanism.assemble();
  return mechanism;
}

measure::Start of(const Scene& scene) {
  return measure::start_of([=](const Method& method) { return make_mechanism(scene, method); });
}

/// How far from the exact place [m] it is at the end of so many steps.
std::function<double()> place(const Scene& scene, const Method& method, long steps, double h) {
  return measure::final_error(
      of(scene), [=](const mechanics::Row& row) { return errors(scene, row); }, 0, method, steps,
      h);
}

/// The loaded chain at its start.
measure::Start loaded(int links, double chain, double load) {
  return measure::start_of(
      [=](const Method& method) { return make_loaded(links, chain, load, method); });
}

measure::Start scene_in(const measure::Units& units) {
  Scene there{.links = 3, .angle0 = 0.5};
  there.length *= units.length;
  there.mass *= units.mass;
  there.gravity *= units.acceleration();
  return of(there);
}

/// The cost of a step against the number of links: a table, the same as CSV, and its plot.
void report_cost(const std::filesystem::path& out) {
  const CostTable costs = measure_costs();
  fmt::print("\n{}", table(costs));
  const auto write = [&](const std::string& name, const std::string& content) {
    files::write_file(out / name, content);
    fmt::print("{}\n", (out / name).string());
  };
  write("cost_vs_links.txt", table(costs));
  write("cost_vs_links.csv", csv(costs));
  const pictures::Picture picture = cost_picture(read_costs(out / "cost_vs_links.csv"));
  write(picture.name + ".png", draw::encode_png(draw::render({.captions = false}, picture.draw)));
}

}  // namespace

std::vector<double> errors(const Scene& scene, const mechanics::Row& row) {
  const int N = scene.links;
  if (N > longest_with_exact_answer) return {};
  const std::optional<Exact> truth =
      N == 1 ? exact_pendulum(scene, row.t) : ChainReference(scene).exact(row.t);
  if (!truth) return {};
  const double* rod = row.state.data() + 6 * (N - 1);  // x, y, θ, vx, vy, ω
  const Vector2d half = scene.l() / 2 * direction(rod[2]);
  const Vector2d end = Vector2d(rod[0], rod[1]) + half;
  const Vector2d end_velocity = Vector2d(rod[3], rod[4]) + rod[5] * Vector2d(-half.y(), half.x());
  const Vector2d pin_force(row.reactions[0], row.reactions[1]);
  return {(end - truth->end).norm(), (end_velocity - truth->end_velocity).norm(),
          (pin_force - truth->pin_force).norm()};
}

measure::Stability stability() {
  using namespace measure;
  using namespace measure::usual;

  Stability stability;
  stability.cases = {
      {"a swing of 1e-6 rad", "place, m", accurate(1e-14),
       place({.angle0 = std::numbers::pi / 2 - 1e-6}, rk4, 2000, 0.002)},
      {"1e-3 rad from upright", "place, m", accurate(1e-6),
       place({.angle0 = -std::numbers::pi / 2 + 1e-3}, projected, 2500, 0.002)},
      {"length 1e-6 m, steps of 2e-6 s", "place, m", accurate(1e-12),
       place({.length = 1e-6}, projected, 2500, 2e-6)},
      {"length 1e6 m, steps of 2 s", "place, m", accurate(1.0),
       place({.length = 1e6}, projected, 2500, 2.0)},
      {"1000 links", "joint drift, m", accurate(1e-9),
       drift(of({.links = 1000}), projected, 500, 2e-4)},
      {"1000 links: energy", "energy error, relative", accurate(1e-6),
       energy_error(of({.links = 1000}), projected, 500, 2e-4)},
      {"1000 links, steps of 5e-4 s", "", refused("kinetic energy"),
       energy_error(of({.links = 1000}), projected, 400, 5e-4)},
      {"10 links against the exact answer, 0.5 s", "place, m", accurate(1e-6),
       place({.links = 10}, projected, 1000, 5e-4)},
      {"1e-8 kg carries 1 kg", "joint drift, m", accurate(1e-9),
       drift(loaded(1, 1e-8, 1.0), projected, 1000, 1e-3)},
      {"1 kg carries 1e-8 kg", "joint drift, m", accurate(1e-9),
       drift(loaded(1, 1.0, 1e-8), projected, 1000, 1e-3)},
      {"1 kg carries 1e8 kg", "joint drift, m", accurate(1e-9),
       drift(loaded(1, 1.0, 1e8), projected, 1000, 1e-3)},
      {"1e8 kg carries 1 kg", "joint drift, m", accurate(1e-9),
       drift(loaded(1, 1e8, 1.0), projected, 1000, 1e-3)},
      {"1e-8 kg carries 1 kg: energy", "energy error, relative", accurate(1e-6),
       energy_error(loaded(1, 1e-8, 1.0), projected, 1000, 1e-3)},
      {"1e8 kg carries 1 kg: energy", "energy error, relative", accurate(1e-6),
       energy_error(loaded(1, 1e8, 1.0), projected, 1000, 1e-3)},
      {"100 links of 1e-6 kg each carry 1 kg", "joint drift, m", accurate(1e-9),
       drift(loaded(100, 1e-4, 1.0), projected, 2000, 1e-5)},
      {"the same: energy", "energy error, relative", accurate(1e-6),
       energy_error(loaded(100, 1e-4, 1.0), projected, 2000, 1e-5)},
      {"the same with steps of 1e-4 s", "", refused("kinetic energy"),
       energy_error(loaded(100, 1e-4, 1.0), projected, 2000, 1e-4)},
      {"pinned twice in one place", "place, m", accurate(1e-6),
       [=] {
         mechanics::Mechanism mechanism = make_mechanism({}, projected);
         mechanism.system.add("again", joints::Revolute{{-0.5, 0.0}, {0.0, 0.0}},
                              mechanism.system.thing<dynamics::Body>("rod"),
                              dynamics::System::world);
         Motion motion(std::move(mechanism), projected);
         motion.advance(1000, 0.002);
         const mechanics::Row row = motion.row();
         if (motion.model().evaluation().dependent_rows().size() != 2) return 1.0;
         return errors({}, row)[0];
       }},
      {"10 links pinned at both ends, straight", "off its place, m", accurate(1e-9),
       [=] {
         Motion motion(make_taut(10, projected), projected);
         motion.row();
         if (motion.model().evaluation().dependent_rows().empty()) return 1.0;
         const VectorXd start = motion.q();
         motion.advance(100, 1e-3);
         return (motion.q() - start).lpNorm<Eigen::Infinity>();
       }},
      {"a chain that does not reach its second pin", "", refused("cannot assemble"),
       [] {
         mechanics::Mechanism mechanism = make_mechanism({.links = 2});
         mechanism.system.add("end_world", joints::Revolute{{0.25, 0.0}, {3.0, 0.0}},
                              mechanism.system.thing<dynamics::Body>("rod2"),
                              dynamics::System::world);
         mechanism.assemble();
         return 0.0;
       }},
      {"a start 0.1 m off: projected first", "|C| after, m", accurate(1e-14),
       [=] {
         mechanics::Mechanism mechanism(projected);
         const auto rod = mechanism.system.add_body("rod", 1.0, 1.0 / 12.0, {0.6, 0.0});
         mechanism.system.add("rod_world", joints::Revolute{{-0.5, 0.0}, {0.0, 0.0}}, rod,
                              dynamics::System::world);
         mechanism.assemble();
         if (mechanism.notes().empty()) return 1.0;
         return mechanism.measures(0.0, mechanism.initial_position(), mechanism.initial_velocity())
             .constraint_error;
       }},
      {"feedback past its limit: h√ks = 5", "", refused("kinetic energy"),
       energy_error(of({}), feedback(1e6, 2e3), 2000, 0.005)},
      {"steps of 0.5 s with explicit_euler", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::explicit_euler, Stabilization::projection}, 1000, 0.5)},
  };
  stability.add_units(scene_in, {rk4, projected, feedback(100, 20), midpoint, adaptive}, 100, 2e-3);

  stability.add_feedback(of({.links = 2}), {.step = 1e-5, .nudge = 1e-5});
  stability.map_remark = "Measured on a falling chain of two rods.";
  stability.long_run = {
      .steps = 1000000,
      .step = 0.01,
      .methods = {{{Scheme::semi_implicit_euler, Stabilization::projection}, false},
                  {midpoint, false},
                  {rk4, false},
                  {projected, false},
                  {dop853, false}},
      .start = of({})};
  return stability;
}

int study(int argc, char** argv) {
  Scene scene;
  app::Chapter chapter;
  chapter.directory = "05_revolute";
  chapter.title = "Revolute joint";

  const app::Range lengths{1e-6, 1e6}, angles{-100.0, 100.0};
  chapter.parameters = {
      {"--links", "", "rods in the chain", &scene.links, {1, 1000}},
      {"--length", "m", "of all rods together", &scene.length, lengths},
      {"--mass", "kg", "of all rods together", &scene.mass, app::positive, app::acts},
      {"--angle0", "rad", "start, at rest: from +x towards +y, which is down", &scene.angle0,
       angles},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
      {"--without=jdotv", "", "what keeps the points of turning rods on their circles",
       &scene.without_jdotv, app::on_or_off, app::acts},
  };
  chapter.defaults = {.duration = 5.0, .step = 0.005};
  chapter.fastest = [&scene] { return scene.fastest(); };

  chapter.start =
      measure::start_of([&scene](const Method& method) { return make_mechanism(scene, method); });

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"pin force", "N"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return errors(scene, row); };

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

}  // namespace revolute
