#include <algorithm>
#include <array>
#include <cmath>

#include "01_particle_on_curve_implicit/exact.hpp"
#include "01_particle_on_curve_implicit/held_bead.hpp"
#include "01_particle_on_curve_implicit/implicit_bead.hpp"
#include "01_particle_on_curve_implicit/track.hpp"
#include "instruments/pictures/lesson.hpp"
#include "parametric_bead.hpp"
#include "study.hpp"

namespace parametric_lagrangian {
namespace {

using namespace pictures::lesson;
using parabola::ImplicitBead;
using parabola::Scene;

using Implicit = mechanics::Motion<ImplicitBead>;
using Parametric = mechanics::Motion<ParametricBead>;

Vector2d place(const Implicit& motion) { return motion.q(); }
Vector2d place(const Parametric& motion) { return motion.model().x(motion.q()); }

/// Where a particle went, and how far it strayed.
struct Trail {
  std::vector<draw::Point> points;
  Vector2d end;
  double off_curve;     ///< |C| at the end [m²]
  double energy_error;  ///< at the end [J]
};

template <class Motion>
Trail trail(Motion motion, double duration, double step) {
  Trail result{{point(place(motion))}, {}, 0.0, 0.0};
  const double initial_energy = motion.measures().energy;
  const long steps = std::lround(duration / step), window = std::max(1L, steps / 4000);
  for (long done = 0; done < steps; done += window) {
    motion.advance(std::min(window, steps - done), step);
    result.points.push_back(point(place(motion)));
  }
  const mechanics::Measures now = motion.measures();
  result.end = place(motion);
  result.off_curve = now.constraint_error;
  result.energy_error = now.energy - initial_energy;
  return result;
}

struct Pair {
  Trail implicit, parametric;
};

Pair pair(const Scene& scene, integrators::Scheme integrator, double duration, double step) {
  const mechanics::Method method{.integrator = integrator};
  return {trail(Implicit(ImplicitBead(scene), method), duration, step),
          trail(Parametric(ParametricBead(scene), method), duration, step)};
}

/// Over a panel: what it shows and how far that is off. Returns the room that is left.
draw::Rect draw_heading(draw::Pen& pen, const draw::Rect& area, const std::string& title,
                        double off_curve, double energy_error) {
  pen.text({area.left, area.top + 9.0}, title, pen.theme().ink, draw::Font::bold);
  pen.text(
      {area.left, area.top + 27.0},
      fmt::format("|C| = {} m²,  {}", pictures::figure(off_curve),
                  std::isnan(energy_error)
                      ? "pulled from outside"
                      : fmt::format("energy error {} J", pictures::figure(std::abs(energy_error)))),
      pen.theme().muted, draw::Font::small);
  return {area.left, area.top + 38.0, area.width, area.height - 38.0};
}

/// One panel: the track, the trail, the particle where it is and, as a ring, where it should be.
void draw_panel(draw::Pen& pen, const draw::Rect& area, const draw::View& view, const Scene& scene,
                const Trail& trail, const Vector2d& exact, const std::string& title) {
  Canvas canvas(pen, draw_heading(pen, area, title, trail.off_curve, trail.energy_error), view);
  canvas.axes("m");
  parabola::draw_track(canvas, scene, view);
  canvas.curve(trail.points, canvas.theme().velocity, 1.4);
  canvas.bead(point(exact), 10.0, draw::transparent, canvas.theme().constraint_force);
  parabola::draw_bead(canvas, scene, trail.end);
}

/// A row a method, implicit left, parametric right.
void draw_rows(draw::Pen& pen, const draw::Rect& content, const Scene& scene,
               const std::vector<std::pair<std::string, Pair>>& rows, double duration) {
  draw::View view = parabola::view(scene, {scene, duration}, 0.03, 0.06);
  for (const auto& [name, row] : rows)
    for (const Trail* trail : {&row.implicit, &row.parametric})
      for (const draw::Point& p : trail->points)
        view = {std::min(view.left, p.x), std::min(view.top, p.y), std::max(view.right, p.x),
                std::max(view.bottom, p.y)};
  const double margin = 0.03 * (view.right - view.left);
  view = {view.left - margin, view.top - margin, view.right + margin, view.bottom + margin};
  const auto [q, qdot] = parabola::ExactMotion(scene).at(duration);
  const Vector2d exact(q, scene.height(q));
  const double gap = 24.0, width = 0.5 * (content.width - gap);
  const double height = (content.height - 14.0 * static_cast<double>(rows.size() - 1)) /
                        static_cast<double>(rows.size());
  double top = content.top;
  for (const auto& [name, row] : rows) {
    draw_panel(pen, {content.left, top, width, height}, view, scene, row.implicit, exact,
               "implicit, " + name);
    draw_panel(pen, {content.left + width + gap, top, width, height}, view, scene, row.parametric,
               exact, "parametric, " + name);
    top += height + 14.0;
  }
}

Picture scene_picture(const Scene& scene, const RunOptions& run) {
  const draw::View view = parabola::view(scene, {scene, run.duration}, 0.1, 0.12);
  const ParametricBead bead(scene);
  const Vector2d x = bead.x(scene.x0);
  const std::string caption = fmt::format(
      "At x = {:g} m a step of 1 m in q is a way of {:.2f} m along the curve: the inertia of q is "
      "m(1 + q²/p²).",
      scene.x0, bead.v(scene.x0, 1.0).norm());
  return {"scene", [=](draw::Pen& pen) {
            Canvas canvas(
                pen, draw::page(pen, "One coordinate q for one degree of freedom", caption), view);
            canvas.axes("m");
            parabola::draw_track(canvas, scene, view);
            const double top = view.top + 0.04 * (view.bottom - view.top);
            const std::vector<draw::Point> down{{x.x(), x.y()}, {x.x(), 0.0}};
            canvas.curve(down, canvas.theme().muted, 1.2, draw::Dash::dashed);
            canvas.arrow({0.0, 0.0}, {x.x(), 0.0}, canvas.theme().velocity, "");
            canvas.label({0.5 * x.x(), 0.0}, fmt::format("q = {:g} m", scene.x0),
                         canvas.theme().velocity, draw::Font::bold, draw::Align::center,
                         {0.0, 16.0});
            canvas.label({0.0, top}, "x(q) = (q, −q²/2p)", canvas.theme().track, draw::Font::bold,
                         draw::Align::center);
            parabola::draw_bead(canvas, scene, x);
          }};
}

Picture motion_picture(const Scene& scene, const RunOptions& run) {
  const double duration = 3.0 * run.duration, step = 10.0 * run.step;
  const std::vector<std::pair<std::string, Pair>> rows{
      {"explicit Euler", pair(scene, integrators::Scheme::explicit_euler, duration, step)},
      {"RK4", pair(scene, integrators::Scheme::rk4, duration, step)}};
  const double q = parabola::ExactMotion(scene).at(duration).q;
  const auto off = [&](const Trail& trail) {
    return (trail.end - Vector2d(q, scene.height(q))).norm();
  };
  const std::string caption = fmt::format(
      "Trails over {:g} s with a step of {:g} s; the ring is the exact place. Explicit Euler ends "
      "{:.0f} m off with the "
      "implicit particle and {:.0f} m with the parametric one, RK4 {} m and {} m.",
      duration, step, off(rows[0].second.implicit), off(rows[0].second.parametric),
      pictures::figure(off(rows[1].second.implicit)),
      pictures::figure(off(rows[1].second.parametric)));
  return {"motion", [=](draw::Pen& pen) {
            const draw::Rect content =
                draw::page(pen, "Two descriptions, two integrators", caption);
            draw_rows(pen, content, scene, rows, duration);
          }};
}

Picture drift_picture(const Scene& scene, const RunOptions& run) {
  std::vector<pictures::Drift> drifts;
  using enum integrators::Scheme;
  for (const auto integrator : {explicit_euler, semi_implicit_euler, rk4}) {
    Implicit implicit(ImplicitBead(scene), {.integrator = integrator});
    Parametric parametric(ParametricBead(scene), {.integrator = integrator});
    const std::string name(integrators::info(integrator).text);
    drifts.push_back(pictures::drift(name + ", implicit", implicit, run.duration, run.step));
    drifts.push_back(pictures::drift(name + ", parametric", parametric, run.duration, run.step));
  }
  const std::string caption = fmt::format(
      "RK4, step {:g} s, {:g} s: the implicit particle reaches |C| = {} m², the "
      "parametric one has only round-off error; "
      "the energies are off by at most {} J and {} J.",
      run.step, run.duration, pictures::figure(drifts[4].largest_constraint_error),
      pictures::figure(drifts[4].largest_energy_error),
      pictures::figure(drifts[5].largest_energy_error));
  return pictures::drift_picture("drift", "A particle on a curve: what each description lets go",
                                 caption, drifts, "m²");
}

/// The parametric particle with a hand's force: the part of it along dx/dq = (1, −q/p) acts on q.
class HeldParametric : public ParametricBead {
 public:
  HeldParametric(const Scene& scene, parabola::Hand hand)
      : ParametricBead(scene), scene_(scene), hand_(std::move(hand)) {}

