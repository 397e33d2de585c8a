#include <algorithm>
#include <cmath>
#include <numbers>

#include "exact.hpp"
#include "instruments/pictures/lesson.hpp"
#include "instruments/pictures/mechanism_stage.hpp"
#include "mechanics/integrators/amplification.hpp"
#include "mechanism.hpp"
#include "study.hpp"

namespace ground {
namespace {

using namespace pictures::lesson;

using Motion = mechanics::Motion<mechanics::Mechanism>;

Motion motion(const Scene& scene, const Method& method) {
  return {make_mechanism(scene, method), method};
}

/// A displaced plate, where the reader gave no displacement.
Scene displaced(Scene scene) {
  if (scene.offset().isZero())
    scene.offset_x = 0.05, scene.offset_y = -0.03, scene.offset_theta = 0.2;
  return scene;
}

struct Instant {
  double t;
  Eigen::Vector3d q, reaction;
};

Instant now(Motion& motion) {
  const mechanics::Row row = motion.row();
  return {row.t,
          {row.state[0], row.state[1], row.state[2]},
          {row.reactions[0], row.reactions[1], row.reactions[2]}};
}

draw::View view(const Scene& scene) {
  const double x = 0.75 + std::abs(scene.offset_x), y = 0.55 + std::abs(scene.offset_y);
  return {-x, -y, x, y};
}

/// The largest of weight, load and reaction [N].
double largest(const Scene& scene, const Instant& at) {
  return std::max(
      {scene.mass * scene.gravity, std::abs(scene.load_at(at.t)), at.reaction.head<2>().norm()});
}

/// Weight, load and reaction as arrows, the largest of them 0.38 m long, the load's lever, and the
/// reaction's moment as an arc.
void draw_forces(Canvas& canvas, const Scene& scene, const Instant& at, double largest,
                 bool labelled = true) {
  const auto& theme = canvas.theme();
  const double load = scene.load_at(at.t), weight = scene.mass * scene.gravity;
  const double scale = 0.38 / largest;
  const auto label = [&](const std::string& text) { return labelled ? text : std::string(); };
  const Point centre{at.q.x(), at.q.y()};
  const Point edge{at.q.x() + 0.5 * scene.width * std::cos(at.q.z()),
                   at.q.y() + 0.5 * scene.width * std::sin(at.q.z())};
  canvas.arrow(centre, edge - centre, theme.muted, label("lever b"));
  canvas.arrow(centre, {0.0, scale * weight}, theme.weight,
               label(fmt::format("weight {} N", pictures::rounded(weight))));
  canvas.arrow(edge, {0.0, scale * load}, theme.applied_force);
  canvas.label(edge, label(fmt::format("load {} N", pictures::rounded(std::abs(load)))),
               theme.applied_force, draw::Font::text, draw::Align::left, {14.0, 14.0});
  canvas.arrow(
      centre, {scale * at.reaction.x(), scale * at.reaction.y()}, theme.constraint_force,
      label(fmt::format("reaction {} N", pictures::rounded(at.reaction.head<2>().norm()))));
  if (const double moment = at.reaction.z(); std::abs(moment) > 1e-9) {
    const double way = moment > 0.0 ? 1.0 : -1.0;  // clockwise to the eye
    canvas.turn(centre, 44.0, std::numbers::pi - 0.8 * way, std::numbers::pi + 0.8 * way,
                theme.constraint_force,
                label(fmt::format("moment {} N·m", pictures::rounded(moment))));
  }
  canvas.force_scale(scale);
}

constexpr const char* plate_title = "A plate held by the ground";

void draw_held_plate(Canvas& canvas, const Scene& scene, const Eigen::Vector3d& q) {
  canvas.ground({0.0, 0.5 * scene.height}, 0.0, 1.1 * scene.width * canvas.points_per_metre());
  canvas.box({q.x(), q.y()}, scene.width, scene.height, q.z(), canvas.theme().body.faded(0.6),
             canvas.theme().body_edge);
  canvas.gap({0.0, 0.0}, {q.x(), q.y()});
}

Picture scene_picture(const Scene& scene) {
  Motion plate = motion(scene, {});
  plate.advance(40, 0.01);
  const Instant at = now(plate);
  const std::string caption = fmt::format(
      "At t = {:g} s the load is {} N; the reaction is minus weight and load, and minus their "
      "moment.",
      at.t, pictures::rounded(scene.load_at(at.t)));
  return {"scene", [=](draw::Pen& pen) {
            Canvas canvas(pen, draw::page(pen, plate_title, caption), view(scene));
            canvas.axes("m");
            draw_held_plate(canvas, scene, at.q);
            draw_forces(canvas, scene, at, largest(scene, at));
          }};
}

Picture reaction_picture(const Scene& scene, const RunOptions& run) {
  Motion plate = motion(scene, run.method);
  draw::Curve fy{.label = "reaction force fy [N]", .thickness = 4.5},
      expected{.label = "minus weight and load", .dash = draw::Dash::dashed};
  draw::Curve moment{.label = "reaction moment [N·m]", .thickness = 4.5},
      expected_moment{.label = "minus the load's moment", .dash = draw::Dash::dashed};
  double worst = 0.0;
  const long steps = run.whole_steps(), stride = std::max(1L, steps / 250);
  for (long done = 0; done <= steps; done += stride) {
    const Instant at = now(plate);
    const Eigen::Vector3d F = scene.applied(at.t, at.q.z());
    fy.points.push_back({at.t, at.reaction.y()});
    expected.points.push_back({at.t, -F.y()});
    moment.points.push_back({at.t, at.reaction.z()});
    expected_moment.points.push_back({at.t, -F.z()});
    worst = std::max(
        worst, (at.reaction - exact(scene, run.method, at.t).reaction).lpNorm<Eigen::Infinity>());
    plate.advance(stride, run.step);
  }
  const std::string caption = fmt::format(
      "Over {:g} s the computed reaction differs from the exact one by at most {} N or N·m.",
      run.duration, pictures::figure(worst));
  return {"reaction", [=](draw::Pen& pen) {
            const draw::Rect content = draw::page(
                pen, "A plate on the ground: its reaction under the load 5 sin 2t", caption);
            const double width = 0.5 * (content.width - 24.0);
            draw::Plot left{.title = "force",
                            .x = {.label = "time [s]"},
                            .y = {.label = "[N]"},
                            .curves = {fy, expected},
                            .legend = draw::Legend::above};
            draw::Plot right{.title = "moment",
                             .x = {.label = "time [s]"},
                             .y = {.label = "[N·m]"},
                             .curves = {moment, expected_moment},
                             .legend = draw::Legend::above};
            for (draw::Plot* plot : {&left, &right}) {
              plot->curves[0].color = pen.theme().series[3];
              plot->curves[1].color = pen.theme().series[0];
            }
            draw::draw_plot(pen, {content.left, content.top, width, content.height}, left);
            draw::draw_plot(pen, {content.left + width + 24.0, content.top, width, content.height},
                            right);
          }};
}

/// Measured angles as markers on the exact curve, for one pair of gains.
void add_decay(draw::Plot& plot, const Scene& scene, double ks, double kd, const std::string& label,
               std::size_t color, const draw::Theme& theme, double duration, double step,
               double& worst) {
  const Method method{integrators::Scheme::rk4,
                      ks == 0.0 && kd == 0.0 ? Stabilization::none : Stabilization::feedback, ks,
                      kd};
  draw::Curve line{.label = label, .color = theme.series[color]},
      markers{.color = theme.series[color], .markers = true, .line = false};
  Motion plate = motion(scene, method);
  const long steps = std::lround(duration / step);
  for (long done = 0; done <= steps; ++done) {
    const double t = static_cast<double>(done) * step;
    const Eigen::Vector3d truth = exact(scene, method, t).q;
    line.points.push_back({t, truth.z()});
    if (done % std::max(1L, steps / 24) == 0) markers.points.push_back({t, plate.q()[2]});
    worst = std::max(worst, std::abs(truth.z() - plate.q()[2]));
    if (done < steps) plate.advance(1, step);
  }
  plot.curves.push_back(line);
  plot.curves.push_back(markers);
}

struct Gains {
  double ks, kd;
  std::string label;
};

Picture decay_picture(const std::string& name, const std::string& title,
                      const std::string& sentence, const Scene& scene, double step,
                      const std::vector<Gains>& gains) {
  draw::Plot plot;
  plot.x.label = "time [s]";
  plot.y.label = "angle of the plate [rad]";
  double worst = 0.0;
  for (std::size_t i = 0; i < gains.size(); ++i)
    add_decay(plot, scene, gains[i].ks, gains[i].kd, gains[i].label, i, draw::theme("light"), 2.0,
              step, worst);
  const std::string caption =
      fmt::format("{} Lines: closed form. Markers: RK4 with a step of {:g} s, at most {} rad away.",
                  sentence, step, pictures::figure(worst));
  return {name, [=](draw::Pen& pen) {
            draw::Plot colored = plot;
            for (std::size_t i = 0; i < colored.curves.size(); ++i)
              colored.curves[i].color = pen.theme().series[i / 2];
            colored.legend = draw::Legend::above;
            draw::draw_plot(pen, draw::page(pen, title, caption), colored);
          }};
}

/// The same gains on the two sides of RK4's limit.
Picture step_picture() {
  constexpr double ks = 9e4, kd = 600.0, coarse = 0.01, fine = 0.0085, duration = 1.0;
  draw::Plot plot;
  plot.x.label = "time [s]";
  plot.y = {.label = "|x| of the plate [m]", .log = true};
  for (const double step : {coarse, fine}) {
    Motion plate =
        motion({.offset_x = 0.1}, {integrators::Scheme::rk4, Stabilization::feedback, ks, kd});
    draw::Curve curve{.label =
                          fmt::format("step {:g} s: h√ks = {:.3g}", step, step * std::sqrt(ks))};
    for (double off = 0.0; plate.time() <= duration && off < 1e3;) {
      off = std::abs(plate.q()[0]);
      curve.points.push_back({plate.time(), off});
      plate.advance(1, step);
    }
    plot.curves.push_back(curve);
  }
  const auto factor = [](double step) {
    return integrators::amplification(integrators::Scheme::rk4, step, ks, kd);
  };
  const std::string caption = fmt::format(
      "RK4 with ks = {:g} 1/s² and kd = {:g} 1/s multiplies the error by {:.3g} a step beyond its "
      "limit of 2.785, and by {:.3g} within it.",
      ks, kd, factor(coarse), factor(fine));
  return {"too_large_a_step", [=](draw::Pen& pen) {
            draw::draw_plot(
                pen,
                draw::page(pen, "A displaced plate: a step beyond the limit, and one within it",
                           caption),
                plot);
          }};
}

class PlateStage final : public pictures::MechanismStage<> {
 public:
  PlateStage(const Scene& scene, const RunOptions& run)
      : MechanismStage(run, make_mechanism(scene, run.method)), scene_(scene) {
    begin(ground::view(scene));
  }

