#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "instruments/pictures/lesson.hpp"
#include "instruments/pictures/mechanism_stage.hpp"
#include "mechanism.hpp"
#include "study.hpp"

namespace revolute {
namespace {

using namespace pictures::lesson;

using Motion = mechanics::Motion<mechanics::Mechanism>;

Motion motion(const Scene& scene, const mechanics::Method& method = {}) {
  return {make_mechanism(scene, method), method};
}

/// The chain at one time: each rod from its near to its far end, so that a pin that has opened is
/// seen, and the force of the world's pin.
struct Instant {
  double t;
  std::vector<std::array<Vector2d, 2>> rods;
  Vector2d pin_force;

  const Vector2d& end() const { return rods.back()[1]; }
};

Instant now(const Scene& scene, Motion& motion) {
  const mechanics::Row row = motion.row();
  Instant instant{row.t, {}, {row.reactions[0], row.reactions[1]}};
  for (int i = 0; i < scene.links; ++i) {
    const Vector2d center = motion.q().segment<2>(3 * i), end = end_of_rod(scene, motion.q(), i);
    instant.rods.push_back({2.0 * center - end, end});
  }
  return instant;
}

/// Moves on to the step nearest to t.
void advance_to(Motion& motion, double t, double step) {
  const long steps = std::lround((t - motion.time()) / step);
  if (steps > 0) motion.advance(steps, step);
}

/// `count` instants from 0 to `duration`, evenly spaced.
std::vector<Instant> exposures(const Scene& scene, Motion& motion, double duration, double step,
                               int count) {
  std::vector<Instant> instants;
  for (int i = 0; i < count; ++i) {
    advance_to(motion, duration * i / (count - 1), step);
    instants.push_back(now(scene, motion));
  }
  return instants;
}

void draw_chain(Canvas& canvas, const Instant& instant, double width_points, double presence) {
  const auto& theme = canvas.theme();
  for (const auto& [near, far] : instant.rods)
    canvas.link(point(near), point(far), width_points, theme.body.faded(presence),
                theme.body_edge.faded(presence));
  Vector2d held(0.0, 0.0);  // the point that the next rod hangs on
  for (const auto& [near, far] : instant.rods) {
    canvas.gap(point(held), point(near));
    held = far;
  }
}

/// What encloses the points, with some room around it.
draw::View view_of(const std::vector<draw::Point>& points, double room) {
  draw::View view{0.0, 0.0, 0.0, 0.0};
  for (const draw::Point& p : points)
    view = {std::min(view.left, p.x), std::min(view.top, p.y), std::max(view.right, p.x),
            std::max(view.bottom, p.y)};
  const double margin = room * std::max(view.right - view.left, view.bottom - view.top);
  return {view.left - margin, view.top - margin, view.right + margin, view.bottom + margin};
}

/// Metres for a newton, so that the largest of some forces is drawn a given part of L long.
double force_scale(const Scene& scene, double largest, double part) {
  return largest > 0.0 ? part * scene.length / largest : 0.0;
}

/// Where a body is that is drawn to explain.
struct Pose {
  Vector2d x;
  double theta;

