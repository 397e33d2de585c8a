#include "study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/chapter.hpp"
#include "instruments/draw/image.hpp"
#include "instruments/files/files.hpp"
#include "instruments/files/table.hpp"
#include "instruments/measure/clock.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "path_bead.hpp"

namespace any_wire {
namespace {

using mechanics::Method;

/// What follows an option on the command line; empty where it is not given.
std::string given(int argc, char** argv, const std::string& option) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == option && i + 1 < argc) return argv[i + 1];
    if (argument.starts_with(option + "=")) return argument.substr(option.size() + 1);
  }
  return "";
}

/// Tangents that make the second derivative of a Hermite spline continuous, and zero at its ends:
/// m[i−1] + 4 m[i] + m[i+1] = 3 (p[i+1] − p[i−1]), by elimination.
std::string smooth_tangents(const paths::Points& p) {
  const std::size_t n = p.size();
  std::vector<double> diagonal(n, 4.0);
  diagonal.front() = diagonal.back() = 2.0;
  paths::Points m(n);
  for (std::size_t i = 0; i < n; ++i)
    m[i] = 3 * (p[std::min(i + 1, n - 1)] - p[i == 0 ? 0 : i - 1]);
  for (std::size_t i = 1; i < n; ++i) {
    m[i] -= m[i - 1] / diagonal[i - 1];
    diagonal[i] -= 1 / diagonal[i - 1];
  }
  m[n - 1] /= diagonal[n - 1];
  for (std::size_t i = n - 1; i-- > 0;) m[i] = (m[i] - m[i + 1]) / diagonal[i];
  std::string text;
  for (const Vector2d& tangent : m)
    text += fmt::format("{:.17g},{:.17g} ", tangent.x(), tangent.y());
  return text;
}

Scene scene_of(const std::string& path, const std::string& by) {
  Scene scene = preset(path).scene;
  scene.by = by;
  return scene;
}

double rate_of_swings(const Scene& scene) { return std::sqrt(scene.gravity / (4 * scene.radius)); }

/// Whether a swing on the cycloid stays what it is: its energy grows neither from the second
/// quarter of 1000 steps to the last, nor to `most_growth` times the first.
bool swing_stays(const std::string& by, integrators::Scheme scheme, double h_omega, double angle,
                 double most_growth) {
  Scene scene = scene_of("cycloid", by);
  scene.q0 = angle;
  const double h = h_omega / rate_of_swings(scene);
  try {
    const auto bead = start(scene)({.integrator = scheme});
    const double bottom = -scene.mass * scene.gravity * 2 * scene.radius;
    const double first = bead->measures().energy - bottom;
    double quarters[4] = {};
    for (double& most : quarters)
      for (int step = 0; step < 250; ++step) {
        bead->advance(1, h);
        most = std::max(most, bead->measures().energy - bottom);
      }
    return quarters[3] <= 1.5 * quarters[1] && quarters[3] <= most_growth * first;
  } catch (const mechanics::Diverged&) {
    return false;
  }
}

/// By length the bead is an oscillator whatever its angle: the factor of a step, or, where that is
/// 1, whether the swing of the method reaches the cusps. Semi-implicit Euler keeps
/// v² + Ω²s² − hΩ² s v, so that a swing from rest at s comes to s/√(1 − (hΩ/2)²).
double growth_by_length(integrators::Scheme scheme, double h_omega, double angle) {
  const double growth = integrators::amplification(scheme, h_omega, 1.0, 0.0);
  if (scheme != integrators::Scheme::semi_implicit_euler || h_omega >= 2.0) return growth;
  return std::max(growth, std::sin(angle / 2) / std::sqrt(1 - h_omega * h_omega / 4));
}

/// How far from the exact place [m] the bead is at the end of so many steps.
std::function<double()> place(const Scene& scene, const Method& method, long steps, double h) {
  return measure::final_error(
      start(scene), [=](const mechanics::Row& row) { return errors(scene, row); }, 0, method, steps,
      h);
}

