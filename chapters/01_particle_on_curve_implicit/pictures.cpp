#include <algorithm>
#include <array>
#include <cmath>

#include "erratum.hpp"
#include "exact.hpp"
#include "held_bead.hpp"
#include "implicit_bead.hpp"
#include "instruments/pictures/lesson.hpp"
#include "study.hpp"
#include "track.hpp"

namespace particle_on_curve {
namespace {

using namespace pictures::lesson;
using parabola::ImplicitBead;
using parabola::Scene;

using Motion = mechanics::Motion<ImplicitBead>;

Motion motion(const Scene& scene, const mechanics::Method& method) {
  return {ImplicitBead(scene, method.ks, method.kd), method};
}

struct Instant {
  double t;
  Vector2d x, v, constraint_force;
};

Instant now(const Scene& scene, const Motion& motion) {
  return {motion.time(), motion.q(), motion.v(),
          motion.model().constraint_force(motion.q(), motion.v(), scene.applied_force())};
}

/// Moves on to the step nearest to t.
void advance_to(Motion& motion, double t, double step) {
  const long steps = std::lround((t - motion.time()) / step);
  if (steps > 0) motion.advance(steps, step);
}

void draw_forces(Canvas& canvas, const Scene& scene, const Instant& instant,
                 double metres_per_newton, bool labelled = true) {
  const auto& theme = canvas.theme();
  const auto arrow = [&](const Vector2d& force, draw::Color color, const std::string& name) {
    canvas.arrow(point(instant.x), point(metres_per_newton * force), color,
                 labelled ? fmt::format("{} {} N", name, pictures::rounded(force.norm())) : "");
  };
  arrow({0.0, scene.applied_force().y()}, theme.weight, "weight");
  if (scene.force_x != 0.0) arrow({scene.force_x, 0.0}, theme.applied_force, "applied force");
  arrow(instant.constraint_force, theme.constraint_force, "constraint force λ∇C");
  canvas.force_scale(metres_per_newton);
}

/// Metres for a newton, so that the larger of the forces is drawn a given part of the view long.
double force_scale(const Scene& scene, double largest_constraint_force, const draw::View& view,
                   double part) {
  const double largest = std::max(largest_constraint_force, scene.applied_force().norm());
  const double side = std::max(view.right - view.left, view.bottom - view.top);
  return largest > 0.0 ? part * side / largest : 0.0;
}

/// The curve alone, as the article shows it: twice as far out as the particle's start.
Picture curve_picture(Scene scene) {
  const double reach = scene.x0 == 0.0 ? 2.0 * scene.p : 2.0 * std::abs(scene.x0);
  const draw::View view{-reach, 1.05 * scene.height(reach), reach, -0.15 * scene.height(reach)};
  const std::string caption =
      fmt::format("x² + 2py = 0 with p = {:g} m, from x = {:g} to {:g} m: y points down.", scene.p,
                  -reach, reach);
  return {"curve", [=](draw::Pen& pen) {
            Canvas canvas(pen, draw::page(pen, "The curve x² + 2py = 0", caption), view);
            canvas.axes("m");
            std::vector<Point> points;
            for (int i = -100; i <= 100; ++i)
              points.push_back({reach * i / 100, scene.height(reach * i / 100)});
            canvas.curve(points, canvas.theme().track, 2.4);
            canvas.origin({0.0, 0.0});
          }};
}

Picture scene_picture(const Scene& scene, const RunOptions& run) {
  const Motion start = motion(scene, {});
  const Instant instant = now(scene, start);
  const draw::View view = parabola::view(scene, {scene, run.duration}, 0.1, 0.1);
  const double scale = force_scale(scene, instant.constraint_force.norm(), view, 0.28);
  const Vector2d sum = scene.applied_force() + instant.constraint_force;
  const std::string caption = fmt::format(
      "At rest at x = {:g} m. The forces on the particle add up to {} N along the curve: it "
      "starts to slide.",
      scene.x0, pictures::rounded(sum.norm()));
  return {"scene", [=](draw::Pen& pen) {
            Canvas canvas(pen, draw::page(pen, "A particle on the curve x² + 2py = 0", caption),
                          view);
            canvas.axes("m");
            parabola::draw_track(canvas, scene, view);
            canvas.origin({0.0, 0.0});
            const double x = scene.x0 == 0.0 ? 0.4 * view.right : -0.55 * scene.x0;
            canvas.label(
                {x, scene.height(x)}, fmt::format("C(x, y) = x² + 2py = 0,  p = {:g} m", scene.p),
                canvas.theme().track, draw::Font::bold,
                x < 0.0 ? draw::Align::left : draw::Align::right, {x < 0.0 ? 16.0 : -16.0, -8.0});
            canvas.arrow(point(instant.x), point(scale * sum), canvas.theme().muted);
            canvas.label(point(instant.x + scale * sum),
                         fmt::format("sum {} N", pictures::rounded(sum.norm())),
                         canvas.theme().muted, draw::Font::text, draw::Align::right, {-36.0, 0.0});
            draw_forces(canvas, scene, instant, scale);
            parabola::draw_bead(canvas, scene, instant.x);
          }};
}

/// Half a period, or the run where there is none, in `exposures` instants.
Picture motion_picture(const Scene& scene, const RunOptions& run) {
  const double half = std::min(0.5 * parabola::ExactMotion(scene).period(), run.duration);
  constexpr int exposures = 11;
  Motion particle = motion(scene, run.method);
  std::vector<Instant> instants;
  double largest = 0.0;
  for (int i = 0; i < exposures; ++i) {
    advance_to(particle, half * i / (exposures - 1), run.step);
    instants.push_back(now(scene, particle));
    largest = std::max(largest, instants.back().constraint_force.norm());
  }
  const draw::View view = parabola::view(scene, {scene, half}, 0.08, 0.07);
  const double scale = force_scale(scene, largest, view, 0.34);
  const Instant& middle = instants[exposures / 2];
  const double weight = scene.applied_force().y();
  std::string caption = fmt::format("At t = {:.2f} s the curve carries {} N", middle.t,
                                    pictures::rounded(middle.constraint_force.norm()));
  if (weight > 0.0)
    caption += fmt::format(", {:.2f} times the weight", middle.constraint_force.norm() / weight);
  caption += fmt::format(" ({}, step {:g} s).", run.method.label(), run.step);
  return {
      "motion", [=](draw::Pen& pen) {
        const draw::Rect content =
            draw::page(pen,
                       fmt::format("A particle on a curve: {} instants, from t = 0 to t = {:.2f} s",
                                   exposures, half),
                       caption);
        Canvas canvas(pen, content, view);
        canvas.axes("m");
        parabola::draw_track(canvas, scene, view);
        for (std::size_t i = 0; i < instants.size(); ++i) {
          const Instant& instant = instants[i];
          canvas.arrow(point(instant.x), point(scale * instant.constraint_force),
                       canvas.theme().constraint_force);
          parabola::draw_bead(canvas, scene, instant.x,
                              0.35 + 0.65 * static_cast<double>(i) / (exposures - 1));
          const double side = instant.x.x() > 1e-9 * scene.x0 ? 1.0 : -1.0;
          canvas.label(point(instant.x), fmt::format("{:.2f} s", instant.t), canvas.theme().muted,
                       draw::Font::small, side > 0.0 ? draw::Align::left : draw::Align::right,
                       {12.0 * side, 12.0});
        }
        canvas.force_scale(scale);
        canvas.label({0.5 * (view.left + view.right), view.top}, "arrows: constraint force λ∇C",
                     canvas.theme().constraint_force, draw::Font::bold, draw::Align::center,
                     {0.0, 16.0});
      }};
}

pictures::Drift drift(const Scene& scene, const mechanics::Method& method, double duration,
                      double step) {
  Motion particle = motion(scene, method);
  return pictures::drift(method.label(), particle, duration, step);
}

Picture drift_picture(const Scene& scene, const RunOptions& run) {
  std::vector<pictures::Drift> drifts;
  for (const auto& scheme : integrators::schemes)
    drifts.push_back(drift(scene, {.integrator = scheme.id}, run.duration, run.step));
  const std::string caption = fmt::format(
      "No stabilization, step {:g} s, {:g} s: explicit Euler reaches |C| = {} m², "
      "RK4 {} m², dop853 {} m².",
      run.step, run.duration, pictures::figure(drifts.front().largest_constraint_error),
      pictures::figure(pictures::find(drifts, "rk4").largest_constraint_error),
      pictures::figure(pictures::find(drifts, "dop853").largest_constraint_error));
  return pictures::drift_picture("drift", "A particle on a curve: how five methods leave it",
                                 caption, drifts, "m²");
}

Picture stabilization_picture(const Scene& scene, const RunOptions& run) {
  const double duration = 10.0 * run.duration;  // long enough to tell what grows from what does not
  std::vector<pictures::Drift> drifts;
  for (const mechanics::Method& method :
       {mechanics::Method{},
        mechanics::Method{integrators::Scheme::rk4, Stabilization::feedback, 4.0, 4.0},
        mechanics::Method{integrators::Scheme::rk4, Stabilization::projection}})
    drifts.push_back(drift(scene, method, duration, run.step));
  const std::string caption = fmt::format(
      "RK4, {:g} s with a step of {:g} s: largest |C| {} m² alone, {} m² with feedback (ks = 4, kd "
      "= 4), rounding "
      "with projection.",
      duration, run.step, pictures::figure(drifts[0].largest_constraint_error),
      pictures::figure(drifts[1].largest_constraint_error));
  return pictures::drift_picture(
      "stabilization", "A particle on a curve: three ways with the drift", caption, drifts, "m²");
}

Picture erratum_picture(Scene scene, const RunOptions& run) {
  if (scene.force_x == 0.0) scene.force_x = 5.0;
  mechanics::Motion<AsPrinted> printed(AsPrinted(scene), {});
  Motion right = motion(scene, {});
  const std::vector<pictures::Drift> drifts{
      pictures::drift("100·x·Fx, as printed", printed, run.duration, run.step),
      pictures::drift("50·x·Fx, as derived", right, run.duration, run.step)};
  const std::string caption = fmt::format(
      "With a horizontal force of {:g} N the printed formula reaches |C| = {} m², the "
      "derived one {} m².",
      scene.force_x, pictures::figure(drifts[0].largest_constraint_error),
      pictures::figure(drifts[1].largest_constraint_error));
  return pictures::drift_picture("erratum", "The article's misprint, exposed by a horizontal force",
                                 caption, drifts, "m²");
}

class BeadStage final : public pictures::Stage {
 public:
  BeadStage(const Scene& scene, const RunOptions& run)
      : Stage(run),
        scene_(scene),
        motion_(parabola::HeldBead(scene, run.method.ks, run.method.kd,
                                   [this](const Vector2d& x, const Vector2d& v) {
                                     const draw::Point F = spring_force(0, point(x), point(v));
                                     return Vector2d(F.x, F.y);
                                   }),
                run.method) {
    add(motion_, "");
    begin(parabola::view(scene, {scene, run.duration}, 0.1, 0.12));
  }

