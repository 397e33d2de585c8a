#include "study.hpp"

#include <algorithm>
#include <cmath>

#include "app/chapter.hpp"
#include "exact.hpp"
#include "mechanism.hpp"
#include "turned_off.hpp"

namespace dumbbell {
namespace {

using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<mechanics::Mechanism>;

measure::Start of(const Scene& scene) {
  return measure::start_of([=](const Method& method) { return make_mechanism(scene, method); });
}

/// How far from the exact place [m] it is at the end of so many steps.
std::function<double()> place(const Scene& scene, const Method& method, long steps, double h) {
  return measure::final_error(
      of(scene), [=](const mechanics::Row& row) { return errors(scene, row); }, 0, method, steps,
      h);
}

/// How far off the curve a bead comes [m]: |C| in m² over |∇C| ≥ 2p.
std::function<double()> off_curve(const Scene& scene, const Method& method, long steps, double h) {
  return [=, in_m2 = measure::drift(of(scene), method, steps, h)] {
    return in_m2() / (2.0 * scene.p);
  };
}

measure::Start scene_in(const measure::Units& units) {
  Scene there;
  measure::scale({&there.x1, &there.x2, &there.p}, units.length);
  measure::scale({&there.m1, &there.m2}, units.mass);
  there.gravity *= units.acceleration();
  return of(there);
}

}  // namespace

std::vector<double> errors(const Scene& scene, const mechanics::Row& row) {
  const Exact truth = ExactMotion(scene).at(row.t);
  const auto off = [](const std::vector<double>& values, std::size_t i, const Vector2d& exact) {
    return (Vector2d(values[i], values[i + 1]) - exact).squaredNorm();
  };
  const auto& [x1, x2, v1, v2, curve1, curve2, rod1] = truth;
  return {std::sqrt(off(row.state, 0, x1) + off(row.state, 4, x2)),
          std::sqrt(off(row.state, 2, v1) + off(row.state, 6, v2)),
          std::sqrt(off(row.reactions, 0, curve1) + off(row.reactions, 3, curve2) +
                    off(row.reactions, 6, rod1))};
}

measure::Stability stability() {
  using namespace measure;
  using namespace measure::usual;

  Stability stability;
  stability.cases = {
      {"equal beads level with each other: at rest", "place, m", accurate(1e-9),
       place({.x1 = -60, .x2 = 60, .m1 = 1, .m2 = 1}, projected, 2000, 0.01)},
      {"bead2 of 1e8 kg", "joint drift, m", accurate(1e-9),
       off_curve({.m2 = 1e8}, projected, 2000, 0.01)},
      {"bead2 of 1e-8 kg", "joint drift, m", accurate(1e-9),
       off_curve({.m2 = 1e-8}, projected, 2000, 0.01)},
      {"bead2 of 1e8 kg: the motion", "place, m", accurate(1e-6),
       place({.m2 = 1e8}, projected, 2000, 0.01)},
      {"bead2 of 1e-8 kg: the motion", "place, m", accurate(1e-6),
       place({.m2 = 1e-8}, projected, 2000, 0.01)},
      {"beads 1 mm apart at 60 m", "energy error, relative", accurate(1e-6),
       energy_error(of({.x1 = 60.0, .x2 = 60.001}), projected, 2000, 0.01)},
      {"from 1e4 and 2e4 m, slopes of 200 and more", "energy error, relative", accurate(1e-6),
       energy_error(of({.x1 = 1e4, .x2 = 2e4}), projected, 20000, 0.01)},
      {"both beads in one place: no rod", "", refused("x2 60"),
       place({.x1 = 60, .x2 = 60}, rk4, 1, 0.01)},
      {"bead1 on its curve twice", "place, m", accurate(1e-6),
       [=] {
         const Scene scene;
         Parts parts;
         mechanics::Mechanism mechanism = make_mechanism(scene, projected, &parts);
         mechanism.system.add("again", joints::OnCurve<joints::Parabola>{{scene.p}}, parts.bead1);
         Motion motion(std::move(mechanism), projected);
         motion.advance(1000, 0.01);
         const mechanics::Row row = motion.row();
         if (motion.model().evaluation().dependent_rows().size() != 1) return 1.0;
         return errors(scene, row)[0];
       }},
      {"feedback past its limit: h√ks = 3", "", refused("kinetic energy"),
       energy_error(of({}), feedback(9e4, 600), 20000, 0.01)},
      {"steps of 5 s with explicit_euler", "", refused("kinetic energy"),
       energy_error(of({}), {Scheme::explicit_euler, Stabilization::projection}, 1000, 5.0)},
  };
  stability.add_units(scene_in, {rk4, projected, feedback(1, 2), midpoint, adaptive}, 500, 0.01);

  stability.add_feedback(of({}), {.step = 1e-3, .nudge = 0.01});
  stability.map_remark = "Rows that push against each other still obey it, each by itself.";
  return stability;
}

int study(int argc, char** argv) {
  Scene scene;
  app::Chapter chapter;
  chapter.directory = "03_global_jacobian_solver";
  chapter.title = "The global Jacobian solver";

  chapter.parameters = {
      {"--x1", "m", "start of bead1, at rest", &scene.x1, app::any},
      {"--x2", "m", "start of bead2, at rest", &scene.x2, app::any},
      {"--m1", "kg", "mass of bead1", &scene.m1, app::positive, app::acts},
      {"--m2", "kg", "mass of bead2", &scene.m2, app::positive, app::acts},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
      {"--p", "m", "half the parameter of the parabola x² + 2py = 0", &scene.p, app::positive},
      {"--without=coupling", "", "the part of J W Jᵀ beside its diagonal", &scene.without_coupling,
       app::on_or_off, app::acts},
  };
  chapter.defaults = {.duration = 20.0, .step = 0.01};
  chapter.constraint_unit = "m²";
  chapter.fastest = [&scene] {  // of a bead alone, from the higher start
    const double x0 = std::max(std::abs(scene.x1), std::abs(scene.x2));
    return parabola::Scene{.x0 = x0, .gravity = scene.gravity, .p = scene.p}.fastest();
  };

  chapter.start = [&scene](const Method& method) {
    const auto one_by_one = [&](const Method& its) { return OneByOne(scene, its); };
    const auto together = [&](const Method& its) { return make_mechanism(scene, its); };
    return scene.without_coupling ? measure::start_of(one_by_one)(method)
                                  : measure::start_of(together)(method);
  };

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"constraint forces", "N"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return errors(scene, row); };

  chapter.ladder = {.methods = measure::methods_to_compare(1.0, 2.0),
                    .duration = 10.0,
                    .coarsest = 0.5,
                    .rungs = 16};

  chapter.stability = dumbbell::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return dumbbell::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) { return dumbbell::stage(scene, run); };
  return app::run_chapter(argc, argv, chapter);
}

}  // namespace dumbbell