  std::string title() const override { return plate_title; }
  std::string caption() override {
    return fmt::format("t = {:.3f} s: off its place by {} m and {} rad ({}, step {:g} s).", time(),
                       pictures::figure(motion.q().head<2>().norm()),
                       pictures::figure(std::abs(motion.q()[2])), run().method.label(), run().step);
  }

 private:
  void draw_things(Canvas& canvas, const pictures::Show& show) override {
    if (show.trail) canvas.curve(trail(0), canvas.theme().velocity, 1.6, draw::Dash::dotted);
    draw_held_plate(canvas, scene_, now(motion).q);
    if (show.forces) draw_forces(canvas, scene_, now(motion), largest_force(), show.numbers);
  }

  std::vector<Point> marks() const override { return {{motion.q()[0], motion.q()[1]}}; }
  double force() override { return largest(scene_, now(motion)); }
  Point half_size(const dynamics::ThingInfo&) const override {
    return {0.5 * scene_.width, 0.5 * scene_.height};
  }

  Scene scene_;
};

}  // namespace

std::vector<Picture> pictures(const Scene& scene, const RunOptions& run) {
  const Scene off = displaced(scene);
  return {scene_picture(scene), reaction_picture(scene, run),
          decay_picture("decay", "A displaced plate: the way back, by three dampings",
                        "ks = 25 1/s².", off, run.step,
                        {{25.0, 3.0, "kd = 3 1/s, underdamped"},
                         {25.0, 10.0, "kd = 10 1/s, critical"},
                         {25.0, 30.0, "kd = 30 1/s, overdamped"}}),
          decay_picture("turned_off", "A displaced plate: feedback, in part and not at all",
                        "Without kd the plate swings for ever, without both it stays off.", off,
                        run.step,
                        {{25.0, 10.0, "ks = 25 1/s², kd = 10 1/s"},
                         {25.0, 0.0, "ks = 25 1/s², kd = 0"},
                         {0.0, 0.0, "no feedback"}}),
          step_picture()};
}

std::unique_ptr<pictures::Stage> stage(const Scene& scene, const RunOptions& run) {
  return std::make_unique<PlateStage>(scene, run);
}

}  // namespace ground