  Vector2d turned(const Vector2d& u) const {
    return {std::cos(theta) * u.x() - std::sin(theta) * u.y(),
            std::sin(theta) * u.x() + std::cos(theta) * u.y()};
  }
};

/// A body with the cross of its own frame, its point u, and the lever A u to it.
void draw_body(Canvas& canvas, const Pose& body, const Vector2d& u, const std::string& lever,
               bool frame) {
  const auto& theme = canvas.theme();
  canvas.box(point(body.x), 0.9, 0.5, body.theta, theme.body.faded(0.5), theme.body_edge);
  if (frame)
    for (const Vector2d& axis : {Vector2d(0.36, 0.0), Vector2d(0.0, 0.36)})
      canvas.arrow(point(body.x), point(body.turned(axis)), theme.muted,
                   axis.y() == 0.0 ? "x′" : "y′");
  canvas.arrow(point(body.x), point(body.turned(u)), theme.constraint_force);
  canvas.label(point(body.x + 0.5 * body.turned(u)), lever, theme.constraint_force,
               draw::Font::text, draw::Align::center, {0.0, 14.0});
  canvas.bead(point(body.x), 3.5, theme.ink, theme.ink);
}

/// A point of a body in the body's own frame and in the world's, and two bodies on one pin.
Picture frames_picture() {
  const Vector2d u(0.3, 0.17);
  return {
      "frames", [=](draw::Pen& pen) {
        const draw::Rect content =
            draw::page(pen, "A point of a body, and a pin that joins two",
                       "Left above in the body's own frame, below in the world: r = x + A u. "
                       "Right two bodies whose points coincide: r₁ = r₂.");
        const double gap = 14.0, half = 0.5 * (content.width - gap),
                     low = 0.4 * (content.height - gap);
        const auto heading = [&](Canvas& canvas, const draw::View& view, const char* text) {
          canvas.label({view.left, view.top}, text, canvas.theme().ink, draw::Font::bold);
        };
        const auto vector = [](Canvas& canvas, const Vector2d& to, const std::string& name,
                               draw::Color color) {
          canvas.arrow({0.0, 0.0}, point(to), color, name);
        };
        {
          const draw::View view{-0.55, -0.42, 0.6, 0.5};
          Canvas canvas(pen, {content.left, content.top, half, low}, view);
          heading(canvas, view, "own frame");
          draw_body(canvas, {{0.0, 0.0}, 0.0}, u, "u", true);
          canvas.pin(point(u));
        }
        {
          const draw::View view{-0.15, -0.2, 1.55, 1.2};
          Canvas canvas(
              pen, {content.left, content.top + low + gap, half, content.height - low - gap}, view);
          heading(canvas, view, "world");
          const Pose body{{0.8, 0.75}, 0.55};
          canvas.origin({0.0, 0.0});
          draw_body(canvas, body, u, "A u", true);
          vector(canvas, body.x, "x", canvas.theme().ink);
          vector(canvas, body.x + body.turned(u), "r = x + A u", canvas.theme().applied_force);
          const std::array level{point(body.x), point(body.x + Vector2d(0.62, 0.0))};
          canvas.curve(level, canvas.theme().muted, 1.2, draw::Dash::dashed);
          canvas.turn(point(body.x), 50.0, 0.0, body.theta, canvas.theme().muted, "θ");
          canvas.pin(point(body.x + body.turned(u)));
        }
        const draw::View view{-0.15, -0.25, 1.55, 1.5};
        Canvas canvas(pen, {content.left + half + gap, content.top, half, content.height}, view);
        heading(canvas, view, "two bodies, one pin");
        const Vector2d pin(0.74, 0.95), u2(-0.36, 0.05);
        Pose first{{0.0, 0.0}, -0.6}, second{{0.0, 0.0}, -0.3};
        first.x = pin - first.turned(u);
        second.x = pin - second.turned(u2);
        canvas.origin({0.0, 0.0});
        draw_body(canvas, first, u, "A₁u₁", false);
        draw_body(canvas, second, u2, "A₂u₂", false);
        vector(canvas, first.x, "x₁", canvas.theme().ink);
        vector(canvas, second.x, "x₂", canvas.theme().ink);
        canvas.pin(point(pin));
        canvas.label(point(pin), "r₁ = r₂", canvas.theme().applied_force, draw::Font::bold,
                     draw::Align::left, {4.0, 44.0});
      }};
}

Picture scene_picture(const Scene& given) {
  Scene scene = given;
  scene.links = 1;
  Motion start = motion(scene);
  const Instant instant = now(scene, start);
  const Vector2d end = instant.end(), middle = end / 2;
  const double weight = scene.mass * scene.gravity, pin = instant.pin_force.norm();
  const double scale = force_scale(scene, std::max(weight, pin), 0.35);
  const Vector2d weight_arrow(0.0, scale * weight), pin_arrow = scale * instant.pin_force;
  const std::string caption = fmt::format(
      "At the instant of release the pin carries {} N, {:.0f} % of the weight of {} N: the "
      "rest of it starts the rod.",
      pictures::rounded(pin), weight > 0.0 ? 100.0 * pin / weight : 0.0, pictures::rounded(weight));
  const draw::View view = view_of(
      {point(end), point(middle + weight_arrow), point(pin_arrow), {0.0, 0.25 * scene.length}},
      0.16);
  return {"scene", [=](draw::Pen& pen) {
            Canvas canvas(pen, draw::page(pen, "A rod, pinned to the world at one end", caption),
                          view);
            canvas.axes("m");
            const auto& theme = canvas.theme();
            canvas.ground({0.0, 0.0}, std::numbers::pi / 2, 72.0);
            draw_chain(canvas, instant, 18.0, 1.0);
            canvas.arrow(point(middle), point(-middle), theme.ink);
            canvas.pin({0.0, 0.0});
            canvas.bead(point(middle), 4.0, theme.ink, theme.ink);
            canvas.arrow(point(middle), point(weight_arrow), theme.weight,
                         fmt::format("weight {} N", pictures::rounded(weight)));
            canvas.arrow({0.0, 0.0}, point(pin_arrow), theme.constraint_force,
                         fmt::format("pin force {} N", pictures::rounded(pin)));
            canvas.force_scale(scale);
            canvas.label({0.0, 0.0}, "pin in the world: C = x + A u = 0", theme.track,
                         draw::Font::bold, draw::Align::left, {14.0, 30.0});
            canvas.label(point(middle), "centre of mass x", theme.ink, draw::Font::text,
                         draw::Align::left, {8.0, -20.0});
            canvas.label(point(end), "free end", theme.ink, draw::Font::text, draw::Align::right,
                         {0.0, -20.0});
            canvas.label(point(middle / 2), fmt::format("A u,  u = (−{:g}, 0) m", scene.length / 2),
                         theme.ink, draw::Font::text, draw::Align::center, {0.0, -20.0});
          }};
}

/// The way of the single rod from its start to its far side.
Picture motion_picture(const Scene& given, const RunOptions& run) {
  Scene scene = given;
  scene.links = 1;
  constexpr int count = 13;
  const double small_swing =
      std::numbers::pi * std::sqrt(2.0 * scene.length / (3.0 * scene.gravity));
  const double duration = std::min(1.18 * small_swing, run.duration);  // 1.18: from horizontal
  Motion rod = motion(scene, run.method);
  const std::vector<Instant> instants = exposures(scene, rod, duration, run.step, count);
  double largest = 0.0;
  for (const Instant& instant : instants) largest = std::max(largest, instant.pin_force.norm());
  const double scale = force_scale(scene, largest, 0.55), weight = scene.mass * scene.gravity;
  std::vector<draw::Point> seen;
  for (const Instant& instant : instants) {
    seen.push_back(point(instant.end()));
    seen.push_back(point(scale * instant.pin_force));
  }
  const draw::View view = view_of(seen, 0.08);
  std::string caption = fmt::format("The pin carries up to {} N", pictures::rounded(largest));
  if (weight > 0.0) caption += fmt::format(", {:.2f} times the weight", largest / weight);
  caption += fmt::format(" ({}, step {:g} s).", run.method.label(), run.step);
  return {
      "motion", [=](draw::Pen& pen) {
        Canvas canvas(
            pen,
            draw::page(pen,
                       fmt::format("A rod on a pin: {} instants, from t = 0 to t = {:.2f} s", count,
                                   instants.back().t),
                       caption),
            view);
        canvas.axes("m");
        const auto& theme = canvas.theme();
        for (std::size_t i = 0; i < instants.size(); ++i) {
          const Instant& instant = instants[i];
          const double presence = 0.3 + 0.7 * static_cast<double>(i) / (count - 1);
          draw_chain(canvas, instant, 9.0, presence);
          const Vector2d& end = instant.end();
          if (i % 2 == 0)
            canvas.label(point(end), fmt::format("{:.2f} s", instant.t), theme.muted,
                         draw::Font::small, end.x() < 0.0 ? draw::Align::right : draw::Align::left,
                         {end.x() < 0.0 ? -10.0 : 10.0, 12.0});
        }
        for (const Instant& instant : instants)
          canvas.arrow({0.0, 0.0}, point(scale * instant.pin_force), theme.constraint_force);
        canvas.force_scale(scale);
        canvas.pin({0.0, 0.0});
        canvas.label({0.0, view.top}, "arrows: force of the pin on the rod", theme.constraint_force,
                     draw::Font::bold, draw::Align::center, {0.0, 12.0});
      }};
}

/// A chain falling from its start.
Picture chain_picture(const Scene& given, const RunOptions& run) {
  Scene scene = given;
  scene.links = 20;
  constexpr int count = 8;
  const double fall = std::sqrt(scene.length / std::max(scene.gravity, 1e-12));
  const double duration = std::min(2.4 * fall, run.duration);
  // Fine enough for the whip at the end, whose links are short.
  const double step = duration / 2100.0;
  Motion chain = motion(scene, {run.method.integrator, Stabilization::projection});
  const double energy = chain.measures().energy;
  const std::vector<Instant> instants = exposures(scene, chain, duration, step, count);
  const double lost = std::abs(chain.measures().energy - energy);
  std::vector<draw::Point> seen;
  for (const Instant& instant : instants)
    for (const auto& [near, far] : instant.rods) seen.push_back(point(far));
  const draw::View view = view_of(seen, 0.06);
  const std::string caption = fmt::format(
      "20 links of {:g} m: 60 coordinates, 40 rows, 20 degrees of freedom. Energy kept to {} J "
      "(step {} s).",
      scene.l(), pictures::figure(lost), pictures::figure(step));
  return {"chain", [=](draw::Pen& pen) {
            Canvas canvas(pen,
                          draw::page(pen,
                                     fmt::format("A chain falls: {} instants, from t = 0 to t = "
                                                 "{:.2f} s",
                                                 count, duration),
                                     caption),
                          view);
            canvas.axes("m");
            const auto& theme = canvas.theme();
            for (std::size_t i = 0; i < instants.size(); ++i) {
              const Instant& instant = instants[i];
              draw_chain(canvas, instant, 7.0, 0.25 + 0.75 * static_cast<double>(i) / (count - 1));
            }
            for (const Instant& instant : instants) {
              const Vector2d& end = instant.end();
              canvas.label(point(end), fmt::format("{:.2f} s", instant.t), theme.ink,
                           draw::Font::small, draw::Align::left, {8.0, 10.0});
            }
            canvas.ground({0.0, 0.0}, std::numbers::pi);
            canvas.pin({0.0, 0.0});
          }};
}

/// Two double pendulums, released almost alike.
Picture chaos_picture(const Scene& given) {
  Scene scene = given;
  scene.links = 2;
  scene.angle0 = -0.9;
  Scene other = scene;
  constexpr double turn = 1e-6;
  other.angle0 += turn;
  const double L = scene.length;
  const double duration = 24.0 * std::sqrt(L / std::max(scene.gravity, 1e-12));
  constexpr int pieces = 2000;
  const double step = duration / (10 * pieces);
  const mechanics::Method method{integrators::Scheme::rk4, Stabilization::projection};
  Motion first = motion(scene, method), second = motion(other, method);
  std::vector<draw::Point> together, trail_first, trail_second, apart;
  double parted = duration;  // when they are a tenth of their length apart
  for (int i = 0; i <= pieces; ++i) {
    advance_to(first, duration * i / pieces, step);
    advance_to(second, duration * i / pieces, step);
    const Vector2d a = end_of_rod(scene, first.q(), 1), b = end_of_rod(scene, second.q(), 1);
    const double distance = (a - b).norm();
    apart.push_back({first.time(), distance});
    if (distance > 0.1 * L) parted = std::min(parted, first.time());
    if (trail_first.empty()) together.push_back(point(a));
    if (distance > 0.01 * L || !trail_first.empty()) {
      trail_first.push_back(point(a));
      trail_second.push_back(point(b));
    }
  }
  const Instant end_first = now(scene, first), end_second = now(scene, second);
  const draw::View view{-1.1 * L, -1.1 * L, 1.1 * L, 1.1 * L};
  const std::string caption = fmt::format(
      "Released {} rad apart, they are {} m apart after {:.1f} s: about ten times further every "
      "{:.1f} s. "
      "Grey: the way of the free ends while they are less than {} m apart.",
      pictures::figure(turn, 1), pictures::figure(0.1 * L, 1), parted,
      parted / std::log10(0.1 / turn), pictures::figure(0.01 * L, 1));
  return {"chaos", [=](draw::Pen& pen) {
            const draw::Rect content =
                draw::page(pen, "Two double pendulums, released 10⁻⁶ rad apart", caption);
            const double gap = 20.0, width = 0.5 * (content.width - gap);
            draw::Plot plot;
            plot.x = {.label = "time [s]"};
            plot.y = {.label = "distance of the free ends [m]", .log = true};
            plot.curves = {{.points = apart, .color = pen.theme().ink}};
            {
              Canvas canvas(pen, {content.left, content.top, width, content.height}, view);
              canvas.axes("m");
              const auto& theme = canvas.theme();
              canvas.curve(together, theme.muted.faded(0.5), 1.2);
              canvas.curve(trail_first, theme.series[0], 1.6);
              canvas.curve(trail_second, theme.series[1], 1.6);
              for (const auto& [instant, color] :
                   {std::pair{end_first, theme.series[0]}, std::pair{end_second, theme.series[1]}})
                for (const auto& [near, far] : instant.rods)
                  canvas.link(point(near), point(far), 8.0, color, theme.ink);
              canvas.pin({0.0, 0.0});
            }
            draw::draw_plot(pen, {content.left + width + gap, content.top, width, content.height},
                            plot);
          }};
}

pictures::Drift drift(const std::string& label, Motion rods, double duration, double step) {
  return pictures::drift(label, rods, duration, step);
}

Picture drift_picture(const Scene& scene, const RunOptions& run) {
  std::vector<pictures::Drift> drifts;
  for (const auto& scheme : integrators::schemes)
    drifts.push_back(drift(std::string(scheme.text), motion(scene, {.integrator = scheme.id}),
                           run.duration, run.step));
  const std::string caption = fmt::format(
      "No stabilization, step {:g} s, {:g} s: with explicit Euler the pin opens by {} m, with RK4 "
      "by {} m, with dop853 by {} m.",
      run.step, run.duration, pictures::figure(drifts.front().largest_constraint_error),
      pictures::figure(pictures::find(drifts, "rk4").largest_constraint_error),
      pictures::figure(pictures::find(drifts, "dop853").largest_constraint_error));
  return pictures::drift_picture("drift", "A rod on a pin: how five methods open it", caption,
                                 drifts, "m");
}

Picture stabilization_picture(const Scene& scene, const RunOptions& run) {
  // Coarse enough and long enough that RK4 has something to correct.
  const double step = 4.0 * run.step, duration = 6.0 * run.duration;
  std::vector<pictures::Drift> drifts;
  for (const mechanics::Method& method :
       {mechanics::Method{},
        mechanics::Method{integrators::Scheme::rk4, Stabilization::feedback, 100.0, 20.0},
        mechanics::Method{integrators::Scheme::rk4, Stabilization::projection}})
    drifts.push_back(drift(method.label(), motion(scene, method), duration, step));
  const std::string caption = fmt::format(
      "RK4 with a coarse step of {:g} s: the pin opens by {} m alone, by {} m with feedback (ks = "
      "100, kd = 20), by {} m with projection.",
      step, pictures::figure(drifts[0].largest_constraint_error),
      pictures::figure(drifts[1].largest_constraint_error),
      pictures::figure(drifts[2].largest_constraint_error));
  return pictures::drift_picture("stabilization", "A rod on a pin: three ways with the drift",
                                 caption, drifts, "m");
}

class ChainStage final : public pictures::MechanismStage<> {
 public:
  ChainStage(const Scene& scene, const RunOptions& run)
      : MechanismStage(run, make_mechanism(scene, run.method)), scene_(scene) {
    const double reach = 1.1 * scene.length;
    begin({-reach, -reach, reach, reach});
  }