  std::string title() const override { return "A particle on the curve x² + 2py = 0"; }
  std::string caption() override {
    return fmt::format(
        "t = {:.3f} s: x = {} m, speed {} m/s, |C| = {} m² ({}, step {:g} s).", time(),
        pictures::rounded(motion_.q().x(), 3), pictures::rounded(motion_.v().norm(), 3),
        pictures::figure(motion_.measures().constraint_error), run().method.label(), run().step);
  }

 private:
  void draw_scene(draw::Pen& pen, const draw::Rect& area, const pictures::Show& show) override {
    Canvas canvas(pen, area, view());
    open(canvas, show);
    parabola::draw_track(canvas, scene_, view());
    if (show.trail) canvas.curve(trail(0), canvas.theme().velocity, 2.0, draw::Dash::dotted);
    if (show.forces)
      draw_forces(canvas, scene_, instant(), force_scale(scene_, largest_force(), view(), 0.2),
                  show.numbers);
    parabola::draw_bead(canvas, scene_, motion_.q());
    if (show.names)
      canvas.label(point(motion_.q()), "particle", canvas.theme().ink, draw::Font::bold,
                   draw::Align::left, {14.0, 14.0});
  }

  Instant instant() {
    const mechanics::Row row = motion_.row();
    return {time(), motion_.q(), motion_.v(), {row.reactions[0], row.reactions[1]}};
  }
  std::vector<draw::Point> marks() const override { return {point(motion_.q())}; }
  double force() override {
    return std::max(instant().constraint_force.norm(), scene_.applied_force().norm());
  }
  std::vector<Outline> outlines() const override {
    return {{.center = point(motion_.q()), .velocity = point(motion_.v())}};
  }
  Mass hold(std::size_t, draw::Point) override { return {scene_.mass, scene_.mass}; }

