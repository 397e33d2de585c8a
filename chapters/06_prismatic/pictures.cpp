#include <algorithm>
#include <array>
#include <cmath>

#include "exact.hpp"
#include "instruments/pictures/lesson.hpp"
#include "instruments/pictures/mechanism_stage.hpp"
#include "mechanism.hpp"
#include "study.hpp"

namespace prismatic {
namespace {

using namespace pictures::lesson;

using Motion = mechanics::Motion<mechanics::Mechanism>;

Motion motion(const Scene& scene, const mechanics::Method& method = {}) {
  return {make_mechanism(scene, method), method};
}

Scene spinning(Scene scene) {
  if (!scene.spins()) scene.spin = 5.0;
  scene.stiffness = scene.damping = scene.s0 = scene.v0 = 0.0;
  return scene;
}

/// Rail and block at one time, each in its own place, and the force of the rail on the block.
struct Instant {
  double t;
  Vector2d rail;
  double rail_angle;
  Vector2d x;
  double theta;
  Vector2d force;
};

Instant now(const Scene& scene, Motion& motion) {
  const mechanics::Row row = motion.row();
  const Eigen::VectorXd& q = motion.q();
  Instant instant{.t = row.t,
                  .rail = {0.0, 0.0},
                  .rail_angle = scene.angle(),
                  .x = q.tail<3>().head<2>(),
                  .theta = q[q.size() - 1],
                  .force = {row.reactions[0], row.reactions[1]}};
  if (scene.spins()) instant.rail = q.head<2>(), instant.rail_angle = q[2];
  return instant;
}

/// Moves on to the step nearest to t.
void advance_to(Motion& motion, double t, double step) {
  const long steps = std::lround((t - motion.time()) / step);
  if (steps > 0) motion.advance(steps, step);
}

/// The block, and the gaps where it is off the rail and the rail off its pin.
void draw_block(Canvas& canvas, const Scene& scene, const Instant& instant, double presence) {
  const auto& theme = canvas.theme();
  canvas.box(point(instant.x), scene.width, scene.height, instant.theta, theme.body.faded(presence),
             theme.body_edge.faded(presence));
  const Vector2d u = along(instant.rail_angle);
  const Vector2d foot = instant.rail + u.dot(instant.x - instant.rail) * u;
  canvas.gap(point(foot), point(instant.x));
  canvas.gap({0.0, 0.0}, point(instant.rail));
}

/// The rail, so long that it leaves the view on both sides.
void draw_rail(Canvas& canvas, const Instant& instant, double half, double presence,
               double thickness) {
  const Vector2d u = half * along(instant.rail_angle);
  const std::vector<draw::Point> ends{point(instant.rail - u), point(instant.rail + u)};
  canvas.curve(ends, canvas.theme().track.faded(presence), thickness);
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

double size_of(const draw::View& view) {
  return std::max(view.right - view.left, view.bottom - view.top);
}

/// Metres for a newton, so that the largest of some forces is drawn so many metres long.
double force_scale(double largest, double metres) { return largest > 0.0 ? metres / largest : 0.0; }

/// On the fixed rail, from rest, with nothing but its weight.
Scene sliding(Scene scene) {
  scene.spin = scene.stiffness = scene.damping = scene.s0 = scene.v0 = 0.0;
  return scene;
}

Picture scene_picture(const Scene& given) {
  const Scene scene = sliding(given);
  Motion start = motion(scene);
  const Instant instant = now(scene, start);
  const Vector2d weight(0.0, scene.mass * scene.gravity), sum = weight + instant.force;
  const double scale = force_scale(weight.norm(), 0.3);
  const draw::View view{-0.62, -0.37, 0.62, 0.42};
  const std::string caption = fmt::format(
      "On {:g}° the rail carries {} N of the weight of {} N, m g cos {:g}°; {} N are "
      "left to move the block.",
      scene.incline, pictures::rounded(instant.force.norm()), pictures::rounded(weight.norm()),
      scene.incline, pictures::rounded(sum.norm()));
  return {
      "scene", [=](draw::Pen& pen) {
        Canvas canvas(pen, draw::page(pen, "A block on an inclined rail", caption), view);
        canvas.axes("m");
        const auto& theme = canvas.theme();
        const double beta = scene.angle();
        draw_rail(canvas, instant, 4.0, 1.0, 3.0);
        const std::vector<draw::Point> level{{-0.5, -0.5 * std::tan(beta)},
                                             {-0.3, -0.5 * std::tan(beta)}};
        std::vector<draw::Point> arc;
        for (int i = 0; i <= 40; ++i)
          arc.push_back(point(-0.5 / std::cos(beta) * along(beta) + 0.12 * along(beta * i / 40)));
        if (std::abs(scene.incline) < 60.0) {
          canvas.curve(level, theme.muted, 1.2, draw::Dash::dashed);
          canvas.curve(arc, theme.muted, 1.4);
          canvas.label(arc[20], fmt::format("{:g}°", scene.incline), theme.muted, draw::Font::text,
                       draw::Align::left, {10.0, 0.0});
        }
        draw_block(canvas, scene, instant, 1.0);
        canvas.arrow({0.0, 0.0}, point(scale * weight), theme.weight,
                     fmt::format("weight {} N", pictures::rounded(weight.norm())));
        canvas.arrow({0.0, 0.0}, point(scale * instant.force), theme.constraint_force,
                     fmt::format("reaction {} N", pictures::rounded(instant.force.norm())));
        canvas.arrow({0.0, 0.0}, point(scale * sum), theme.muted);
        const double aside = beta < 0.0 ? 1.0 : -1.0;  // where the rail leaves room for text
        canvas.label(point(scale * sum), fmt::format("sum {} N", pictures::rounded(sum.norm())),
                     theme.muted, draw::Font::text, draw::Align::left, {12.0, 10.0 * aside});
        canvas.bead({0.0, 0.0}, 3.0, theme.ink, theme.ink);
        canvas.force_scale(scale);
        canvas.label(point(0.45 * along(beta)), "rail: n·d = 0,  θ = θ₂₁", theme.track,
                     draw::Font::bold, draw::Align::left, {14.0, 10.0 * aside});
      }};
}

/// The letters of the derivation: two bodies a little off the rail that joins them.
Picture symbols_picture() {
  return {"symbols", [](draw::Pen& pen) {
            const draw::View view{-0.1, -0.1, 2.1, 1.25};
            Canvas canvas(pen,
                          draw::page(pen, "A rail on body 1, and body 2 that should be on it",
                                     "d leads from the rail's point r₁ to the point r₂ of body 2. "
                                     "Its part along the normal n is the error n·d."),
                          view);
            const auto& theme = canvas.theme();
            const double theta = 0.25;
            const Vector2d along1 = along(theta), n = across(theta);
            const Vector2d x1(0.55, 0.75), r1 = x1 + 0.3 * along1 - 0.2 * n;
            const Vector2d r2 = r1 + 0.62 * along1 - 0.16 * n, x2 = r2 + Vector2d(0.12, -0.16);
            canvas.origin({0.0, 0.0});
            canvas.box(point(x1), 0.9, 0.46, theta, theme.body.faded(0.5), theme.body_edge);
            const std::array rail{point(r1 - 0.9 * along1), point(r1 + 1.2 * along1)};
            canvas.curve(rail, theme.track, 3.0);
            canvas.label(rail[1], "rail of body 1", theme.track, draw::Font::text,
                         draw::Align::right, {-6.0, 16.0});
            canvas.box(point(x2), 0.5, 0.6, theta - 0.2, theme.body.faded(0.5), theme.body_edge);
            const auto arrow = [&](const Vector2d& from, const Vector2d& to, draw::Color color,
                                   const std::string& name) {
              canvas.arrow(point(from), point(to - from), color, name);
            };
            arrow({0.0, 0.0}, x1, theme.ink, "x₁");
            arrow({0.0, 0.0}, x2, theme.ink, "x₂");
            arrow(x1, r1, theme.constraint_force, "A₁u₁");
            arrow(x2, r2, theme.constraint_force, "A₂u₂");
            arrow(r1, r1 + 0.34 * n, theme.velocity, "n");
            arrow(r1, r2, theme.applied_force, "");
            canvas.label(point(0.5 * (r1 + r2)), "d", theme.applied_force, draw::Font::bold,
                         draw::Align::center, {0.0, -14.0});
            const std::array off{point(r2), point(r2 + 0.16 * n)};
            canvas.curve(off, theme.warning, 2.0, draw::Dash::dashed);
            canvas.label(off[1], "n·d", theme.warning, draw::Font::bold, draw::Align::left,
                         {10.0, -10.0});
            for (const auto& [at, name] : {std::pair{r1, "r₁"}, std::pair{r2, "r₂"}}) {
              canvas.pin(point(at));
              canvas.label(point(at), name, theme.ink, draw::Font::bold, draw::Align::right,
                           {-9.0, -10.0});
            }
          }};
}

/// The block at equal intervals of time on its way down the incline.
Picture motion_picture(const Scene& given, const RunOptions& run) {
  const Scene scene = sliding(given);
  constexpr int count = 6;
  const double pull = scene.gravity * std::abs(std::sin(scene.angle()));
  const double wanted = std::min(std::sqrt(2.0 * 2.0 / std::max(pull, 1e-12)), run.duration);
  const double interval = run.step * std::max(1.0, std::round(wanted / (count - 1) / run.step));
  Motion block = motion(scene, run.method);
  std::vector<Instant> instants;
  for (int i = 0; i < count; ++i) {
    advance_to(block, i * interval, run.step);
    instants.push_back(now(scene, block));
  }
  const double largest = scene.mass * scene.gravity, length = instants.back().x.norm();
  const double scale = force_scale(largest, 0.4);
  std::vector<draw::Point> seen{{-0.4, -0.3}, {0.4, 0.3}};
  for (const Instant& instant : instants) {
    seen.push_back(point(instant.x));
    seen.push_back(point(instant.x + scale * instant.force));
  }
  const draw::View view = view_of(seen, 0.06);
  const std::string caption = fmt::format(
      "After {:.2f} s the block has come {:.4f} m; ½ g sin {:g}° t² is {:.4f} m ({}, step {:g} s). "
      "The reaction stays {} N.",
      instants.back().t, length, scene.incline, 0.5 * pull * instants.back().t * instants.back().t,
      run.method.label(), run.step, pictures::rounded(instants.back().force.norm()));
  return {
      "motion", [=](draw::Pen& pen) {
        Canvas canvas(
            pen,
            draw::page(
                pen, fmt::format("A block on a rail: {} instants, {:.2f} s apart", count, interval),
                caption),
            view);
        canvas.axes("m");
        const auto& theme = canvas.theme();
        draw_rail(canvas, instants.front(), 3.0 * size_of(view), 1.0, 2.4);
        for (std::size_t i = 0; i < instants.size(); ++i) {
          const Instant& instant = instants[i];
          draw_block(canvas, scene, instant, 0.35 + 0.65 * static_cast<double>(i) / (count - 1));
          canvas.arrow(point(instant.x), point(scale * instant.force), theme.constraint_force);
          canvas.label(point(instant.x), fmt::format("{:.2f} s", instant.t), theme.muted,
                       draw::Font::small, draw::Align::right,
                       i == 0 ? draw::Point{-36.0, 10.0} : draw::Point{-6.0, 30.0});
        }
        canvas.force_scale(scale);
        canvas.label({0.5 * (view.left + view.right), view.top}, "arrows: reaction of the rail",
                     theme.constraint_force, draw::Font::bold, draw::Align::center, {0.0, 16.0});
      }};
}

/// The turning rail and the block that flies out along it.
Picture spin_picture(const Scene& given, const RunOptions& run) {
  const Scene scene = spinning(given);
  constexpr int count = 9, between = 20;
  const double interval = 0.09 * 5.0 / std::abs(scene.spin);
  const double step =
      interval / (between * std::clamp(std::ceil(interval / between / run.step), 1.0, 50.0));
  Motion spin = motion(scene, run.method);
  const double before = angular_momentum(scene, spin.q(), spin.v());
  std::vector<Instant> instants{now(scene, spin)};
  std::vector<draw::Point> trail{point(instants[0].x)};
  for (int i = 1; i < count; ++i) {
    for (int k = 1; k <= between; ++k) {
      advance_to(spin, (i - 1 + k / double(between)) * interval, step);
      trail.push_back(point(now(scene, spin).x));
    }
    instants.push_back(now(scene, spin));
  }
  const double error = std::abs(angular_momentum(scene, spin.q(), spin.v()) - before);
  const double reach = instants.back().x.norm();
  double largest = 0.0;
  for (const Instant& instant : instants) largest = std::max(largest, instant.force.norm());
  const double scale = force_scale(largest, 0.3 * reach);
  std::vector<draw::Point> seen;
  for (const Instant& instant : instants) {
    const Vector2d corner = scene.width * instant.x.normalized();
    seen.push_back(point(instant.x + corner));
    seen.push_back(point(instant.x + scale * instant.force));
  }
  const draw::View view = view_of(seen, 0.1);
  const std::string caption = fmt::format(
      "In {:.2f} s the block comes from {:g} m to {:.2f} m and the rail slows from {:.1f} to "
      "{:.2f} "
      "rad/s. Angular momentum {:.4g} kg·m²/s, kept to {} ({}, step {} s).",
      spin.time(), scene.r0, reach, scene.spin, spin.v()[2], before, pictures::figure(error),
      run.method.label(), pictures::figure(step));
  return {
      "spin", [=](draw::Pen& pen) {
        Canvas canvas(
            pen, draw::page(pen, "A rail that turns freely, and the block on it", caption), view);
        canvas.axes("m");
        const auto& theme = canvas.theme();
        for (std::size_t i = 0; i < instants.size(); ++i)
          draw_rail(canvas, instants[i], 2.0 * size_of(view),
                    0.15 + 0.75 * static_cast<double>(i) / (count - 1), 1.6);
        canvas.curve(trail, theme.velocity, 1.8, draw::Dash::dotted);
        for (std::size_t i = 0; i < instants.size(); ++i) {
          const Instant& instant = instants[i];
          draw_block(canvas, scene, instant, 0.35 + 0.65 * static_cast<double>(i) / (count - 1));
          canvas.arrow(point(instant.x), point(scale * instant.force), theme.constraint_force);
          if (i > 0)
            canvas.label(point(instant.x), fmt::format("{:.2f} s", instant.t), theme.muted,
                         draw::Font::small, draw::Align::left, {14.0, 10.0});
        }
        canvas.pin({0.0, 0.0});
        canvas.force_scale(scale);
        canvas.label({view.left, view.top}, "arrows: force of the rail on the block",
                     theme.constraint_force, draw::Font::bold, draw::Align::left, {10.0, 50.0});
      }};
}

Picture drift_picture(const Scene& given, const RunOptions& run) {
  const Scene scene = spinning(given);
  std::vector<pictures::Drift> drifts;
  for (const auto& scheme : integrators::schemes) {
    Motion spin = motion(scene, {.integrator = scheme.id});
    drifts.push_back(pictures::drift(std::string(scheme.text), spin, run.duration, run.step));
  }
  const std::string caption = fmt::format(
      "Spinning rail, no stabilization, step {:g} s, {:g} s: explicit Euler takes the block {} m "
      "off its rail, RK4 {} m, dop853 {} m.",
      run.step, run.duration, pictures::figure(drifts.front().largest_constraint_error),
      pictures::figure(pictures::find(drifts, "rk4").largest_constraint_error),
      pictures::figure(pictures::find(drifts, "dop853").largest_constraint_error));
  return pictures::drift_picture("drift", "A block on a turning rail: how five methods leave it",
                                 caption, drifts, "m or rad");
}

double at_the_end(const pictures::Drift& drift) {
  return drift.constraint_error.empty() ? 0.0 : drift.constraint_error.back().y;
}

Picture stabilization_picture(const Scene& given, const RunOptions& run) {
  const Scene scene = spinning(given);
  // Coarse enough that RK4 has something to correct, long enough to see what becomes of it.
  const double step = 15.0 * run.step, duration = 10.0 * run.duration;
  std::vector<pictures::Drift> drifts;
  for (const mechanics::Method& method :
       {mechanics::Method{},
        mechanics::Method{integrators::Scheme::rk4, Stabilization::feedback, 100.0, 20.0},
        mechanics::Method{integrators::Scheme::rk4, Stabilization::projection}}) {
    Motion spin = motion(scene, method);
    drifts.push_back(pictures::drift(method.label(), spin, duration, step));
  }
  const std::string caption = fmt::format(
      "RK4 with a coarse step of {:g} s: after {:g} s the block is off by {} m alone, by {} m with "
      "feedback (ks = 100, kd = 20), by {} m with projection.",
      step, duration, pictures::figure(at_the_end(drifts[0])),
      pictures::figure(at_the_end(drifts[1])), pictures::figure(at_the_end(drifts[2])));
  return pictures::drift_picture("stabilization",
                                 "A block on a turning rail: three ways with the drift", caption,
                                 drifts, "m or rad");
}

/// How far from (0, 0) the block can be on the rail that turns after some time.
double reach(const Scene& scene, double t) { return scene.r0 * std::hypot(1.0, scene.spin * t); }

/// Between which places [m] along the fixed rail the block is up to some time.
std::pair<double, double> range(const Scene& scene, double t) {
  constexpr int looks = 400;
  double least = scene.s0, most = scene.s0;
  for (int i = 1; i <= looks; ++i) {
    const double s = exact(scene, t * i / looks).x.dot(along(scene.angle()));
    least = std::min(least, s), most = std::max(most, s);
  }
  return {least, most};
}

/// The spring as a zigzag from (0, 0) to the block.
void draw_coil(Canvas& canvas, Vector2d block, double width) {
  constexpr int turns = 24;
  const Vector2d side = width * Vector2d(-block.y(), block.x()).normalized();
  std::vector<draw::Point> points;
  for (int i = 0; i <= turns; ++i) {
    const double off = i == 0 || i == turns ? 0.0 : i % 2 == 0 ? 1.0 : -1.0;
    points.push_back(point(double(i) / turns * block + off * side));
  }
  canvas.curve(points, canvas.theme().applied_force, 1.4);
  canvas.bead({0.0, 0.0}, 3.0, canvas.theme().applied_force, canvas.theme().applied_force);
}

class BlockStage final : public pictures::MechanismStage<> {
 public:
  BlockStage(const Scene& scene, const RunOptions& run)
      : MechanismStage(run, make_mechanism(scene, run.method)), scene_(scene) {
    std::vector<draw::Point> seen{{-0.5, -0.5}, {0.5, 0.5}};
    if (scene.spins()) {
      const double far = reach(scene, run.duration);
      seen.push_back({-far, -far});
      seen.push_back({far, far});
    } else {  // from the start to the end, with room for the reaction
      const auto [least, most] = range(scene, run.duration);
      const double far = most - least;
      for (const double s : {least, most}) {
        const Vector2d x = s * along(scene.angle());
        seen.push_back(point(x));
        seen.push_back(point(x - 0.2 * far * across(scene.angle())));
      }
    }
    begin(view_of(seen, 0.12));
  }

  std::string title() const override { return "A block on a rail"; }
  std::string caption() override {
    const Instant instant = now(scene_, motion);
    const Eigen::Index block = motion.v().size() - 3;
    return fmt::format(
        "t = {:.3f} s: block at ({}, {}) m, {} m/s{}, |C| = {} m or rad ({}, step {:g} "
        "s).",
        time(), pictures::rounded(instant.x.x(), 3), pictures::rounded(instant.x.y(), 3),
        pictures::rounded(motion.v().segment<2>(block).norm(), 3),
        scene_.spins() ? fmt::format(", rail at {} rad/s", pictures::rounded(motion.v()[2], 3))
                       : "",
        pictures::figure(motion.measures().constraint_error), run().method.label(), run().step);
  }

 private:
  void draw_things(Canvas& canvas, const pictures::Show& show) override {
    const Instant instant = now(scene_, motion);
    draw_rail(canvas, instant, 3.0 * size_of(view()), 1.0, 2.4);
    if (show.trail) canvas.curve(trail(0), canvas.theme().velocity, 1.6, draw::Dash::dotted);
    if (scene_.stiffness > 0.0) draw_coil(canvas, instant.x, 0.25 * scene_.height);
    draw_block(canvas, scene_, instant, 1.0);
    if (scene_.width * canvas.points_per_metre() < 10.0)  // else it could not be seen from afar
      canvas.bead(point(instant.x), 4.0, canvas.theme().body, canvas.theme().body_edge);
    if (show.forces) {
      const double scale = force_scale(largest_force(), 0.2 * size_of(view()));
      canvas.arrow(point(instant.x), point(scale * instant.force), canvas.theme().constraint_force,
                   show.numbers
                       ? fmt::format("reaction {} N", pictures::rounded(instant.force.norm()))
                       : "");
      canvas.force_scale(scale);
    }
    if (scene_.spins()) canvas.pin({0.0, 0.0});
  }

  std::vector<draw::Point> marks() const override {
    const Eigen::Index block = motion.q().size() - 3;
    return {{motion.q()[block], motion.q()[block + 1]}};
  }
  double force() override { return now(scene_, motion).force.norm(); }
  draw::Point half_size(const dynamics::ThingInfo& thing) const override {
    if (thing.name == "rail") return {0.5, 0.0};
    return {0.5 * scene_.width, 0.5 * scene_.height};
  }

  Scene scene_;
};

Picture turned_off_picture(const Scene& given, const RunOptions& run) {
  Scene scene = spinning(given);
  const RunOptions part{.duration = 0.2 * run.duration, .step = run.step};
  std::array<std::unique_ptr<pictures::Stage>, 2> stages;
  std::array<double, 2> off;
  for (const std::size_t with : {0U, 1U}) {
    scene.without_coriolis = with == 0;
    stages[with] = std::make_unique<BlockStage>(scene, part);
    Motion spin = motion(scene);
    off[with] = pictures::drift("", spin, part.duration, part.step).largest_constraint_error;
  }
  const std::string caption = fmt::format(
      "Both after {:g} s: the block leaves the rail by {} m without the Coriolis term, by {} m "
      "with "
      "it (rk4, step {:g} s).",
      part.duration, pictures::figure(off[0]), pictures::figure(off[1]), part.step);
  return pictures::beside("turned_off", "A block on a turning rail: the Coriolis term",
                          std::move(stages[0]), "without 2 ω₁ (S n)·(dd/dt)", std::move(stages[1]),
                          "with 2 ω₁ (S n)·(dd/dt)", part.duration, caption);
}

}  // namespace

std::vector<Picture> pictures(const Scene& scene, const RunOptions& run) {
  return {scene_picture(scene),          symbols_picture(),
          motion_picture(scene, run),    spin_picture(scene, run),
          drift_picture(scene, run),     stabilization_picture(scene, run),
          turned_off_picture(scene, run)};
}

std::unique_ptr<pictures::Stage> stage(const Scene& scene, const RunOptions& run) {
  return std::make_unique<BlockStage>(scene, run);
}

}  // namespace prismatic