  void acceleration(double t, double q, double qdot, double& qddot) const {
    ParametricBead::acceleration(t, q, qdot, qddot);
    const double p = scene_.p;
    const Vector2d F = hand_(x(q), v(q, qdot));
    qddot += p * p * (F.x() - q / p * F.y()) / (scene_.mass * (p * p + q * q));
  }
  mechanics::Measures measures(double t, double q, double qdot) const {
    mechanics::Measures measures = ParametricBead::measures(t, q, qdot);
    const Vector2d F = scene_.applied_force() + hand_(x(q), v(q, qdot));
    measures.drive = F.norm() / std::sqrt(scene_.mass);
    return measures;
  }

 private:
  Scene scene_;
  parabola::Hand hand_;
};

/// Both descriptions side by side.
class PairStage final : public pictures::Stage {
 public:
  PairStage(const Scene& scene, const RunOptions& run)
      : Stage(run),
        scene_(scene),
        implicit_(parabola::HeldBead(scene, 0.0, 0.0, hand(0)), run.method),
        parametric_(HeldParametric(scene, hand(1)), run.method) {
    add(implicit_, "implicit");
    add(parametric_, "parametric");
    begin(parabola::view(scene, {scene, run.duration}, 0.03, 0.06));
  }

  std::string title() const override { return "The same motion in two descriptions"; }
  std::string caption() override {
    return fmt::format("t = {:.3f} s, {}, step {:g} s{}", time(), run().method.label(), run().step,
                       undisturbed() ? "; the ring is the exact place." : ".");
  }

