#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "drawing.hpp"
#include "instruments/pictures/mechanism_stage.hpp"
#include "mechanism.hpp"
#include "study.hpp"

namespace slider_crank {
namespace {

using namespace pictures::lesson;
using Motion = mechanics::Motion<mechanics::Mechanism>;
constexpr double turn = 2.0 * std::numbers::pi;

Motion motion(const Scene& scene, const mechanics::Method& method) {
  return {make_mechanism(scene, method), method};
}

}  // namespace

Instant now(const Scene& scene, Motion& motion, const Bodies& bodies) {
  const mechanics::Row row = motion.row();
  const auto pose = [&](const auto& body) {
    return Pose{motion.q().segment<2>(body.column), motion.q()[body.column + 2]};
  };
  const Pose wheel = pose(bodies.wheel), rod = pose(bodies.rod);
  const auto force = [&](std::size_t i) {
    return Vector2d(row.reactions[3 * i], row.reactions[3 * i + 1]);
  };
  // Reported in this order: frame_ground, wheel_frame, rod_wheel, slider_rod, slider_frame.
  return {row.t,
          bodies.frame ? pose(*bodies.frame) : Pose{},
          wheel,
          rod,
          pose(bodies.slider),
          wheel.at({scene.crank, 0.0}),
          rod.at({-0.5 * scene.rod, 0.0}),
          rod.at({0.5 * scene.rod, 0.0}),
          {force(1), force(2), force(3), force(4)}};
}

namespace {

/// One revolution, or the run where it ends before: an instant each step.
std::vector<Instant> revolution(const Scene& scene, const RunOptions& run) {
  Bodies bodies;
  mechanics::Mechanism mechanism = make_mechanism(scene, run.method, &bodies);
  Motion crank(std::move(mechanism), run.method);
  std::vector<Instant> instants{now(scene, crank, bodies)};
  const long steps = run.whole_steps(), stride = std::max(1L, steps / 20000);
  for (long done = 0; done < steps && std::abs(instants.back().wheel.angle - scene.theta0) < turn;
       done += stride) {
    crank.advance(stride, run.step);
    instants.push_back(now(scene, crank, bodies));
  }
  return instants;
}

}  // namespace

draw::View view(const Scene& scene) {
  const double wheel = std::max(scene.wheel_radius, 1.05 * scene.crank);
  return {-1.2 * wheel, -1.35 * wheel, scene.crank + scene.rod + 0.6 * scene.slider_width,
          1.35 * wheel};
}

void draw_frame(Canvas& canvas, const Scene& scene, const Pose& frame) {
  const double from = scene.rod - scene.crank - 0.5 * scene.slider_width - 0.05;
  const double to = scene.rod + scene.crank + 0.5 * scene.slider_width + 0.05;
  const double floor = 0.5 * scene.slider_height;
  const std::vector<Point> rail{point(frame.at({from, floor})), point(frame.at({to, floor}))};
  canvas.ground(point(frame.at({0.5 * (from + to), floor})), frame.angle,
                (to - from) * canvas.points_per_metre());
  canvas.curve(rail, canvas.theme().track, 2.4);
  const std::vector<Point> line{point(frame.x), point(frame.at({to, 0.0}))};
  canvas.curve(line, canvas.theme().muted, 1.0, draw::Dash::dotted);
}

void draw_bodies(Canvas& canvas, const Scene& scene, const Instant& at, double presence,
                 bool muted) {
  const auto& theme = canvas.theme();
  const draw::Color edge = theme.body_edge.faded(presence);
  const draw::Color crank = muted ? theme.grid : theme.series[1].faded(presence);
  const draw::Color rod = muted ? theme.grid : theme.series[0].faded(presence);
  canvas.box(point(at.slider.x), scene.slider_width, scene.slider_height, at.slider.angle,
             muted ? draw::transparent : theme.body.faded(presence < 1.0 ? 0.0 : 0.6), edge);
  canvas.link(point(at.wheel.x), point(at.crank_pin), 9.0, crank, edge);
  canvas.link(point(at.rod_start), point(at.rod_end), 9.0, rod, edge);
}

namespace {

void draw_gaps(Canvas& canvas, const Instant& at) {
  const Vector2d along = at.frame.at({1.0, 0.0}) - at.frame.x;
  const Vector2d foot = at.frame.x + along.dot(at.slider.x - at.frame.x) * along;  // on the rail
  canvas.gap({0.0, 0.0}, point(at.frame.x));
  canvas.gap(point(at.frame.x), point(at.wheel.x));
  canvas.gap(point(at.crank_pin), point(at.rod_start));
  canvas.gap(point(at.rod_end), point(at.slider.x));
  canvas.gap(point(foot), point(at.slider.x));
}

}  // namespace

void draw_mechanism(Canvas& canvas, const Scene& scene, const Instant& at, bool muted) {
  draw_frame(canvas, scene, at.frame);
  canvas.disc(point(at.wheel.x), scene.wheel_radius, canvas.theme().body.faded(0.35),
              canvas.theme().body_edge);
  draw_bodies(canvas, scene, at, 1.0, muted);
  canvas.ground(point(at.frame.x), at.frame.angle);
  for (const Vector2d& pin : {at.wheel.x, at.crank_pin, at.slider.x}) canvas.pin(point(pin));
  draw_gaps(canvas, at);
}

void draw_forces(Canvas& canvas, const Instant& at, double newtons, double metres, bool labelled) {
  const auto arrow = [&](const Vector2d& where, const Vector2d& force, std::size_t color,
                         const char* name) {
    canvas.arrow(point(where), point(metres / newtons * force), canvas.theme().series[color],
                 labelled ? fmt::format("{} {} N", name, pictures::rounded(force.norm(), 1)) : "");
  };
  arrow(at.wheel.x, at.forces.wheel_frame, 2, "wheel_frame");
  arrow(at.rod_start, at.forces.rod_wheel, 1, "rod_wheel");
  arrow(at.slider.x, at.forces.slider_rod, 0, "slider_rod");
  arrow(at.slider.x, at.forces.slider_frame, 3, "slider_frame");
  canvas.force_scale(metres / newtons);
}

double largest(const Forces& forces) {
  return std::max({forces.wheel_frame.norm(), forces.rod_wheel.norm(), forces.slider_rod.norm(),
                   forces.slider_frame.norm()});
}

namespace {

Picture scene_picture(const Scene& scene, const RunOptions& run) {
  const Instant start = revolution(scene, {.duration = run.step, .step = run.step}).front();
  Motion crank = motion(scene, {});
  Eigen::VectorXd a = crank.q();
  crank.model().acceleration(0.0, crank.q(), crank.v(), a);
  const dynamics::Counts counts = crank.model().evaluation().counts();
  const std::string caption = fmt::format(
      "{} rows on {} coordinates leave {} degree of freedom; with the frame as a body 11 rows on "
      "12.",
      counts.rows, counts.coordinates, counts.degrees_of_freedom);
  return {
      "scene", [=](draw::Pen& pen) {
        Canvas canvas(pen, draw::page(pen, "Slider-crank: four bodies, five joints", caption),
                      view(scene));
        canvas.axes("m");
        draw_mechanism(canvas, scene, start);
        const auto& theme = canvas.theme();
        const auto name = [&](const Vector2d& at, const char* text, Point offset, draw::Align align,
                              draw::Color color) {
          canvas.label(point(at), text, color, draw::Font::bold, align, offset);
        };
        name({-0.2, -0.2}, "wheel", {0, 0}, draw::Align::center, theme.ink);
        name(0.5 * (start.crank_pin + start.slider.x),
             fmt::format("rod, L = {:g} m", scene.rod).c_str(), {-6, -30}, draw::Align::right,
             theme.ink);
        name(0.5 * start.crank_pin, fmt::format("crank, R = {:g} m", scene.crank).c_str(), {-12, 8},
             draw::Align::right, theme.ink);
        canvas.turn(point(start.wheel.x), 62.0, 0.0, start.wheel.angle, theme.muted, "θ");
        // φ at the crank pin, from the level to the rod: negative here
        const std::vector<Point> level{point(start.crank_pin),
                                       point(start.crank_pin + Vector2d(0.3, 0.0))};
        canvas.curve(level, theme.muted, 1.0, draw::Dash::dotted);
        canvas.turn(point(start.crank_pin), 96.0, 0.0, start.rod.angle, theme.muted, "φ");
        name(start.slider.x, "slider",
             {0, -scene.slider_height * 0.5 * canvas.points_per_metre() - 14}, draw::Align::center,
             theme.ink);
        name({scene.rod + scene.crank + 0.5 * scene.slider_width, 0.5 * scene.slider_height},
             "frame", {0, -14}, draw::Align::center, theme.ink);
        name({0, 0}, "wheel_frame: revolute", {0, -20}, draw::Align::center,
             theme.constraint_force);
        name(start.crank_pin, "rod_wheel: revolute", {10, 22}, draw::Align::left,
             theme.constraint_force);
        name(start.slider.x, "slider_rod: revolute", {0, 64}, draw::Align::center,
             theme.constraint_force);
        name(start.slider.x, "slider_frame: prismatic", {0, 84}, draw::Align::center,
             theme.constraint_force);
        name({0, 0}, "frame_ground: ground", {-8, 26}, draw::Align::right, theme.constraint_force);
        if (scene.torque != 0.0) {  // a couple: an arc with a head
          std::vector<Point> arc;
          const double r = 1.12 * scene.wheel_radius, sign = scene.torque > 0.0 ? 1.0 : -1.0;
          for (int i = 0; i <= 40; ++i) {
            const double angle = -2.4 + sign * i / 40.0;
            arc.push_back({r * std::cos(angle), r * std::sin(angle)});
          }
          canvas.curve(arc, theme.applied_force, 2.4);
          const Point head = arc.back(), before = arc[arc.size() - 4];
          canvas.arrow(before, 1.6 * (head - before), theme.applied_force);
          canvas.label(arc.back(), fmt::format("torque {:g} N·m", scene.torque),
                       theme.applied_force, draw::Font::bold, draw::Align::left, {14, -6});
        }
      }};
}

Picture motion_picture(const Scene& scene, const RunOptions& run) {
  const std::vector<Instant> instants = revolution(scene, run);
  constexpr std::size_t exposures = 9;
  std::vector<Instant> shown;
  for (std::size_t i = 0; i < exposures; ++i)
    shown.push_back(instants[i * (instants.size() - 1) / (exposures - 1)]);
  const Instant& last = instants.back();
  const std::string caption = fmt::format(
      "{} exposures at equal times from t = 0 to {:.3f} s, in which the crank turns by {:.2f} rad.",
      exposures, last.t, last.wheel.angle - scene.theta0);
  return {
      "motion", [=](draw::Pen& pen) {
        Canvas canvas(pen, draw::page(pen, "Slider-crank: one revolution", caption), view(scene));
        canvas.axes("m");
        draw_frame(canvas, scene, last.frame);
        canvas.disc(point(last.wheel.x), scene.wheel_radius, canvas.theme().body.faded(0.25),
                    canvas.theme().body_edge);
        // After a whole turn the last exposure covers the first: one label serves both.
        const bool closed = std::abs(last.wheel.angle - scene.theta0) > 0.98 * turn;
        for (std::size_t i = 0; i < shown.size(); ++i) {
          const double presence = 0.2 + 0.6 * static_cast<double>(i) / exposures;
          draw_bodies(canvas, scene, shown[i], i + 1 == shown.size() ? 1.0 : presence, false);
          draw_gaps(canvas, shown[i]);
          if (closed && (i == 0 || i + 1 == shown.size())) continue;
          canvas.label(point(1.16 * shown[i].crank_pin), fmt::format("{:.2f} s", shown[i].t),
                       canvas.theme().muted, draw::Font::small, draw::Align::center);
        }
        if (closed)
          canvas.label(point(last.crank_pin), fmt::format("0.00 and {:.2f} s", last.t),
                       canvas.theme().muted, draw::Font::small, draw::Align::left, {30.0, 12.0});
        canvas.pin({0.0, 0.0});
      }};
}

Picture forces_picture(const Scene& scene, const RunOptions& run) {
  const std::vector<Instant> instants = revolution(scene, run);
  const Instant& worst = *std::max_element(
      instants.begin(), instants.end(),
      [](const Instant& a, const Instant& b) { return largest(a.forces) < largest(b.forces); });
  draw::Plot plot;
  plot.x.label = "crank angle θ [rad]";
  plot.y.label = "joint force [N]";
  const auto curve = [&](const char* name, auto member) {
    draw::Curve line{.label = name, .markers = true, .mark_every = instants.size() / 6};
    for (const Instant& at : instants)
      line.points.push_back({at.wheel.angle, (at.forces.*member).norm()});
    plot.curves.push_back(line);
  };
  curve("slider_rod", &Forces::slider_rod);
  curve("rod_wheel", &Forces::rod_wheel);
  curve("wheel_frame", &Forces::wheel_frame);
  curve("slider_frame", &Forces::slider_frame);
  const std::string caption = fmt::format(
      "Largest at θ = {:.2f} rad, t = {:.3f} s: the frame holds the wheel with {} N. Arrows: "
      "the force on the "
      "body that the joint's name starts with.",
      worst.wheel.angle, worst.t, pictures::rounded(worst.forces.wheel_frame.norm(), 1));
  return {
      "forces", [=](draw::Pen& pen) {
        draw::Plot colored = plot;
        for (std::size_t i = 0; i < 4; ++i) colored.curves[i].color = pen.theme().series[i];
        const draw::Rect content =
            draw::page(pen, "Slider-crank: joint forces over one revolution", caption);
        const double height = 0.44 * content.height;
        draw::draw_plot(pen, {content.left, content.top, content.width, height - 10.0}, colored);
        draw::View seen = view(scene);
        seen.top *= 0.85;
        seen.bottom *= 0.85;
        Canvas canvas(pen,
                      {content.left, content.top + height, content.width, content.height - height},
                      seen);
        draw_mechanism(canvas, scene, worst, true);
        draw_forces(canvas, worst, largest(worst.forces), 0.45);
      }};
}

Picture energy_picture(const Scene& scene, const RunOptions& run) {
  Bodies bodies;
  mechanics::Mechanism mechanism = make_mechanism(scene, run.method, &bodies);
  Motion crank(std::move(mechanism), run.method);
  const double start = crank.measures().energy;
  draw::Curve energy{.label = "E(t) − E(0)", .thickness = 4.5},
      work{.label = "τ (θ − θ0)", .dash = draw::Dash::dashed};
  draw::Curve error{.label = "", .thickness = 2.0};
  double worst = 0.0;
  const long steps = run.whole_steps(), stride = std::max(1L, steps / 400);
  for (long done = 0; done < steps; done += stride) {
    crank.advance(stride, run.step);
    const mechanics::Measures now = crank.measures();
    energy.points.push_back({crank.time(), now.energy - start});
    work.points.push_back({crank.time(), now.work});
    error.points.push_back({crank.time(), std::abs(now.energy - start - now.work)});
    worst = std::max(worst, error.points.back().y);
  }
  const std::string caption = fmt::format(
      "The torque does {:.2f} J of work in {:g} s; the energy differs from it by at most {} J ({}, "
      "step {:g} s).",
      work.points.back().y, run.duration, pictures::figure(worst), run.method.label(), run.step);
  return {"energy", [=](draw::Pen& pen) {
            const draw::Rect content =
                draw::page(pen, "Slider-crank: the energy is what the torque has put in", caption);
            draw::Plot left{
                .title = "energy and work", .x = {.label = "time [s]"}, .y = {.label = "[J]"}};
            left.curves = {energy, work};
            left.curves[0].color = pen.theme().series[3];
            left.curves[1].color = pen.theme().series[0];
            left.legend = draw::Legend::top_left;
            draw::Plot right{.title = "their difference",
                             .x = {.label = "time [s]"},
                             .y = {.label = "|E − E(0) − τ (θ − θ0)| [J]", .log = true}};
            right.curves = {error};
            const double width = 0.5 * (content.width - 24.0);
            draw::draw_plot(pen, {content.left, content.top, width, content.height}, left);
            draw::draw_plot(pen, {content.left + width + 24.0, content.top, width, content.height},
                            right);
          }};
}

pictures::Drift drift(const Scene& scene, const mechanics::Method& method, double duration,
                      double step) {
  Motion crank = motion(scene, method);
  return pictures::drift(method.label(), crank, duration, step);
}

Picture drift_picture(const Scene& scene, const RunOptions& run) {
  std::vector<pictures::Drift> drifts;
  for (const auto& scheme : integrators::schemes)
    drifts.push_back(drift(scene, {.integrator = scheme.id}, run.duration, run.step));
  const std::string caption = fmt::format(
      "No stabilization, step {:g} s, {:g} s: the joints open by {} m with explicit Euler, by {} m "
      "with RK4, by {} m with dop853.",
      run.step, run.duration, pictures::figure(drifts.front().largest_constraint_error),
      pictures::figure(pictures::find(drifts, "rk4").largest_constraint_error),
      pictures::figure(pictures::find(drifts, "dop853").largest_constraint_error));
  return pictures::drift_picture("drift", "Slider-crank: how five methods let the joints open",
                                 caption, drifts, "m or rad");
}

Picture stabilization_picture(const Scene& scene, const RunOptions& run) {
  const double step = 5.0 * run.step;
  std::vector<pictures::Drift> drifts;
  for (const mechanics::Method& method :
       {mechanics::Method{},
        mechanics::Method{integrators::Scheme::rk4, Stabilization::feedback, 625.0, 50.0},
        mechanics::Method{integrators::Scheme::rk4, Stabilization::projection}})
    drifts.push_back(drift(scene, method, run.duration, step));
  const std::string caption = fmt::format(
      "RK4 with a step of {:g} s: the joints open by {} m alone, {} m with feedback (ks = 625, kd "
      "= 50), rounding with "
      "projection.",
      step, pictures::figure(drifts[0].largest_constraint_error),
      pictures::figure(drifts[1].largest_constraint_error));
  return pictures::drift_picture("stabilization", "Slider-crank: three ways with the drift",
                                 caption, drifts, "m or rad");
}

class CrankStage final : public pictures::MechanismStage<> {
 public:
  CrankStage(const Scene& scene, const RunOptions& run, Bodies bodies = {})
      : MechanismStage(run, make_mechanism(scene, run.method, &bodies)),
        scene_(scene),
        bodies_(bodies) {
    begin(slider_crank::view(scene));
  }

