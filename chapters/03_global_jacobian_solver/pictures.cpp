#include <algorithm>
#include <array>
#include <cmath>

#include "01_particle_on_curve_implicit/exact.hpp"
#include "01_particle_on_curve_implicit/implicit_bead.hpp"
#include "01_particle_on_curve_implicit/track.hpp"
#include "exact.hpp"
#include "instruments/pictures/jacobian.hpp"
#include "instruments/pictures/lesson.hpp"
#include "instruments/pictures/mechanism_stage.hpp"
#include "mechanism.hpp"
#include "study.hpp"
#include "turned_off.hpp"

namespace dumbbell {
namespace {

using namespace pictures::lesson;
using pictures::figure;

using Motion = mechanics::Motion<mechanics::Mechanism>;

Motion motion(const Scene& scene, const mechanics::Method& method) {
  return {make_mechanism(scene, method), method};
}

/// What a row of the trajectory says.
struct Instant {
  double t;
  Vector2d x1, x2, curve1, curve2, rod1;  // forces of the curve on each bead, of the rod on bead1
};

Instant now(mechanics::Simulation& motion) {
  const mechanics::Row row = motion.row();
  const auto pair = [](const std::vector<double>& values, std::size_t i) {
    return Vector2d(values[i], values[i + 1]);
  };
  return {row.t,
          pair(row.state, 0),
          pair(row.state, 4),
          pair(row.reactions, 0),
          pair(row.reactions, 3),
          pair(row.reactions, 6)};
}

double largest_force(const Instant& i) {
  return std::max({i.curve1.norm(), i.curve2.norm(), i.rod1.norm()});
}

/// Moves on to the step nearest to t.
void advance_to(Motion& motion, double t, double step) {
  const long steps = std::lround((t - motion.time()) / step);
  if (steps > 0) motion.advance(steps, step);
}

/// What both beads visit in `duration` seconds, with room around it.
draw::View view(const Scene& scene, double duration) {
  const ExactMotion exact(scene);
  const double end = std::min(duration, exact.period());
  double left = std::min(scene.x1, scene.x2), right = std::max(scene.x1, scene.x2);
  double low = -1e300, high = 1e300;
  for (int i = 0; i <= 64; ++i) {
    const Exact at = exact.at(end * i / 64.0);
    for (const Vector2d& x : {at.x1, at.x2}) {
      left = std::min(left, x.x());
      right = std::max(right, x.x());
      low = std::max(low, x.y());
      high = std::min(high, x.y());
    }
  }
  const double side = std::max(right - left, low - high);
  return {left - 0.12 * side, high - 0.22 * side, right + 0.12 * side, low + 0.12 * side};
}

/// Metres for a newton, so that the largest force is drawn a given part of the view long.
double force_scale(double largest, const draw::View& view, double part) {
  const double side = std::max(view.right - view.left, view.bottom - view.top);
  return largest > 0.0 ? part * side / largest : 0.0;
}

draw::Color rod_color(const Canvas& canvas) { return canvas.theme().applied_force; }

void draw_track(Canvas& canvas, const Scene& scene, const draw::View& view) {
  parabola::draw_track(canvas, parabola::Scene{.p = scene.p}, view);
}

/// A rod without mass has no place of its own: it lies midway between the beads, as long as it is.
void draw_rod(Canvas& canvas, const Scene& scene, const Instant& instant, double presence = 1.0) {
  const Vector2d middle = 0.5 * (instant.x1 + instant.x2),
                 half = 0.5 * scene.rod() * (instant.x2 - instant.x1).normalized();
  canvas.link(point(middle - half), point(middle + half), 5.0, canvas.theme().body.faded(presence),
              canvas.theme().body_edge.faded(presence));
  canvas.gap(point(middle - half), point(instant.x1));
  canvas.gap(point(middle + half), point(instant.x2));
}

void draw_beads(Canvas& canvas, const Scene& scene, const Instant& instant, double presence = 1.0) {
  for (const Vector2d& x : {instant.x1, instant.x2})
    parabola::draw_bead(canvas, parabola::Scene{.p = scene.p}, x, presence);
}

/// The force of the curve on each bead, and of the rod on both.
void draw_forces(Canvas& canvas, const Instant& i, double scale, bool labelled) {
  const auto arrow = [&](const Vector2d& at, const Vector2d& force, draw::Color color,
                         const char* name) {
    canvas.arrow(point(at), point(scale * force), color,
                 labelled ? fmt::format("{} {} N", name, pictures::rounded(force.norm())) : "");
  };
  arrow(i.x1, i.curve1, canvas.theme().constraint_force, "λ₁∇C₁");
  arrow(i.x2, i.curve2, canvas.theme().constraint_force, "λ₂∇C₂");
  arrow(i.x1, i.rod1, rod_color(canvas), "−λ₃d");
  arrow(i.x2, -i.rod1, rod_color(canvas), "λ₃d");
  canvas.force_scale(scale);
}

/// Chapter 1's scene over half a period: its formula as a line, the global solver as marks.
Picture one_bead_picture(const RunOptions& run) {
  const parabola::Scene scene;
  OneBead solver(scene);
  mechanics::Motion<parabola::ImplicitBead> bead(parabola::ImplicitBead(scene), {});
  const double half = 0.5 * parabola::ExactMotion(scene).period();
  const long steps = std::max(24L, std::lround(half / run.step)), stride = steps / 24;
  draw::Curve formula{.label = "chapter 1's formula", .thickness = 2.4};
  draw::Curve global{.label = "global solver", .markers = true, .line = false};
  double worst = 0.0;
  for (long done = 0; done <= steps; ++done) {
    const Vector2d force = bead.model().constraint_force(bead.q(), bead.v(), scene.applied_force());
    const OneBead::Answer answer = solver.solve(bead.q(), bead.v());
    worst = std::max(worst, (answer.force - force).norm() / force.norm());
    formula.points.push_back({bead.time(), force.norm()});
    if (done % stride == 0) global.points.push_back({bead.time(), answer.force.norm()});
    bead.advance(1, half / static_cast<double>(steps));
  }
  const std::string caption = fmt::format(
      "Chapter 1's bead over half a period: at all {} states the two forces agree to {} of the "
      "force.",
      steps + 1, worst < 1e-12 ? "better than 10⁻¹²" : figure(worst));
  return {"one_bead", [=](draw::Pen& pen) {
            draw::Plot plot{.x = {.label = "time [s]"},
                            .y = {.label = "constraint force [N]", .min = 0.0},
                            .curves = {formula, global},
                            .legend = draw::Legend::top_right};
            draw::draw_plot(
                pen,
                draw::page(pen, "One bead: the global solver returns chapter 1's force", caption),
                plot);
          }};
}

Picture scene_picture(const Scene& scene, const RunOptions& run) {
  Motion start = motion(scene, {});
  const Instant instant = now(start);
  const draw::View seen = view(scene, run.duration);
  const double weight1 = scene.m1 * scene.gravity, weight2 = scene.m2 * scene.gravity;
  const double scale = force_scale(std::max({largest_force(instant), weight1, weight2}), seen, 0.2);
  const std::string caption = fmt::format(
      "Two beads, one curve, one rod of {:.4g} m: 4 coordinates, 3 constraints, 1 degree of "
      "freedom. At rest the rod carries {} N.",
      scene.rod(), pictures::rounded(instant.rod1.norm()));
  return {
      "scene", [=](draw::Pen& pen) {
        Canvas canvas(pen, draw::page(pen, "Two beads on a curve, joined by a rod", caption), seen);
        canvas.axes("m");
        draw_track(canvas, scene, seen);
        const double middle = 0.5 * (seen.left + seen.right);
        canvas.label({middle, seen.top},
                     fmt::format("curve: C = x² + 2py = 0,  p = {:g} m;  force λ∇C", scene.p),
                     canvas.theme().track, draw::Font::bold, draw::Align::center, {0.0, 20.0});
        canvas.label(
            {middle, seen.top},
            fmt::format("rod: C₃ = ½(|d|² − l²) = 0,  l = {:.4g} m;  force ±λ₃d", scene.rod()),
            rod_color(canvas), draw::Font::bold, draw::Align::center, {0.0, 42.0});
        canvas.arrow(point(instant.x1), {0.0, scale * weight1}, canvas.theme().weight,
                     fmt::format("weight {} N", pictures::rounded(weight1)));
        canvas.arrow(point(instant.x2), {0.0, scale * weight2}, canvas.theme().weight,
                     fmt::format("weight {} N", pictures::rounded(weight2)));
        draw_rod(canvas, scene, instant);
        // d beside the rod, from bead1 to bead2
        const Vector2d d = instant.x2 - instant.x1;
        const Vector2d aside = 18.0 / canvas.points_per_metre() *
                               Vector2d(-d.y(), d.x()).normalized() * (d.x() > 0.0 ? 1.0 : -1.0);
        canvas.arrow(point(instant.x1 + aside), point(d), canvas.theme().ink);
        canvas.label(point(instant.x1 + aside + 0.4 * d), "d = x₂ − x₁", canvas.theme().ink,
                     draw::Font::bold, draw::Align::left, {10.0, 12.0});
        draw_forces(canvas, instant, scale, true);
        draw_beads(canvas, scene, instant);
        const double side = scene.x2 > scene.x1 ? 1.0 : -1.0;
        const auto outer = side > 0.0 ? draw::Align::left : draw::Align::right;
        canvas.label(point(instant.x2), fmt::format("bead2, {:g} kg", scene.m2), canvas.theme().ink,
                     draw::Font::bold, outer, {14.0 * side, 32.0});
        canvas.label(point(instant.x1), fmt::format("bead1, {:g} kg", scene.m1), canvas.theme().ink,
                     draw::Font::bold, outer, {14.0 * side, 32.0});
      }};
}

Picture jacobian_picture(const Scene& scene) {
  mechanics::Mechanism mechanism = make_mechanism(scene, {});
  Eigen::VectorXd a;
  mechanism.acceleration(0.0, mechanism.initial_position(), mechanism.initial_velocity(), a);
  const int blocks = mechanism.evaluation().counts().jacobian_blocks;
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Matrix J = mechanism.evaluation().jacobian();
  const Matrix K = J * mechanism.system.W().asDiagonal() * J.transpose();
  using Sides = std::vector<pictures::Jacobian::Side>;
  const Sides joints{{"bead1_curve", {""}}, {"bead2_curve", {""}}, {"bead1_bead2", {""}}};
  const pictures::Jacobian left{.joints = joints,
                                .things = {{"bead1", {"x", "y"}}, {"bead2", {"x", "y"}}},
                                .values = {J.data(), J.data() + J.size()}};
  const pictures::Jacobian right{
      .joints = joints,
      .things = {{"bead1_curve", {" "}}, {"bead2_curve", {" "}}, {"bead1_bead2", {" "}}},
      .values = {K.data(), K.data() + K.size()}};
  const std::string caption = fmt::format(
      "{} of 6 blocks of J are there; the others are zero and have no storage. A bead is a "
      "particle: no column for an angle. The two curves share no bead, so J W Jᵀ is blank there.",
      blocks);
  return {"jacobian", [=](draw::Pen& pen) {
            const draw::Rect content = draw::page(
                pen, "The global J: a row for each constraint, columns for each bead", caption);
            const double gap = 40.0, width = 0.5 * (content.width - gap), top = content.top + 30.0;
            const double height = 0.8 * (content.bottom() - top);
            const double second = content.left + width + gap;
            pen.text({content.left, content.top + 14.0}, "J at the start [m]", pen.theme().ink,
                     draw::Font::bold);
            pen.text({second, content.top + 14.0}, "J W Jᵀ at the start [m²/kg]", pen.theme().ink,
                     draw::Font::bold);
            pictures::draw_jacobian(pen, {content.left, top, width, height}, left);
            pictures::draw_jacobian(pen, {second, top, width, height}, right);
          }};
}

/// Half a swing, or the run where there is none, in a few exposures.
Picture motion_picture(const Scene& scene, const RunOptions& run) {
  constexpr int exposures = 5;
  const double half = std::min(0.5 * ExactMotion(scene).period(), run.duration);
  Motion beads = motion(scene, run.method);
  std::vector<Instant> instants;
  double largest = 0.0, rod_time = 0.0, rod_force = 0.0;
  for (int i = 0; i < exposures; ++i) {
    advance_to(beads, half * i / (exposures - 1), run.step);
    instants.push_back(now(beads));
    largest = std::max(largest, largest_force(instants.back()));
    if (instants.back().rod1.norm() > rod_force) {
      rod_force = instants.back().rod1.norm();
      rod_time = instants.back().t;
    }
  }
  const draw::View seen = view(scene, half);
  const double scale = force_scale(largest, seen, 0.2);
  const std::string caption =
      fmt::format("Of these instants the rod carries most at t = {:.2f} s, {} N ({}, step {:g} s).",
                  rod_time, pictures::rounded(rod_force), run.method.label(), run.step);
  return {
      "motion", [=](draw::Pen& pen) {
        Canvas canvas(
            pen,
            draw::page(pen,
                       fmt::format("Two beads and a rod: {} instants, from t = 0 to t = {:.2f} s",
                                   exposures, half),
                       caption),
            seen);
        canvas.axes("m");
        draw_track(canvas, scene, seen);
        for (std::size_t i = 0; i < instants.size(); ++i) {
          const Instant& instant = instants[i];
          const double presence = 0.3 + 0.7 * static_cast<double>(i) / (exposures - 1);
          draw_rod(canvas, scene, instant, presence);
          draw_beads(canvas, scene, instant, presence);
          draw_forces(canvas, instant, scale, false);
          const Vector2d d = (instant.x2 - instant.x1).normalized();
          const Vector2d up = d.x() > 0.0 ? Vector2d(d.y(), -d.x()) : Vector2d(-d.y(), d.x());
          canvas.label(point(0.5 * (instant.x1 + instant.x2)), fmt::format("{:.1f} s", instant.t),
                       canvas.theme().muted, draw::Font::small, draw::Align::center,
                       {26.0 * up.x(), 14.0 * up.y()});
        }
        const double middle = 0.5 * (seen.left + seen.right);
        canvas.label({middle, seen.top}, "force of the curve on each bead",
                     canvas.theme().constraint_force, draw::Font::bold, draw::Align::center,
                     {0.0, 16.0});
        canvas.label({middle, seen.top}, "force of the rod on each bead", rod_color(canvas),
                     draw::Font::bold, draw::Align::center, {0.0, 36.0});
      }};
}

pictures::Drift drift(const Scene& scene, const mechanics::Method& method, double duration,
                      double step) {
  Motion beads = motion(scene, method);
  return pictures::drift(method.label(), beads, duration, step);
}

Picture drift_picture(const Scene& scene, const RunOptions& run) {
  std::vector<pictures::Drift> drifts;
  for (const auto& scheme : integrators::schemes)
    drifts.push_back(drift(scene, {.integrator = scheme.id}, run.duration, run.step));
  const std::string caption = fmt::format(
      "No stabilization, step {:g} s, {:g} s: explicit Euler reaches |C| = {} m², RK4 {} m², "
      "dop853 {} m².",
      run.step, run.duration, figure(drifts.front().largest_constraint_error),
      figure(pictures::find(drifts, "rk4").largest_constraint_error),
      figure(pictures::find(drifts, "dop853").largest_constraint_error));
  return pictures::drift_picture("drift", "Two beads and a rod: how five methods let go", caption,
                                 drifts, "m²");
}

Picture stabilization_picture(const Scene& scene, const RunOptions& run) {
  // Coarse and long enough that RK4 has something to correct.
  const double step = 20.0 * run.step, duration = 10.0 * run.duration;
  constexpr auto rk4 = integrators::Scheme::rk4;
  std::vector<pictures::Drift> drifts;
  for (const auto& [label, method] :
       {std::pair{"rk4", mechanics::Method{}},
        {"rk4 + feedback, ks = 1, kd = 2", {rk4, Stabilization::feedback, 1.0, 2.0}},
        {"rk4 + feedback, ks = 25, kd = 10", {rk4, Stabilization::feedback, 25.0, 10.0}},
        {"rk4 + projection", {rk4, Stabilization::projection}}}) {
    drifts.push_back(drift(scene, method, duration, step));
    drifts.back().label = label;
  }
  const std::string caption = fmt::format(
      "RK4 with a coarse step of {:g} s over {:g} s: largest |C| {} m² alone, {} m² with soft "
      "feedback, {} m² with hard feedback, rounding with projection.",
      step, duration, figure(drifts[0].largest_constraint_error),
      figure(drifts[1].largest_constraint_error), figure(drifts[2].largest_constraint_error));
  return pictures::drift_picture("stabilization", "Two beads and a rod: four ways with the drift",
                                 caption, drifts, "m²");
}

/// The beads as the global solver moves them, or one that solves each constraint by itself.
template <class Model>
class DumbbellStage final : public pictures::MechanismStage<Model> {
 public:
  DumbbellStage(const Scene& scene, const RunOptions& run, Model model)
      : pictures::MechanismStage<Model>(run, std::move(model)), scene_(scene) {
    this->begin(dumbbell::view(scene, run.duration));
  }