/// The largest force [N] of the wire over a run.
std::function<double()> largest_force(const Scene& scene, long steps, double h) {
  return [=] {
    const auto bead = start(scene)({});
    double most = 0.0;
    measure::run(*bead, {steps, h}, [&](const mechanics::Row& row) {
      most = std::max(most, std::hypot(row.reactions[0], row.reactions[1]));
    });
    return most;
  };
}

/// A second in so many steps. To knots: where one would go over a knot, towards growing q, it is
/// cut there, by regula falsi on its length, and the rest is a step of its own.
void move_on(mechanics::Simulation& bead, mechanics::Simulation& trial, const paths::Path& path,
             long steps, bool to_knots) {
  const double h = 1.0 / static_cast<double>(steps);
  if (!to_knots) return bead.advance(steps, h);
  for (long step = 0; step < steps; ++step)
    for (double rest = h; rest > 0.0;) {
      const auto knot =
          std::upper_bound(path.knots.begin(), path.knots.end(), bead.row().state[0] + 1e-9);
      const auto beyond = [&](double part) {
        trial.take_over(bead);
        trial.advance(1, part);
        return trial.row().state[0] - *knot;
      };
      double part = rest;
      if (double high = rest, over; knot != path.knots.end() && (over = beyond(rest)) > 0.0) {
        double low = 0.0, under = bead.row().state[0] - *knot;
        for (double off = over; std::abs(off) > 1e-13 && high > std::nextafter(low, high);) {
          part = low - under * (high - low) / (over - under);
          off = beyond(part);
          if (off > 0.0) {
            high = part, over = off, under /= 2;
          } else {
            low = part, under = off, over /= 2;
          }
        }
      }
      bead.advance(1, part);
      rest -= part;
    }
}

/// Mean error of place [m] after 1 s over start speeds from 2.5 to 3.5 m/s: single runs are
/// erratic, since where in a step a knot falls changes with the step.
std::vector<double> mean_errors(Scene scene, bool to_knots) {
  std::vector<double> means(5, 0.0);
  for (int i = 0; i < start_speeds; ++i) {
    scene.speed = 2.5 + (i + 0.5) / start_speeds;
    const auto exact = exact_motion(scene)(1.0);
    const paths::Path path = path_of(scene);
    const auto bead = start(scene)({}), trial = start(scene)({});
    for (std::size_t k = 0; k < means.size(); ++k) {
      bead->restart();
      move_on(*bead, *trial, path, coarsest_steps << k, to_knots);
      const std::vector<double> state = bead->row().state;
      means[k] += (Vector2d(state[2], state[3]) - path(exact->q).x).norm() / start_speeds;
    }
  }
  return means;
}

std::string table(const std::vector<Order>& orders) {
  files::Table table({"wire", "by", "h = 1/50 s", "h = 1/800 s", "order", "ns a step"});
  for (const Order& o : orders)
    table.add(o.wire, o.by, fmt::format("{:.1e} m", o.errors.front()),
              fmt::format("{:.1e} m", o.errors.back()), fmt::format("{:.2f}", o.order),
              fmt::format("{:.0f}", 1e9 * o.seconds));
  return table.text({-24, -18, 12, 12, 8, 12});
}

void report_orders(const std::filesystem::path& out) {
  const std::vector<Order> all = orders();
  fmt::print("\nRK4 on splines, mean error after 1 s over {} start speeds\n{}\n", start_speeds,
             table(all));
  files::Table csv({"wire", "by", "step", "error", "seconds of a step"});
  for (const Order& o : all)
    for (std::size_t k = 0; k < o.errors.size(); ++k)
      csv.add(o.wire, o.by, files::digits(1.0 / static_cast<double>(coarsest_steps << k)),
              files::digits(o.errors[k]), files::digits(o.seconds));
  const auto write = [&](const std::string& name, const std::string& content) {
    files::write_file(out / name, content);
    fmt::print("{}\n", (out / name).string());
  };
  write("orders.csv", csv.csv());
  write("orders.png",
        draw::encode_png(draw::render({.captions = false}, orders_picture(all).draw)));
}

}  // namespace