  std::string title() const override { return "Slider-crank"; }
  std::string caption() override {
    return fmt::format("t = {:.3f} s: θ = {} rad, {} rad/s, joints open by {} m ({}, step {:g} s).",
                       time(), pictures::rounded(motion.q()[bodies_.wheel.column + 2], 3),
                       pictures::rounded(motion.v()[bodies_.wheel.column + 2], 3),
                       pictures::figure(motion.measures().constraint_error), run().method.label(),
                       run().step);
  }

 private:
  void draw_things(Canvas& canvas, const pictures::Show& show) override {
    const Instant at = now(scene_, motion, bodies_);
    draw_mechanism(canvas, scene_, at, show.forces);
    if (show.trail) canvas.curve(trail(0), canvas.theme().velocity, 1.4, draw::Dash::dotted);
    if (show.forces)
      draw_forces(canvas, at, largest_force(), 0.4 * (scene_.crank + scene_.wheel_radius),
                  show.numbers);
  }

  /// The middle of the rod.
  std::vector<Point> marks() const override {
    return {point(motion.q().segment<2>(bodies_.rod.column))};
  }
  double force() override { return largest(now(scene_, motion, bodies_).forces); }
  Point half_size(const dynamics::ThingInfo& thing) const override {
    if (thing.name == "wheel") return {scene_.wheel_radius, scene_.wheel_radius};
    if (thing.name == "rod") return {0.5 * scene_.rod, 0.0};
    if (thing.name == "slider") return {0.5 * scene_.slider_width, 0.5 * scene_.slider_height};
    return {};
  }