  std::string title() const override { return "Two beads on a curve, joined by a rod"; }
  std::string caption() override {
    return fmt::format(
        "t = {:.3f} s: bead1 at x = {} m, bead2 at x = {} m, |C| = {} m² ({}, step {:g} "
        "s).",
        this->time(), pictures::rounded(this->motion.q()[0], 3),
        pictures::rounded(this->motion.q()[2], 3), figure(this->motion.measures().constraint_error),
        this->run().method.label(), this->run().step);
  }

 private:
  void draw_things(Canvas& canvas, const pictures::Show& show) override {
    draw_track(canvas, scene_, this->view());
    if (show.trail)
      for (const std::size_t bead : {0U, 1U})
        canvas.curve(this->trail(bead), canvas.theme().velocity, 2.0, draw::Dash::dotted);
    const Instant instant = now(this->motion);
    draw_rod(canvas, scene_, instant);
    if (show.forces)
      draw_forces(canvas, instant, force_scale(this->largest_force(), this->view(), 0.2),
                  show.numbers);
    draw_beads(canvas, scene_, instant);
  }

  std::vector<draw::Point> marks() const override {
    return {{this->motion.q()[0], this->motion.q()[1]}, {this->motion.q()[2], this->motion.q()[3]}};
  }
  double force() override { return dumbbell::largest_force(now(this->motion)); }
  draw::Point half_size(const dynamics::ThingInfo&) const override { return {}; }