 private:
  void draw_scene(draw::Pen& pen, const draw::Rect& area, const pictures::Show& show) override {
    std::optional<Vector2d> exact;
    if (undisturbed()) {
      const double q = parabola::ExactMotion(scene_).at(time()).q;
      exact = Vector2d(q, scene_.height(q));
    }
    const double gap = show.numbers ? 24.0 : 4.0, width = 0.5 * (area.width - gap);
    draw_side(pen, {area.left, area.top, width, area.height}, 0, exact, show);
    draw_side(pen, {area.left + width + gap, area.top, width, area.height}, 1, exact, show);
  }

  void draw_side(draw::Pen& pen, draw::Rect area, std::size_t side,
                 const std::optional<Vector2d>& exact, const pictures::Show& show) {
    if (show.numbers) {
      const pictures::Stage::Errors errors = errors_now(side);
      area = draw_heading(pen, area, names()[side] + ", " + run().method.label(), errors.constraint,
                          errors.energy);
    }
    Canvas canvas(pen, area, view());
    open(canvas, show);
    parabola::draw_track(canvas, scene_, view());
    if (show.trail) canvas.curve(trail(side), canvas.theme().velocity, 1.4);
    if (exact) canvas.bead(point(*exact), 10.0, draw::transparent, canvas.theme().constraint_force);
    const Vector2d x = side == 0 ? place(implicit_) : place(parametric_);
    if (show.forces) {
      const double longest = 0.16 * (view().right - view().left);
      const Vector2d force = curve_force(side);
      canvas.arrow(
          point(x), point(longest / largest_force() * force), canvas.theme().constraint_force,
          show.numbers ? fmt::format("constraint force {} N", pictures::rounded(force.norm()))
                       : "");
    }
    parabola::draw_bead(canvas, scene_, x);
    if (!show.numbers)
      canvas.label({0.5 * (view().left + view().right), view().bottom}, names()[side],
                   canvas.theme().muted, draw::Font::small, draw::Align::center, {0.0, 14.0});
    if (show.names)
      canvas.label(point(x), "particle", canvas.theme().ink, draw::Font::bold, draw::Align::left,
                   {14.0, 14.0});
  }