  Scene scene_;
  Bodies bodies_;
};

Picture turned_off_picture(Scene scene, const RunOptions& run) {
  const RunOptions part{.duration = 0.4 * run.duration, .step = run.step};
  std::array<std::unique_ptr<pictures::Stage>, 2> stages;
  std::array<double, 2> off;
  for (const std::size_t with : {0U, 1U}) {
    scene.without_jdotv = with == 0;
    stages[with] = std::make_unique<CrankStage>(scene, part);
    off[with] = drift(scene, {}, part.duration, part.step).largest_constraint_error;
  }
  const std::string caption = fmt::format(
      "Both after {:g} s: the joints open by up to {} m without the velocity term, by {} m with it "
      "(rk4, step "
      "{:g} s).",
      part.duration, pictures::figure(off[0]), pictures::figure(off[1]), part.step);
  return pictures::beside("turned_off", "Slider-crank: the velocity term of every joint",
                          std::move(stages[0]), "without the velocity term", std::move(stages[1]),
                          "with it", part.duration, caption, {.forces = false});
}

}  // namespace

std::vector<Picture> pictures(const Scene& scene, const RunOptions& run) {
  return {scene_picture(scene, run),     motion_picture(scene, run),
          forces_picture(scene, run),    energy_picture(scene, run),
          drift_picture(scene, run),     stabilization_picture(scene, run),
          turned_off_picture(scene, run)};
}

std::unique_ptr<pictures::Stage> stage(const Scene& scene, const RunOptions& run) {
  return std::make_unique<CrankStage>(scene, run);
}

}  // namespace slider_crank