  Scene scene_;
  mechanics::Motion<parabola::HeldBead> motion_;
};

Picture turned_off_picture(Scene scene, const RunOptions& run) {
  const RunOptions part{.duration = 0.3 * run.duration, .step = run.step};
  std::array<std::unique_ptr<pictures::Stage>, 2> stages;
  std::array<double, 2> off;
  for (const std::size_t with : {0U, 1U}) {
    scene.without_velocity_term = with == 0;
    off[with] = drift(scene, {}, part.duration, part.step).largest_constraint_error;
    stages[with] = std::make_unique<BeadStage>(scene, part);
  }
  const std::string caption = fmt::format(
      "Both after {:g} s: without 2 m vx² the particle reaches |C| = {} m², with it {} m² "
      "(rk4, step {:g} s). The red line shows how far it is from the curve.",
      part.duration, pictures::figure(off[0]), pictures::figure(off[1]), part.step);
  return pictures::beside("turned_off", "A particle on a curve: the term that follows the bend",
                          std::move(stages[0]), "without 2 m vx²", std::move(stages[1]),
                          "with 2 m vx²", part.duration, caption);
}

}  // namespace

std::vector<Picture> pictures(const Scene& scene, const RunOptions& run) {
  return {
      curve_picture(scene),          scene_picture(scene, run),         motion_picture(scene, run),
      drift_picture(scene, run),     stabilization_picture(scene, run), erratum_picture(scene, run),
      turned_off_picture(scene, run)};
}

std::unique_ptr<pictures::Stage> stage(const Scene& scene, const RunOptions& run) {
  return std::make_unique<BeadStage>(scene, run);
}

}  // namespace particle_on_curve
