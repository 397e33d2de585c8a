#include "study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "app/chapter.hpp"
#include "exact.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "mechanism.hpp"

namespace prismatic {
namespace {

using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<mechanics::Mechanism>;

/// The block on a level rail, held by a spring of stiffness k [N/m] and let go 0.1 m off its rest.
/// The exact motion is 0.1 cos(√(k/m) t).
mechanics::Mechanism make_spring(double k, const mechanics::Method& method) {
  const Scene scene{.incline = 0.0, .gravity = 0.0};
  mechanics::Mechanism mechanism(method);
  dynamics::System& system = mechanism.system;
  const auto block = system.add_body("block", scene.mass, scene.inertia(), {0.1, 0.0});
  system.add("block_rail", joints::Prismatic{}, system.world, block);
  system.apply(
      block,
      [k](double, const dynamics::Body& body) { return Eigen::Vector3d(-k * body.x.x(), 0, 0); },
      [k](const dynamics::Body& body) { return 0.5 * k * body.x.x() * body.x.x(); });
  mechanism.assemble();
  return mechanism;
}

/// Whether the spring's oscillation stays bounded at a step of h_omega / √(k/m) [s].
bool spring_stays(const mechanics::Method& method, double k, double h_omega) {
  mechanics::Motion<mechanics::Mechanism> motion(make_spring(k, method), method);
  const double start = motion.measures().energy;
  try {
    for (int i = 0; i < 200; ++i) {
      motion.advance(20, h_omega / std::sqrt(k));
      if (!(motion.measures().energy < 1e3 * start)) return false;
    }
  } catch (const mechanics::Diverged&) {
    return false;
  }
  return true;
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

measure::Start scene_in(const measure::Units& units) {
  Scene there{.spin = 5.0};
  measure::scale({&there.width, &there.height, &there.r0}, units.length);
  measure::scale({&there.mass, &there.rail_mass}, units.mass);
  there.rail_inertia *= units.inertia();
  there.spin /= units.time;
  return of(there);
}

}  // namespace

std::vector<double> errors(const Scene& scene, const mechanics::Row& row) {
  const Exact truth = exact(scene, row.t);
  const double* block = row.state.data() + (scene.spins() ? 6 : 0);  // x, y, θ, vx, vy, ω
  const Vector2d x(block[0], block[1]), v(block[3], block[4]);
  const Vector2d force(row.reactions[0], row.reactions[1]);
  return {(x - truth.x).norm(), (v - truth.v).norm(), (force - truth.force).norm(),
          std::abs(row.reactions[2] - truth.moment)};
}

measure::Stability stability() {
  using namespace measure;
  using namespace measure::usual;

  Stability stability;
  // [cases]
  stability.cases = {
      {"a level rail: at rest for 1e5 steps", "place, m", accurate(1e-12),
       place({.incline = 0.0}, rk4, 100000, 1e-3)},
      {"an upright rail: free fall", "place, m", accurate(1e-9),
       place({.incline = 90.0}, rk4, 2000, 1e-3)},
      {"block of 1e8 kg on the spinning rail", "joint drift, m or rad", accurate(1e-9),
       drift(of({.mass = 1e8, .spin = 5.0}), projected, 1000, 1e-3)},
      {"block of 1e-8 kg on the spinning rail", "joint drift, m or rad", accurate(1e-9),
       drift(of({.mass = 1e-8, .spin = 5.0}), projected, 1000, 1e-3)},
      {"block of 1e-8 kg: the motion", "place, m", accurate(1e-6),
       place({.mass = 1e-8, .spin = 5.0}, projected, 1000, 1e-3)},
      {"block of 1e8 kg: the motion", "place, m", accurate(1e-6),
       place({.mass = 1e8, .spin = 5.0}, projected, 1000, 1e-3)},
      {"rail at 1e4 rad/s, steps of 5e-7 s", "place, m", accurate(1e-6),
       place({.spin = 1e4}, projected, 1000, 5e-7)},
      {"rail at 1e4 rad/s, steps of 2e-3 s", "", refused("kinetic energy"),
       energy_error(of({.spin = 1e4}), rk4, 1000, 2e-3)},
      {"a second rail in the same line", "place, m", accurate(1e-9),
       [=] {
         const Scene scene;
         mechanics::Mechanism mechanism = make_incline(scene, projected);
         mechanism.system.add(
             "again", joints::Prismatic{.n_hat = across(scene.angle()), .theta21 = scene.angle()},
             dynamics::System::world, mechanism.system.thing<dynamics::Body>("block"));
         Motion motion(std::move(mechanism), projected);
         motion.advance(1000, 1e-3);
         const mechanics::Row row = motion.row();
         if (motion.model().evaluation().dependent_rows().size() != 2) return 1.0;
         return errors(scene, row)[0];
       }},
      {"feedback past its limit: h√ks = 5", "", refused("kinetic energy"),
       energy_error(of({.spin = 5.0}), feedback(6.25e6, 5e3), 2000, 0.002)},
  };
  // [cases]
  stability.add_units(scene_in, {rk4, projected, feedback(100, 20), midpoint, adaptive}, 100, 1e-3);

  // A stiff spring on the block: the limit of h √(k/m), for every stiffness the same.
  for (const auto& scheme : integrators::schemes) {
    double theory = 0.0, unstable = 8.0;
    for (int i = 0; i < 14; ++i) {
      const double h_omega = 0.5 * (theory + unstable);
      const bool stays = integrators::amplification(scheme.id, h_omega, 1.0, 0.0) <= 1.0 + 1e-3;
      (stays ? theory : unstable) = h_omega;
    }
    for (const double k : {1e2, 1e6, 1e10}) {
      const std::string name =
          theory > 7.9 ? fmt::format("{:g} N/m, {}: any step (to 8)", k, scheme.text)
                       : fmt::format("{:g} N/m, {}: h√(k/m) to {:.3g}{}", k, scheme.text, theory,
                                     scheme.id == Scheme::explicit_euler ? " *" : "");
      stability.cases.push_back(
          {name, "spring limit found, off theory's", accurate(0.05), [=, integrator = scheme.id] {
             double found = 0.0, too_long = 8.0;
             for (int i = 0; i < 14; ++i) {
               const double h_omega = 0.5 * (found + too_long);
               (spring_stays({integrator}, k, h_omega) ? found : too_long) = h_omega;
             }
             return std::abs(found - theory);
           }});
    }
  }
  stability.cases.push_back({"1e10 N/m, implicit_midpoint, steps of 0.01 s",
                             "energy error, relative", accurate(1e-9), [] {
                               const Method method{Scheme::implicit_midpoint};
                               Motion motion(make_spring(1e10, method), method);
                               const double start = motion.measures().energy;
                               motion.advance(1000, 0.01);
                               return std::abs(motion.measures().energy / start - 1.0);
                             }});

  const Start spinning = of({.spin = 5.0});
  stability.add_feedback(spinning, {.step = 1e-4, .nudge = 1e-3});
  stability.map_remark = "Measured on the spinning rail, with the block on its way out.";
  return stability;
}

int study(int argc, char** argv) {
  Scene scene;
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

  chapter.start =
      measure::start_of([&scene](const Method& method) { return make_mechanism(scene, method); });

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"force", "N"}, {"moment", "N·m"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return errors(scene, row); };

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

}  // namespace prismatic