  std::string title() const override { return "Rods on pins"; }
  std::string caption() override {
    return fmt::format("t = {:.3f} s: pin force {} N, |C| = {} m ({}, step {:g} s).", time(),
                       pictures::rounded(now(scene_, motion).pin_force.norm()),
                       pictures::figure(motion.measures().constraint_error), run().method.label(),
                       run().step);
  }

 private:
  void draw_things(Canvas& canvas, const pictures::Show& show) override {
    const Instant instant = now(scene_, motion);
    if (show.trail) canvas.curve(trail(0), canvas.theme().velocity, 1.6, draw::Dash::dotted);
    draw_chain(canvas, instant, 9.0, 1.0);
    if (show.forces) {
      const double scale = force_scale(scene_, largest_force(), 0.4);
      canvas.arrow({0.0, 0.0}, point(scale * instant.pin_force), canvas.theme().constraint_force,
                   show.numbers
                       ? fmt::format("pin force {} N", pictures::rounded(instant.pin_force.norm()))
                       : "");
      canvas.force_scale(scale);
    }
    canvas.pin({0.0, 0.0});
  }

  std::vector<draw::Point> marks() const override {
    return {point(end_of_rod(scene_, motion.q(), scene_.links - 1))};
  }
  double force() override { return now(scene_, motion).pin_force.norm(); }
  draw::Point half_size(const dynamics::ThingInfo&) const override { return {scene_.l() / 2, 0.0}; }