  Scene scene_;
};

std::unique_ptr<pictures::Stage> make_stage(const Scene& scene, const RunOptions& run) {
  if (scene.without_coupling)
    return std::make_unique<DumbbellStage<OneByOne>>(scene, run, OneByOne(scene, run.method));
  return std::make_unique<DumbbellStage<mechanics::Mechanism>>(scene, run,
                                                               make_mechanism(scene, run.method));
}

Picture turned_off_picture(Scene scene, const RunOptions& run) {
  const RunOptions part{.duration = 0.15 * run.duration, .step = run.step};
  std::array<std::unique_ptr<pictures::Stage>, 2> stages;
  std::array<double, 2> off;
  for (const std::size_t together : {0U, 1U}) {
    scene.without_coupling = together == 0;
    stages[together] = make_stage(scene, part);
    mechanics::Motion<OneByOne> apart(OneByOne(scene), {});
    Motion beads = motion(scene, {});
    mechanics::Simulation& simulation =
        together == 0 ? static_cast<mechanics::Simulation&>(apart) : beads;
    off[together] =
        pictures::drift("", simulation, part.duration, part.step).largest_constraint_error;
  }
  const std::string caption = fmt::format(
      "Both after {:g} s: one by one the forces break each other's constraints, |C| = {} m². "
      "Solved together: {} m² (rk4, step {:g} s).",
      part.duration, figure(off[0]), figure(off[1]), part.step);
  return pictures::beside("turned_off", "Two beads and a rod: the blocks beside the diagonal",
                          std::move(stages[0]), "each constraint by itself", std::move(stages[1]),
                          "all of J W Jᵀ", part.duration, caption);
}

}  // namespace

std::vector<Picture> pictures(const Scene& scene, const RunOptions& run) {
  return {scene_picture(scene, run),     one_bead_picture(run),
          jacobian_picture(scene),       motion_picture(scene, run),
          drift_picture(scene, run),     stabilization_picture(scene, run),
          turned_off_picture(scene, run)};
}

std::unique_ptr<pictures::Stage> stage(const Scene& scene, const RunOptions& run) {
  return make_stage(scene, run);
}

}  // namespace dumbbell