measure::Start start(const Scene& scene) {
  return [scene](const Method& method) -> std::unique_ptr<mechanics::Simulation> {
    if (scene.by_length())
      return std::make_unique<mechanics::Motion<BeadByLength>>(BeadByLength(scene), method);
    return std::make_unique<mechanics::Motion<BeadByParameter>>(BeadByParameter(scene), method);
  };
}

Wire as_energy_sees(const paths::Path& path) {
  return {.depth = [path](double q) { return path(q).x.y(); },
          .slope = [path](double q) { return path(q).d.y(); },
          .stretch = [path](double q) { return path(q).d.norm(); },
          .first = path.first,
          .last = path.last,
          .knots = path.knots,
          .closed = path.closed};
}

std::function<std::optional<State>(double)> exact_motion(const Scene& scene) {
  const State from{scene.q0, scene.speed};
  const EnergyMotion any(as_energy_sees(path_of(scene)), scene.gravity, from);
  return [=](double t) {
    if (scene.path == "cycloid")
      if (const auto state = on_cycloid(scene.radius, scene.gravity, from, t)) return state;
    return any.at(t);
  };
}

std::vector<double> errors(const Scene& scene, const mechanics::Row& row) {
  const auto exact = exact_motion(scene)(row.t);
  if (!exact) return {};
  const Vector2d x = path_of(scene)(exact->q).x;
  return {std::hypot(row.state[2] - x.x(), row.state[3] - x.y()),
          std::abs(row.state[1] - exact->speed)};
}

std::vector<Order> orders() {
  Scene smooth = scene_of("hermite_spline", "parameter");
  smooth.tangents = smooth_tangents(points_of("points", smooth.points));
  std::vector<Order> orders;
  const std::string by_knots = "length to knots";
  for (const auto& [name, scene] :
       {std::pair{"C2 spline", smooth}, std::pair{"Catmull-Rom (C1)", preset("catmull_rom").scene},
        std::pair{"linear spline", preset("linear_spline").scene}})
    for (const std::string& by : {std::string("parameter"), std::string("length"), by_knots}) {
      const bool to_knots = by == by_knots;
      if (to_knots && scene.path != "catmull_rom") continue;
      Scene one = scene;
      one.by = to_knots ? "length" : by;
      const std::vector<double> errors = mean_errors(one, to_knots);
      const auto bead = start(one)({}), trial = start(one)({});
      const paths::Path path = path_of(one);
      const double seconds = measure::seconds_of(
          [&] {
            bead->restart();
            move_on(*bead, *trial, path, 100, to_knots);
          },
          {.samples = 4, .most = 0.01});
      orders.push_back(
          {name, by, errors,
           std::log2(errors.front() / errors.back()) / static_cast<double>(errors.size() - 1),
           seconds / 100.0});
    }
  return orders;
}