  Scene scene_;
};

Picture turned_off_picture(Scene scene, const RunOptions& run) {
  const RunOptions part{.duration = 0.1 * run.duration, .step = run.step};
  std::array<std::unique_ptr<pictures::Stage>, 2> stages;
  std::array<double, 2> off;
  for (const std::size_t with : {0U, 1U}) {
    scene.without_jdotv = with == 0;
    stages[with] = std::make_unique<ChainStage>(scene, part);
    off[with] = drift("", motion(scene), part.duration, part.step).largest_constraint_error;
  }
  const std::string caption = fmt::format(
      "Both after {:g} s: without −ω² A u the rod leaves its pin by {} m, with it by {} m (rk4, "
      "step {:g} s).",
      part.duration, pictures::figure(off[0]), pictures::figure(off[1]), part.step);
  return pictures::beside("turned_off", "A rod on a pin: the term that bends its path",
                          std::move(stages[0]), "without −ω² A u", std::move(stages[1]),
                          "with −ω² A u", part.duration, caption);
}

}  // namespace

std::vector<Picture> pictures(const Scene& scene, const RunOptions& run) {
  return {scene_picture(scene),
          frames_picture(),
          motion_picture(scene, run),
          chain_picture(scene, run),
          chaos_picture(scene),
          drift_picture(scene, run),
          stabilization_picture(scene, run),
          turned_off_picture(scene, run)};
}

Picture cost_picture(const CostTable& costs) {
  draw::Curve blocks{.label = "in blocks", .markers = true};
  draw::Curve full{.label = "in full matrices", .markers = true};
  for (const Cost& cost : costs.rows) {
    const auto links = static_cast<double>(cost.links);
    blocks.points.push_back({links, 1e6 * cost.blocks});
    if (!std::isnan(cost.full)) full.points.push_back({links, 1e6 * cost.full});
  }
  const draw::Point end = blocks.points.back();
  const draw::Curve linear{.label = "∝ N",
                           .points = {{1.0, 0.5 * end.y / end.x}, {end.x, 0.5 * end.y}},
                           .dash = draw::Dash::dashed,
                           .thickness = 1.2};
  draw::Plot plot;
  plot.x = {.label = "links N", .log = true};
  plot.y = {.label = "processor time of an RK4 step [µs]", .log = true};
  plot.curves = {blocks, full, linear};
  std::string caption = fmt::format(
      "In blocks a step of {:.0f} links costs {} µs, and from 10 to 1000 it grows as "
      "N to the power {:.2f}",
      end.x, pictures::figure(end.y), growth(costs, 10, 1000, &Cost::blocks));
  caption += full.points.empty()
                 ? "."
                 : fmt::format("; in full matrices {:.0f} links cost {} µs.", full.points.back().x,
                               pictures::figure(full.points.back().y));
  return {"cost_vs_links", [=](draw::Pen& pen) {
            draw::draw_plot(pen, draw::page(pen, "What a longer chain costs", caption), plot);
          }};
}

std::unique_ptr<pictures::Stage> stage(const Scene& scene, const RunOptions& run) {
  return std::make_unique<ChainStage>(scene, run);
}

}  // namespace revolute
