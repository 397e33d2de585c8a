#include "study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "app/chapter.hpp"
#include "exact.hpp"
#include "instruments/draw/image.hpp"
#include "instruments/files/files.hpp"
#include "instruments/files/progress.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "mechanism.hpp"

namespace prismatic {
namespace {

using mechanics::Method;
using mechanics::Stabilization;
using Motion = mechanics::Motion<mechanics::Mechanism>;

/// The block on a level rail, held by a spring [N/m] and let go 0.1 m off its rest.
Scene on_spring(double stiffness) {
  return {.incline = 0.0, .gravity = 0.0, .stiffness = stiffness, .s0 = 0.1};
}

/// The same with a damper that lets it creep back at s/10 in a second: the slow root of
/// x² + 1e5 x + 1e4. It starts in that motion, or is kicked out of it.
Scene creeping() {
  Scene scene = on_spring(1e4);
  scene.damping = 1e5;
  scene.v0 = -0.01000001;
  return scene;
}
Scene kicked() {
  Scene scene = creeping();
  scene.v0 = 1.0;
  return scene;
}

/// Whether the spring's oscillation stays bounded at a step of h_omega / √(k/m) [s].
bool spring_stays(const mechanics::Method& method, double k, double h_omega) {
  Motion motion(make_mechanism(on_spring(k), method), method);
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

measure::Errors errors_of(const Scene& scene) {
  return [=](const mechanics::Row& row) { return errors(scene, row); };
}

/// How far from the exact place [m] it is at the end of so many steps, and how far from the exact
/// velocity [m/s].
std::function<double()> place(const Scene& scene, const Method& method, long steps, double h) {
  return measure::final_error(of(scene), errors_of(scene), 0, method, steps, h);
}
std::function<double()> velocity(const Scene& scene, const Method& method, long steps, double h) {
  return measure::final_error(of(scene), errors_of(scene), 1, method, steps, h);
}

measure::Start scene_in(const measure::Units& units) {
  Scene there{.spin = 5.0};
  measure::scale({&there.width, &there.height, &there.r0}, units.length);
  measure::scale({&there.mass, &there.rail_mass}, units.mass);
  there.rail_inertia *= units.inertia();
  there.spin /= units.time;
  return of(there);
}

/// Error against run time where the damper is a hundred thousand times faster than the motion: each
/// method from 8 steps in 2 s up.
void report_stiff(const Scene& scene, const measure::Quantity& quantity, std::size_t which,
                  const std::string& name, const std::string& title, const std::string& remark,
                  const std::filesystem::path& out) {
  measure::Ladder ladder{.methods = measure::every_integrator(),
                         .duration = 2.0,
                         .coarsest = 0.25,
                         .rungs = 16,
                         .quantities = {quantity}};
  ladder.methods.push_back(
      {integrators::Scheme::dop853, Stabilization::none, 0.0, 0.0, mechanics::coarsest_tolerance});
  const auto error = [=](const mechanics::Row& row) {
    return std::vector<double>{errors(scene, row)[which]};
  };
  measure::Report report{"Prismatic joint: " + title,
                         ladder.duration,
                         "m or rad",
                         ladder.quantities,
                         measure::machine(),
                         {},
                         remark};
  {
    files::Progress progress;
    report.rungs =
        measure::climb(ladder, of(scene), error,
                       [&](double done, const std::string& what) { progress.show(done, what); });
  }
  fmt::print("\n{}\n", measure::table(report));
  files::write_file(out / (name + ".csv"), measure::csv(report));
  measure::Report drawn = measure::read_csv(out / (name + ".csv"));
  for (measure::Rung& rung : drawn.rungs)  // what flies off and is finite still: no curve to draw
    if (!rung.errors.empty() && rung.errors[0] > 1e3) rung.errors.clear();
  const auto picture = pictures::error_picture(drawn);
  files::write_file(out / (name + ".png"),
                    draw::encode_png(draw::render({.captions = false}, picture.draw)));
  fmt::print("{}\n{}\n", (out / (name + ".csv")).string(), (out / (name + ".png")).string());
}

void report_stiff_forces(const std::filesystem::path& out) {
  report_stiff(
      creeping(), {"position", "m"}, 0, "stiff",
      "A spring of 10⁴ N/m, a damper of 10⁵ N·s/m, from the slow motion",
      "No explicit method has a point further left: with steps above 2·10⁻⁵ s, RK4 2.8·10⁻⁵ s, "
      "it flies off.",
      out);
  report_stiff(kicked(), {"velocity", "m/s"}, 1, "stiff_kicked",
               "Spring and damper, kicked out of the slow motion at 1 m/s",
               "The kick dies within 10⁻⁴ s. The implicit midpoint rule turns it round in every "
               "step instead, and loses it only with some 1000 steps.",
               out);
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
      {"1e4 N/m and 1e5 N·s/m, implicit_midpoint, 8 steps", "place, m", accurate(1e-6),
       place(creeping(), {Scheme::implicit_midpoint}, 8, 0.25)},
      {"the same, rk4, 65536 steps", "", refused("no longer finite"),
       place(creeping(), rk4, 65536, 2.0 / 65536)},
      {"the same, rk4, 131072 steps", "place, m", accurate(1e-12),
       place(creeping(), rk4, 131072, 2.0 / 131072)},
      {"the same, kicked, implicit_midpoint, 8 steps", "velocity, m/s", degraded(0.5, 1.5),
       velocity(kicked(), {Scheme::implicit_midpoint}, 8, 0.25)},
      {"1e12 N/m and 1e12 N·s/m, implicit_midpoint", "place, m", accurate(1e-9),
       place({.stiffness = 1e12, .damping = 1e12}, {Scheme::implicit_midpoint}, 1000, 0.002)},
      {"feedback past its limit: h√ks = 5", "", refused("kinetic energy"),
       energy_error(of({.spin = 5.0}), feedback(6.25e6, 5e3), 2000, 0.002)},
  };
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
                               Motion motion(make_mechanism(on_spring(1e10), method), method);
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
  const auto fixes_the_rail = [](std::string_view argument) {
    constexpr std::string_view of_fixed_rail[] = {"--incline", "--gravity", "--stiffness",
                                                  "--damping", "--s0",      "--v0"};
    return std::any_of(std::begin(of_fixed_rail), std::end(of_fixed_rail),
                       [&](std::string_view option) { return argument.starts_with(option); });
  };
  if (argc > 1 && std::string_view(argv[1]) == "report" &&
      std::none_of(argv + 2, argv + argc, fixes_the_rail))
    scene.spin = 5.0;

  app::Chapter chapter;
  chapter.directory = "06_prismatic";
  chapter.title = "Prismatic joint";

  const app::Range inclines{-90.0, 90.0}, spins{-1e6, 1e6}, places{-1e6, 1e6};
  chapter.parameters = {
      {"--incline", "deg", "of the fixed rail; positive: down to the right", &scene.incline,
       inclines},
      {"--mass", "kg", "of the block", &scene.mass, app::positive, app::acts},
      {"--gravity", "m/s²", "gravity, downwards; on the fixed rail only", &scene.gravity,
       app::not_negative, app::acts},
      {"--spin", "rad/s", "of a free rail at the start, for example 5; 0: it is fixed", &scene.spin,
       spins},
      {"--stiffness", "N/m", "of a spring that pulls the block along the fixed rail to (0, 0)",
       &scene.stiffness, app::not_negative, app::acts},
      {"--damping", "N·s/m", "of a damper between block and fixed rail", &scene.damping,
       app::not_negative, app::acts},
      {"--s0", "m", "start on the fixed rail, from (0, 0)", &scene.s0, places},
      {"--v0", "m/s", "velocity along the fixed rail at the start", &scene.v0, places},
      {"--without=coriolis", "", "2 ω1 (S n)·(dd/dt), of a block that moves along a turning rail",
       &scene.without_coriolis, app::on_or_off, app::acts},
  };
  chapter.defaults = {.duration = 2.0, .step = 0.002};
  chapter.constraint_unit = "m or rad";
  chapter.fastest = [&scene] { return std::max(std::abs(scene.spin), fastest(scene)); };

  chapter.start =
      measure::start_of([&scene](const Method& method) { return make_mechanism(scene, method); });

  chapter.quantities = {{"position", "m"}, {"velocity", "m/s"}, {"force", "N"}, {"moment", "N·m"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return errors(scene, row); };

  chapter.ladder = {.methods = measure::methods_to_compare(100.0, 20.0),
                    .duration = 1.0,
                    .coarsest = 0.1,
                    .rungs = 15};

  chapter.also_report = report_stiff_forces;

  chapter.stability = prismatic::stability;

  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return prismatic::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) { return prismatic::stage(scene, run); };
  return app::run_chapter(argc, argv, chapter);
}

}  // namespace prismatic