measure::Stability stability() {
  using namespace measure;
  using namespace measure::usual;
  constexpr double pi = std::numbers::pi;

  const auto on = [](const char* path, const char* by, auto change) {
    Scene scene = scene_of(path, by);
    change(scene);
    return scene;
  };
  const auto from = [&](const char* by, double q0) {
    return on("cycloid", by, [=](Scene& s) { s.q0 = q0; });
  };
  const auto doubled = [&](const char* by) {
    return on("cubic", by, [](Scene& s) { s.points = "0,0 0,0 1,2 3,1"; });
  };
  const auto same = [](Scene&) {};
  const auto corner = [&](const char* by) {
    return on("linear_spline", by, [](Scene& s) {
      s.points = "0,0 1,0 2.650671229819357,1.1292849467900707";  // 1 m, a turn of 0.6 rad, 2 m
      s.speed = 1.0;
      s.gravity = 0.0;
    });
  };
  Stability stability;
  stability.cases = {
      {"at rest at the bottom", "place, m", accurate(0.0),
       place(from("parameter", 0), rk4, 1000, 0.01)},
      {"a swing of 1e-6 rad, by length", "place, m", accurate(1e-11),
       place(from("length", 1e-6), rk4, 1000, 0.01)},
      {"from 3.1, near the cusp, by parameter", "place, m", degraded(1e-7, 1e-4),
       place(from("parameter", 3.1), rk4, 2500, 0.002)},
      {"the same by length", "place, m", accurate(1e-9),
       place(from("length", 3.1), rk4, 2500, 0.002)},
      {"from the cusp, by parameter", "", refused("x' = 0"),
       place(from("parameter", pi), rk4, 2500, 0.002)},
      {"from the cusp, by length", "place, m", accurate(1e-8),
       place(from("length", pi), rk4, 2500, 0.002)},
      {"two equal control points, by parameter", "", refused("x' = 0"),
       place(doubled("parameter"), rk4, 400, 0.001)},
      {"two equal control points, by length", "place, m", degraded(1e-8, 1e-5),
       place(doubled("length"), rk4, 400, 0.001)},
      {"a corner, by parameter: its speed is not kept", "", refused("kinetic energy"),
       place(corner("parameter"), rk4, 2000, 0.001)},
      {"the same corner, by length", "place, m", accurate(1e-12),
       place(corner("length"), rk4, 2000, 0.001)},
      {"past the end of the wire", "", refused("leaves the wire at t = 1.16289102"),
       place(on("cubic", "parameter", same), rk4, 2000, 0.001)},
      {"around the circle at 20 m/s, by length", "place, m", accurate(1e-6),
       place(on("circle", "length", [](Scene& s) { s.speed = 20.0; }), rk4, 10000, 0.001)},
      {"a spiral of 100 rad, by length", "place, m", accurate(1e-6),
       place(on("spiral", "length",
                [](Scene& s) {
                  s.turns = 100.0;
                  s.speed = 20.0;
                }),
             rk4, 2000, 0.0005)},
      {"a projectile on its own path", "force of the wire, N", accurate(1e-12),
       largest_force(on("projectile", "parameter", same), 1000, 0.001)},
      {"mass 1e-8 kg", "place, m", accurate(1e-6),
       place(on("cubic", "parameter", [](Scene& s) { s.mass = 1e-8; }), rk4, 800, 0.001)},
      {"gravity 1e6 m/s², steps of 1e-6 s", "place, m", accurate(1e-6),
       place(on("cycloid", "length", [](Scene& s) { s.gravity = 1e6; }), rk4, 20000, 1e-6)},
      {"steps of 1 s with explicit_euler", "", refused(""),
       energy_error(start(from("length", 1.0)), {Scheme::explicit_euler}, 1000, 1.0)},
  };
  // RK4's stages beyond the cusp see a force that grows no more: above its limit a swing can go on
  // at a width of its own, of some 1 rad. Hence no more than 5 % of growth, and narrower starts.
  const auto plan = [&](const char* by, Scheme scheme, double theory_to, int differing,
                        auto growth) {
    const bool rk4 = scheme == Scheme::rk4;
    stability.plans.push_back(
        {scheme, "h Ω", "start q0 [rad]", rk4 ? 4.0 : 3.0, pi,
         [=](double h_omega, double angle) {
           return swing_stays(by, scheme, h_omega, angle, rk4 ? 1.05 : 100.0);
         },
         [=](double h_omega, double angle) { return growth(scheme, h_omega, angle); }, theory_to,
         differing, fmt::format("{}, by {}", integrators::info(scheme).text, by)});
  };
  const auto small_swings = [](Scheme scheme, double h_omega, double) {
    return integrators::amplification(scheme, h_omega, 1.0, 0.0);
  };
  plan("parameter", Scheme::semi_implicit_euler, 0.2, 19, small_swings);
  plan("parameter", Scheme::rk4, 0.2, 0, small_swings);
  plan("length", Scheme::semi_implicit_euler, pi, 0, growth_by_length);
  plan("length", Scheme::rk4, 1.0, 0, growth_by_length);
  stability.map_remark =
      "By its length the bead is an oscillator of one rate Ω at every width. By its parameter "
      "theory is that of small swings, the bottom rows, and semi-implicit Euler gains energy even "
      "there.";
  return stability;
}