  static Vector2d place(const mechanics::Motion<parabola::HeldBead>& motion) { return motion.q(); }
  static Vector2d place(const mechanics::Motion<HeldParametric>& motion) {
    return motion.model().x(motion.q());
  }
  static Vector2d velocity(const mechanics::Motion<HeldParametric>& motion) {
    return motion.model().v(motion.q(), motion.v());
  }
  Vector2d curve_force(std::size_t side) {
    const mechanics::Row row = side == 0 ? implicit_.row() : parametric_.row();
    return {row.reactions[0], row.reactions[1]};
  }
  parabola::Hand hand(std::size_t side) {
    return [this, side](const Vector2d& x, const Vector2d& v) {
      const draw::Point F = spring_force(side, point(x), point(v));
      return Vector2d(F.x, F.y);
    };
  }

  std::vector<draw::Point> marks() const override {
    return {point(place(implicit_)), point(place(parametric_))};
  }
  double force() override { return std::max(curve_force(0).norm(), curve_force(1).norm()); }
  std::vector<Outline> outlines() const override {
    return {{.center = point(place(implicit_)), .velocity = point(implicit_.v()), .canvas = 0},
            {.center = point(place(parametric_)),
             .velocity = point(velocity(parametric_)),
             .canvas = 1}};
  }
  Mass hold(std::size_t, draw::Point) override { return {scene_.mass, scene_.mass}; }

  Scene scene_;
  mechanics::Motion<parabola::HeldBead> implicit_;
  mechanics::Motion<HeldParametric> parametric_;
};

/// The parametric particle with the velocity term and without, and what the energy says of both.
Picture turned_off_picture(Scene scene, const RunOptions& run) {
  const parabola::ExactMotion exact(scene);
  const double time = 0.25 * run.duration;
  std::array<pictures::Drift, 2> drifts;
  std::array<Vector2d, 2> places;
  for (const std::size_t with : {0U, 1U}) {
    scene.without_velocity_term = with == 0;
    Parametric bead(ParametricBead(scene), {});
    bead.advance(std::lround(time / run.step), run.step);
    places[with] = bead.model().x(bead.q());
    drifts[with] = pictures::drift(with == 0 ? "without −q (dq/dt)²" : "with −q (dq/dt)²", bead,
                                   run.duration, run.step);
  }
  const std::string caption = fmt::format(
      "Left: both after {:g} s, the ring is the exact place; they are on the curve to rounding. "
      "Right: over {:g} s the energy is off by {} J without the velocity term, by {} J with it "
      "(rk4, step {:g} s).",
      time, run.duration, pictures::figure(drifts[0].largest_energy_error),
      pictures::figure(drifts[1].largest_energy_error), run.step);
  const double q = exact.at(time).q;
  const Vector2d truth(q, scene.height(q));
  const draw::View view = parabola::view(scene, {scene, run.duration}, 0.1, 0.1);
  return {"turned_off", [=](draw::Pen& pen) {
            const draw::Rect content =
                draw::page(pen, "A particle on a curve: the velocity term, left out", caption);
            const double gap = 20.0, width = 0.5 * (content.width - gap);
            draw::Plot plot{.x = {.label = "time [s]", .min = 0.0, .max = run.duration},
                            .y = {.label = "energy error [J]", .log = true},
                            .legend = draw::Legend::above};
            for (const pictures::Drift& drift : drifts)
              plot.curves.push_back({.label = drift.label,
                                     .points = drift.energy_error,
                                     .thickness = 2.2,
                                     .markers = true,
                                     .mark_every = 50});
            draw::draw_plot(pen, {content.left + width + gap, content.top, width, content.height},
                            plot);
            Canvas canvas(pen, {content.left, content.top, width, content.height}, view);
            canvas.axes("m");
            parabola::draw_track(canvas, scene, view);
            canvas.bead(point(truth), 11.0, draw::transparent, canvas.theme().constraint_force);
            for (const std::size_t with : {0U, 1U}) {
              parabola::draw_bead(canvas, scene, places[with]);
              canvas.label(point(places[with]), with == 0 ? "without" : "with",
                           with == 0 ? canvas.theme().warning : canvas.theme().ink,
                           draw::Font::bold, with == 0 ? draw::Align::left : draw::Align::right,
                           {with == 0 ? 14.0 : -18.0, 6.0});
            }
          }};
}

}  // namespace

std::vector<Picture> pictures(const Scene& scene, const RunOptions& run) {
  return {scene_picture(scene, run), motion_picture(scene, run), drift_picture(scene, run),
          turned_off_picture(scene, run)};
}

std::unique_ptr<pictures::Stage> stage(const Scene& scene, const RunOptions& run) {
  return std::make_unique<PairStage>(scene, run);
}

}  // namespace parametric_lagrangian
