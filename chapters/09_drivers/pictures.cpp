#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "07_slider_crank/drawing.hpp"
#include "exact.hpp"
#include "instruments/pictures/mechanism_stage.hpp"
#include "mechanism.hpp"
#include "study.hpp"
#include "turned_off.hpp"

namespace drivers {
namespace {

using namespace pictures::lesson;
using slider_crank::Bodies;
using slider_crank::Instant;
using Motion = mechanics::Motion<mechanics::Mechanism>;

constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();  // tears a curve
const Method rk4{}, projected{integrators::Scheme::rk4, Stabilization::projection};

Scene with(Scene scene, const char* ease) {
  scene.ease = ease;
  return scene;
}

double torque_of(Motion& motion) { return motion.row().reactions.back(); }

double exact_torque(const Scene& scene, const joints::Given& told) {
  return static_cast<double>(torque(scene.machine, {told.f, told.f_dot, told.f_ddot}));
}

/// An arc about the wheel with a head where it pushes, as long as the torque is large.
void draw_motor(Canvas& canvas, const Scene& scene, double torque, double largest,
                const std::string& label) {
  const double r = 1.12 * scene.machine.wheel_radius, part = torque / largest;
  const draw::Color color = canvas.theme().constraint_force;
  std::vector<Point> arc;
  for (int i = 0; i <= 40; ++i) {
    const double angle = -2.4 + 1.2 * part * i / 40.0;
    arc.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  canvas.curve(arc, color, 2.4);
  if (std::abs(part) > 0.05) {
    const Point head = arc.back(), before = arc[34];
    canvas.arrow(before, 1.1 * (head - before), color);
  }
  if (!label.empty())
    canvas.label({0, -r}, label, color, draw::Font::bold, draw::Align::center, {0, -14});
}

Picture scene_picture(const Scene& scene, const RunOptions& run) {
  Bodies bodies;
  mechanics::Mechanism mechanism = make_mechanism(scene, run.method, &bodies);
  Motion machine(std::move(mechanism), run.method);
  const Instant start = slider_crank::now(scene.machine, machine, bodies);
  const dynamics::Counts counts = machine.model().evaluation().counts();
  const joints::Given end = move(scene)(scene.delay + scene.move);
  const std::string caption = fmt::format(
      "{} rows on {} coordinates leave {} degrees of freedom. The driver turns the crank by {:g} "
      "rad in {:g} s, {}.",
      counts.rows, counts.coordinates, counts.degrees_of_freedom, scene.turn, scene.move,
      scene.ease);
  return {"scene", [=](draw::Pen& pen) {
            Canvas canvas(pen,
                          draw::page(pen, "The machine of chapter 7, told how to move", caption),
                          slider_crank::view(scene.machine));
            canvas.axes("m");
            slider_crank::draw_mechanism(canvas, scene.machine, start);
            const auto& theme = canvas.theme();
            const double R = scene.machine.crank;
            const std::vector<Point> goal{{0.0, 0.0}, {R * std::cos(end.f), R * std::sin(end.f)}};
            canvas.curve(goal, theme.muted, 2.0, draw::Dash::dashed);
            canvas.label(goal.back(), "where it is to be", theme.muted, draw::Font::text,
                         draw::Align::left, {8, 6});
            draw_motor(canvas, scene, 1.0, 1.0, "wheel_driver: θ = f(t)");
            const auto name = [&](const Vector2d& at, const char* text, Point offset) {
              canvas.label(point(at), text, theme.constraint_force, draw::Font::bold,
                           draw::Align::center, offset);
            };
            name(start.crank_pin, "rod_wheel", {14, 24});
            name({0, 0}, "wheel_frame", {0, 30});
            name(start.slider.x, "slider_rod", {0, 64});
            name(start.slider.x, "slider_frame", {0, 84});
          }};
}

Picture eases_picture() {
  std::vector<draw::Plot> plots(3);
  const char* labels[] = {"E", "E′", "E″"};
  for (std::size_t i = 0; i < 3; ++i) {
    plots[i].x.label = "s";
    plots[i].y.label = labels[i];
    plots[i].legend = i == 0 ? draw::Legend::automatic : draw::Legend::none;
    for (const eases::Ease& ease : eases::all)
      plots[i].curves.push_back({.label = std::string(ease.name)});
  }
  for (std::size_t k = 0; k < eases::all.size(); ++k) {
    const eases::Move unit{eases::all[k], 0.0, 1.0, 0.0, 1.0};
    const auto add = [&](double s) {
      const joints::Given now = unit(s);
      plots[0].curves[k].points.push_back({s, now.f});
      plots[1].curves[k].points.push_back({s, now.f_dot});
      plots[2].curves[k].points.push_back({s, now.f_ddot});
    };
    double from = -0.1;
    for (const double to : {0.0, 0.5, 1.0, 1.1}) {  // torn where it may jump
      for (int i = 0; i <= 60; ++i)
        add(i < 60 ? from + (to - from) * i / 60.0 : std::nextafter(to, from));
      plots[2].curves[k].points.push_back({to, nowhere});
      from = to;
    }
  }
  return {
      "eases", [=](draw::Pen& pen) {
        const draw::Rect content = draw::page(
            pen, "Six eases: the same way, and what jumps in its second derivative",
            "smooth: E″ does not jump. sine_in_out: by 4.93 at both ends. quadratic_in_out: by 4 "
            "there and by −8 in the middle. cubic, quartic, quintic: there, by −24, −48, −80.");
        const double gap = 20.0, width = (content.width - 2 * gap) / 3;
        for (std::size_t i = 0; i < 3; ++i)
          draw::draw_plot(pen,
                          {content.left + static_cast<double>(i) * (width + gap), content.top,
                           width, content.height},
                          plots[i]);
      }};
}

Picture torque_picture(const Scene& scene, const RunOptions& run) {
  draw::Plot left{
      .title = "torque of the motor", .x = {.label = "time [s]"}, .y = {.label = "λ [N·m]"}},
      right{.title = "what it puts in, and where it goes",
            .x = {.label = "time [s]"},
            .y = {.label = "[J]"}};
  double worst = 0.0, most = 0.0;
  for (const char* ease : {"smooth", "sine_in_out", "cubic_in_out"}) {
    const Scene one = with(scene, ease);
    const eases::Move f = move(one);
    draw::Curve exact{.label = ease},
        found{.label = ease == std::string("cubic_in_out") ? "marks: λ of the run" : "",
              .markers = true,
              .marker_size = 0.8,
              .line = false};
    const auto jumps = f.jumps();
    double before = 0.0;
    for (int i = 0; i <= 400; ++i) {
      const double t = run.duration * i / 400.0;
      for (const double jump : jumps)
        if (before < jump && jump <= t) exact.points.push_back({jump, nowhere});
      exact.points.push_back({t, exact_torque(one, f(t))});
      before = t;
    }
    Motion motion(make_mechanism(one, run.method), run.method);
    const long steps = run.whole_steps(), stride = std::max(1L, steps / 40);
    const double start = motion.measures().energy;
    draw::Curve energy{.label = "energy gained", .thickness = 4.5},
        work{.label = "work of the motor", .dash = draw::Dash::dashed};
    for (long done = 0; done <= steps; done += stride) {
      if (done > 0) motion.advance(stride, run.step);
      const mechanics::Measures now = motion.measures();
      found.points.push_back({motion.time(), torque_of(motion)});
      energy.points.push_back({motion.time(), now.energy - start});
      work.points.push_back({motion.time(), now.work});
      worst = std::max(worst, std::abs(now.energy - start - now.work));
    }
    most = work.points.back().y;
    left.curves.push_back(exact);
    left.curves.push_back(found);
    if (right.curves.empty()) right.curves = {energy, work};
  }
  const Scene cubic = with(scene, "cubic_in_out");
  const eases::Move f = move(cubic);
  const double middle = f.jumps()[1];
  const std::string caption = fmt::format(
      "Lines: the exact torque; marks: λ of the driver's row ({}, step {:g} s). cubic_in_out jumps "
      "from {} to {} N·m. Whatever the ease, the motor does {:.4f} J of work; what the "
      "energy gains differs by at most {} J.",
      run.method.label(), run.step,
      pictures::rounded(exact_torque(cubic, f(std::nextafter(middle, 0.0)))),
      pictures::rounded(exact_torque(cubic, f(middle))), most, pictures::figure(worst));
  return {"torque", [=](draw::Pen& pen) {
            const draw::Rect content =
                draw::page(pen, "The multiplier of the driver is the torque of the motor", caption);
            draw::Plot torque = left, energy = right;
            for (std::size_t i = 0; i < torque.curves.size(); ++i)
              torque.curves[i].color = pen.theme().series[i / 2];
            energy.curves[0].color = pen.theme().series[3];
            energy.curves[1].color = pen.theme().ink;
            energy.legend = draw::Legend::top_left;
            const double width = 0.5 * (content.width - 24.0);
            draw::draw_plot(pen, {content.left, content.top, width, content.height}, torque);
            draw::draw_plot(pen, {content.left + width + 24.0, content.top, width, content.height},
                            energy);
          }};
}

/// Errors after three quarters of the move against the step, for RK4 alone.
Picture orders_picture(const Scene& scene) {
  draw::Plot left{.x = {.label = "step [s]", .log = true},
                  .y = {.label = "error of the angle [rad]", .log = true}},
      right{.x = {.label = "step [s]", .log = true},
            .y = {.label = "error of the motor's torque [N·m]", .log = true}};
  const double end = scene.delay + 0.75 * scene.move;
  const auto columns = make_mechanism(scene, {}).columns();
  double jumped = 0.0, ended = 0.0;
  const auto add = [&](const char* ease, bool end_at_jumps, const std::string& label) {
    Scene one = with(scene, ease);
    one.end_at_jumps = end_at_jumps;
    draw::Curve angle{.label = label, .markers = true}, torque{.label = label, .markers = true};
    for (long steps = 12; steps <= 12 << 7; steps *= 2) {
      Motion motion(make_mechanism(one, rk4), rk4);
      const double h = end / static_cast<double>(steps);
      motion.advance(steps, h);
      const std::vector<double> off = errors(one, columns, motion.row());
      angle.points.push_back({h, off[1]});
      torque.points.push_back({h, off[0]});
    }
    left.curves.push_back(angle);
    right.curves.push_back(torque);
    return torque.points.back().y;
  };
  jumped = add("cubic_in_out", false, "cubic_in_out, through the jump");
  ended = add("cubic_in_out", true, "cubic_in_out, a step ends there");
  add("smooth", true, "smooth");
  for (draw::Plot* plot : {&left, &right}) {
    const Point first = plot->curves[0].points.front(), last = plot->curves[2].points.front();
    plot->slopes = {{1, "order 1", {first.x, 1.5 * first.y}},
                    {4, "order 4", {last.x, 1.8 * last.y}}};
  }
  const std::string caption = fmt::format(
      "RK4, the jump of the acceleration always on a multiple of the step. With the finest the "
      "torque is off by "
      "{} N·m where RK4 asks for it behind the jump, by {} N·m where the step ends before it. The "
      "angle of the latter has no error at all, and no place on the left.",
      pictures::figure(jumped), pictures::figure(ended));
  return {"orders", [=](draw::Pen& pen) {
            const draw::Rect content = draw::page(
                pen, "A jump of the acceleration makes a fourth-order method one of first order",
                caption);
            draw::Plot angle = left, torque = right;
            for (draw::Plot* plot : {&angle, &torque}) {
              plot->curves[0].color = pen.theme().series[1];
              plot->curves[1].color = pen.theme().series[2];
              plot->curves[2].color = pen.theme().series[0];
            }
            torque.legend = draw::Legend::none;
            const double width = 0.5 * (content.width - 24.0);
            draw::draw_plot(pen, {content.left, content.top, width, content.height}, angle);
            draw::draw_plot(pen, {content.left + width + 24.0, content.top, width, content.height},
                            torque);
          }};
}

Picture turned_off_picture(const Scene& scene, const RunOptions& run) {
  const eases::Move f = move(scene);
  std::array<draw::Plot, 3> plots;
  const std::array<const char*, 3> titles{"wheel angle θ [rad]", "its rate ω [rad/s]",
                                          "torque of the motor λ [N·m]"};
  for (std::size_t i = 0; i < 3; ++i) {
    plots[i].x.label = "time [s]";
    plots[i].y.label = titles[i];
    plots[i].legend = i == 0 ? draw::Legend::top_left : draw::Legend::none;
  }
  const auto add = [&](const char* label, const Function& told, const Method& method,
                       double thickness, draw::Dash dash) {
    const draw::Curve curve{.label = label, .dash = dash, .thickness = thickness};
    for (draw::Plot& plot : plots) plot.curves.push_back(curve);
    Bodies bodies;
    mechanics::Mechanism mechanism = make_mechanism(scene.machine, told, method, &bodies);
    Motion motion(std::move(mechanism), method);
    const long steps = run.whole_steps(), stride = std::max(1L, steps / 100);
    for (long done = 0; done <= steps; done += stride) {
      if (done > 0) motion.advance(stride, run.step);
      const Eigen::Index theta = bodies.wheel.column + 2;
      const std::array values{motion.q()[theta], motion.v()[theta], torque_of(motion)};
      for (std::size_t i = 0; i < 3; ++i)
        plots[i].curves.back().points.push_back({motion.time(), values[i]});
    }
    return std::abs(motion.q()[bodies.wheel.column + 2] - f(motion.time()).f);
  };
  add("both, projected", f, projected, 6.0, draw::Dash::solid);
  add("no C_t, projected", without_C_t(f), projected, 3.5, draw::Dash::solid);
  const double alone = add("no C_tt", without_C_tt(f), rk4, 2.0, draw::Dash::solid);
  add("no C_tt, projected", without_C_tt(f), projected, 2.0, draw::Dash::dashed);
  const std::string caption = fmt::format(
      "Without C_tt the wheel does not turn with the driver: it is {:.2f} rad off at the end. "
      "Projection brings its angle and its rate back, not its torque. Without C_t it stops the "
      "wheel "
      "after each step.",
      alone);
  return {"turned_off", [=](draw::Pen& pen) {
            const draw::Rect content =
                draw::page(pen, "A driver that does not say how its function changes", caption);
            const double gap = 20.0, width = (content.width - 2 * gap) / 3;
            for (std::size_t i = 0; i < 3; ++i) {
              draw::Plot plot = plots[i];
              plot.curves[0].color = pen.theme().grid;
              for (std::size_t k = 1; k < 4; ++k) plot.curves[k].color = pen.theme().series[k - 1];
              draw::draw_plot(pen,
                              {content.left + static_cast<double>(i) * (width + gap), content.top,
                               width, content.height},
                              plot);
            }
          }};
}

class DrivenStage final : public pictures::MechanismStage<> {
 public:
  DrivenStage(const Scene& scene, const RunOptions& run, Bodies bodies = {})
      : MechanismStage(run, make_mechanism(scene, run.method, &bodies)),
        scene_(scene),
        bodies_(bodies) {
    const eases::Move f = move(scene);
    for (int i = 0; i <= 200; ++i)
      largest_torque_ =
          std::max(largest_torque_,
                   std::abs(exact_torque(scene, f(scene.delay + scene.move * (i + 0.5) / 201.0))));
    begin(slider_crank::view(scene.machine));
  }

  std::string title() const override { return "Driver: " + scene_.ease; }
  std::string caption() override {
    return fmt::format(
        "t = {:.3f} s: θ = {} rad, told {} rad; the motor turns the wheel with {} N·m ({}, step "
        "{:g} s).",
        time(), pictures::rounded(motion.q()[bodies_.wheel.column + 2], 3),
        pictures::rounded(move(scene_)(time()).f, 3), pictures::rounded(torque_of(motion), 3),
        run().method.label(), run().step);
  }

 private:
  void draw_things(Canvas& canvas, const pictures::Show& show) override {
    const Instant at = slider_crank::now(scene_.machine, motion, bodies_);
    slider_crank::draw_mechanism(canvas, scene_.machine, at, show.forces);
    const double R = scene_.machine.crank, told = move(scene_)(time()).f;
    canvas.gap(point(at.wheel.at({R, 0.0})),
               point(at.wheel.x + R * Vector2d(std::cos(told), std::sin(told))));
    if (show.trail) canvas.curve(trail(0), canvas.theme().velocity, 1.4, draw::Dash::dotted);
    if (!show.forces) return;
    slider_crank::draw_forces(canvas, at, largest_force(),
                              0.4 * (scene_.machine.crank + scene_.machine.wheel_radius),
                              show.numbers);
    const double torque = torque_of(motion);
    draw_motor(canvas, scene_, std::clamp(torque, -2 * largest_torque_, 2 * largest_torque_),
               largest_torque_,
               show.numbers ? fmt::format("motor {} N·m", pictures::rounded(torque, 2)) : "");
  }

  /// The middle of the rod.
  std::vector<Point> marks() const override {
    return {point(motion.q().segment<2>(bodies_.rod.column))};
  }
  double force() override {
    return slider_crank::largest(slider_crank::now(scene_.machine, motion, bodies_).forces);
  }
  Point half_size(const dynamics::ThingInfo& thing) const override {
    const slider_crank::Scene& machine = scene_.machine;
    if (thing.name == "wheel") return {machine.wheel_radius, machine.wheel_radius};
    if (thing.name == "rod") return {0.5 * machine.rod, 0.0};
    return {0.5 * machine.slider_width, 0.5 * machine.slider_height};
  }

  Scene scene_;
  Bodies bodies_;
  double largest_torque_ = 1e-300;
};

}  // namespace

std::vector<Picture> pictures(const Scene& scene, const RunOptions& run) {
  return {scene_picture(scene, run), eases_picture(), torque_picture(scene, run),
          orders_picture(scene), turned_off_picture(scene, run)};
}

std::unique_ptr<pictures::Stage> stage(const Scene& scene, const RunOptions& run) {
  return std::make_unique<DrivenStage>(scene, run);
}

}  // namespace drivers