int study(int argc, char** argv) {
  const Preset chosen = preset(given(argc, argv, "--path"));
  Scene scene = chosen.scene;
  try {  // a projectile is launched with its bead
    if (const auto launch = points_of("launch", given(argc, argv, "--launch")); launch.size() == 1)
      if (scene.path == "projectile") scene.speed = launch[0].norm();
  } catch (const std::invalid_argument&) {  // refused where the path is made
  }
  std::vector<std::string> names;
  for (const Preset& one : presets()) names.push_back(one.scene.path);

  app::Chapter chapter;
  chapter.directory = "08_paths";
  chapter.title = "Any wire";

  chapter.parameters = {
      {"--q0", "", "start, by the path's parameter", &scene.q0, app::any},
      {"--speed", "m/s", "speed at the start, along growing q", &scene.speed, {-1e6, 1e6}},
      {"--mass", "kg", "mass of the particle", &scene.mass, app::positive, app::acts},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, {0.0, 1e9}},
  };
  for (const Number& n : numbers())
    chapter.parameters.push_back({n.option, n.unit, n.help, &(scene.*n.place), n.allowed});
  chapter.texts = {
      {"--path", "NAME", "the wire; the defaults of the others are its own", &scene.path, names},
      {"--by", "NAME", "what the bead is described by", &scene.by, {"parameter", "length"}},
      {"--points", "\"x,y ...\"", "of a line, Bézier curve or spline [m]", &scene.points},
      {"--tangents", "\"x,y ...\"", "of a Hermite spline, one at each point", &scene.tangents},
      {"--launch", "\"vx,vy\"", "of the projectile [m/s]; the bead's speed, too", &scene.launch},
      {"--file", "FILE",
       "of a sequence: a line a piece, its cue, its path and options; another file is a piece",
       &scene.file},
  };
  chapter.defaults = {.duration = chosen.duration, .step = 0.005};
  chapter.has_constraints = false;
  chapter.fastest = [&scene] { return fastest(scene); };
  chapter.cure = [&scene]() -> app::Cure {
    if (scene.by_length()) return {};
    const Parameter parameter = parameter_of(path_of(scene));
    if (parameter == Parameter::good) return {};
    return {.option = "--by length", .alone = parameter == Parameter::wrong};
  };
  chapter.start = [&scene](const Method& method) { return start(scene)(method); };

  chapter.quantities = {{"position", "m"}, {"speed", "m/s"}};
  chapter.errors = [&scene](const mechanics::Row& row) { return errors(scene, row); };

  chapter.ladder = {.methods = measure::every_integrator(),
                    .duration = chosen.duration,
                    .coarsest = chosen.duration / 50,
                    .rungs = 16};
  chapter.ladder.methods.push_back(
      {.integrator = integrators::Scheme::dop853, .tolerance = mechanics::coarsest_tolerance});
  chapter.also_report = [&scene](const std::filesystem::path& out) {
    if (scene.path == "cycloid") report_orders(out);
  };

  chapter.stability = any_wire::stability;
  chapter.pictures = [&scene](const measure::RunOptions& run) {
    return any_wire::pictures(scene, run);
  };
  chapter.stage = [&scene](const measure::RunOptions& run) { return any_wire::stage(scene, run); };
  return app::run_chapter(argc, argv, chapter);
}

}  // namespace any_wire
