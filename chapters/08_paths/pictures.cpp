#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "exact.hpp"
#include "instruments/pictures/lesson.hpp"
#include "path_bead.hpp"
#include "study.hpp"

namespace any_wire {
namespace {

using namespace pictures::lesson;

Scene cycloid_by(const std::string& by, double q0) {
  Scene scene;
  scene.by = by;
  scene.q0 = q0;
  return scene;
}

/// Points of the wire between two places, dense enough for the eye.
std::vector<Point> points_of(const paths::Path& path, double from, double to) {
  std::vector<Point> points;
  constexpr int pieces = 600;
  for (int i = 0; i <= pieces; ++i)
    points.push_back(point(path(from + (to - from) * i / pieces).x));
  return points;
}

/// What a bead can come to in a time: all of a path, but of a projectile's, which has no end.
double last_seen(const Scene& scene, const paths::Path& path, double duration) {
  return scene.path == "projectile" ? 1.1 * duration : path.last;
}

void draw_wire(Canvas& canvas, const Scene& scene, const paths::Path& path, double duration) {
  canvas.curve(points_of(path, path.first, last_seen(scene, path, duration)), canvas.theme().track,
               2.4);
  for (const double knot : path.knots)
    canvas.bead(point(path(knot).x), 3.0, canvas.theme().paper, canvas.theme().track);
}

draw::View view_of(const Scene& scene, const paths::Path& path, double duration) {
  draw::View view{1e300, 1e300, -1e300, -1e300};
  for (const Point& p : points_of(path, path.first, last_seen(scene, path, duration)))
    view = {std::min(view.left, p.x), std::min(view.top, p.y), std::max(view.right, p.x),
            std::max(view.bottom, p.y)};
  const double room = 0.16 * std::max(view.right - view.left, view.bottom - view.top);
  return {view.left - room, view.top - room, view.right + room, view.bottom + room};
}

/// The way of the bead up to where it turns: its states at equal times.
std::vector<State> states(const Scene& scene, double duration, int count) {
  const auto exact = exact_motion(scene);
  double end = duration;
  constexpr int looks = 2000;
  double sense = 0.0;
  for (int i = 1; i <= looks; ++i) {
    const auto state = exact(duration * i / looks);
    if (!state || state->speed * sense < 0.0) {
      end = duration * (i - 1) / looks;
      break;
    }
    if (state->speed != 0.0) sense = state->speed;
  }
  std::vector<State> found;
  for (int i = 0; i < count; ++i)
    if (const auto state = exact(end * i / (count - 1))) found.push_back(*state);
  return found;
}

/// Where beside a place a text of so many letters covers the fewest of some points.
Point free_place(const Canvas& canvas, Point at, std::size_t letters,
                 const std::vector<Point>& points) {
  const double width = 7.5 * static_cast<double>(letters) / 2, k = canvas.points_per_metre();
  Point best{};
  auto fewest = points.size() + 1;
  for (const double down : {-18.0, 18.0, -30.0, 30.0})
    for (const double right : {width + 8, 0.0, -width - 8}) {
      const auto covered =
          static_cast<std::size_t>(std::count_if(points.begin(), points.end(), [&](Point p) {
            return std::abs(k * (p.x - at.x) - right) < width + 6 &&
                   std::abs(k * (p.y - at.y) - down) < 12;
          }));
      if (covered >= fewest) continue;
      fewest = covered;
      best = {right, down};
    }
  return best;
}

Picture scene_picture(const Scene& scene, const RunOptions& run) {
  const paths::Path path = path_of(scene);
  const paths::ByLength by_length(path);
  const std::vector<State> way = states(scene, run.duration, 9);
  double fastest = 0.0;
  for (const State& state : way) fastest = std::max(fastest, std::abs(state.speed));
  const std::string caption =
      way.empty()
          ? "No exact motion is known."
          : fmt::format(
                "The bead at {} equal times up to {}; its velocity lies along "
                "the tangent and is at most {} m/s.",
                way.size(), fmt::format("q = {:.3g}", way.back().q), pictures::rounded(fastest));
  return {"scene", [=](draw::Pen& pen) {
            draw::View view = view_of(scene, path, run.duration);
            const double longest = 0.24 * std::max(view.right - view.left, view.bottom - view.top);
            const auto arrow = [&](const State& state) {
              return Vector2d(longest / std::max(fastest, 1e-300) * state.speed *
                              by_length.tangent(state.q));
            };
            for (const State& state : way) {
              const Vector2d head = path(state.q).x + 1.05 * arrow(state);
              view = {std::min(view.left, head.x()), std::min(view.top, head.y()),
                      std::max(view.right, head.x()), std::max(view.bottom, head.y())};
            }
            Canvas canvas(pen, draw::page(pen, scene.path, caption), view);
            canvas.axes("m");
            draw_wire(canvas, scene, path, run.duration);
            std::vector<Point> drawn =
                points_of(path, path.first, last_seen(scene, path, run.duration));
            for (const State& state : way) {
              const Vector2d x = path(state.q).x;
              canvas.arrow(point(x), point(arrow(state)), canvas.theme().velocity);
              for (int i = 0; i <= 40; ++i) drawn.push_back(point(x + i / 40.0 * arrow(state)));
            }
            if (!way.empty())
              for (const State& state : {way.front(), way.back()}) {
                const std::string text = fmt::format("q = {:.3g}", state.q);
                const Point at = point(path(state.q).x);
                canvas.label(at, text, canvas.theme().ink, draw::Font::text, draw::Align::center,
                             free_place(canvas, at, text.size(), drawn));
              }
            for (const State& state : way)
              canvas.bead(point(path(state.q).x), 4.5, canvas.theme().body,
                          canvas.theme().body_edge);
          }};
}

/// Three beads from three heights, and one on the straight wire beside the highest.
Picture motion_picture() {
  const Scene scene;
  const double R = scene.radius, g = scene.gravity, pi = std::numbers::pi;
  const double fall = pi * std::sqrt(R / g), straight_time = std::sqrt((pi * pi + 4) * R / g);
  struct Panel {
    double t;
    std::array<Vector2d, 3> beads;
    Vector2d straight;
  };
  const std::array starts{pi, 0.7 * pi, 0.35 * pi};
  const paths::Path path = paths::cycloid(R);
  const paths::Path line = paths::line(path(pi).x, path(0).x);
  std::array<Panel, 4> panels;
  for (std::size_t k = 0; k < panels.size(); ++k) {
    Panel& panel = panels[k];
    panel.t = fall * static_cast<double>(k) / 3.0;
    for (std::size_t i = 0; i < starts.size(); ++i)
      panel.beads[i] = path(on_cycloid(R, g, {starts[i], 0.0}, panel.t)->q).x;
    panel.straight = line(std::pow(panel.t / straight_time, 2)).x;
  }
  const std::string caption = fmt::format(
      "From every height a bead is at the bottom after {:.3f} s, π√(R/g). On the straight wire "
      "from the cusp it needs {:.3f} s.",
      fall, straight_time);
  return {"motion", [=](draw::Pen& pen) {
            const draw::Rect content = draw::page(pen, "One time from every height", caption);
            constexpr double gap = 16.0;
            const double width = (content.width - gap) / 2, height = (content.height - gap) / 2;
            for (std::size_t k = 0; k < panels.size(); ++k) {
              const Panel& panel = panels[k];
              const draw::Rect area{content.left + static_cast<double>(k % 2) * (width + gap),
                                    content.top + static_cast<double>(k / 2) * (height + gap),
                                    width, height};
              Canvas canvas(pen, area, {-0.4, -0.25, 3.6, 2.25});
              const draw::Theme& theme = canvas.theme();
              canvas.curve(points_of(path, 0.0, pi), theme.track, 2.4);
              canvas.curve(points_of(line, 0.0, 1.0), theme.muted, 1.6, draw::Dash::dashed);
              canvas.bead(point(panel.straight), 7.0, theme.paper, theme.muted);
              for (std::size_t i = 0; i < 3; ++i)
                canvas.bead(point(panel.beads[i]), 9.0 - 2.5 * static_cast<double>(i),
                            theme.series[i], theme.body_edge);
              canvas.label({-0.3, -0.1}, fmt::format("t = {:.2f} s", panel.t), theme.ink,
                           draw::Font::bold);
            }
          }};
}

/// A bead at 1 m/s comes to a corner of 0.6 rad, behind which a unit of q is twice as long.
Picture corner_picture() {
  constexpr double turn = 0.6;
  const Vector2d on = Vector2d(std::cos(turn), std::sin(turn));
  Scene scene = preset("linear_spline").scene;
  scene.points = fmt::format("0,0 1,0 {:.17g},{:.17g}", 1 + 2 * on.x(), 2 * on.y());
  scene.gravity = 0.0;
  scene.speed = 1.0;
  const paths::Path path = path_of(scene);
  struct Answer {
    std::string text;
    double speed, impulse;
  };
  std::array<Answer, 3> answers{{{"inelastic", std::cos(turn), scene.mass * std::sin(turn)},
                                 {"rounded, by length", 0.0, 0.0},
                                 {"dq/dt kept, by parameter: wrong", 0.0, 0.0}}};
  for (std::size_t i : {1U, 2U}) {
    scene.by = i == 1 ? "length" : "parameter";
    const auto bead = start(scene)({});
    bead->advance(1800, 0.001);
    const std::vector<double> state = bead->row().state;
    answers[i].speed = state[1];
    answers[i].impulse = scene.mass * std::hypot(state[4] - scene.speed, state[5]);
  }
  std::string caption = fmt::format("1 kg at 1 m/s before a corner of {:g} rad.", turn);
  for (const auto& [text, speed, impulse] : answers)
    caption += fmt::format(" {}: {:.3f} m/s, impulse {:.4f} N·s.", text, speed, impulse);
  return {"corner", [=](draw::Pen& pen) {
            Canvas canvas(pen, draw::page(pen, "Three answers of a corner", caption),
                          {-0.3, -0.5, 3.0, 1.5});
            const draw::Theme& theme = canvas.theme();
            canvas.axes("m");
            canvas.curve(points_of(path, 0.0, 2.0), theme.track, 2.4);
            canvas.arrow({0.3, 0.0}, {0.4, 0.0}, theme.velocity);
            canvas.label({0.5, 0.0}, "before: 1 m/s", theme.velocity, draw::Font::text,
                         draw::Align::center, {0.0, -18.0});
            canvas.bead({0.3, 0.0}, 7.0, theme.body, theme.body_edge);
            canvas.label({1.0, 0.0}, "0.8 s after the corner:", theme.muted, draw::Font::text,
                         draw::Align::left, {30.0, -6.0});
            for (std::size_t i = 0; i < 3; ++i) {
              const Vector2d x = Vector2d(1, 0) + 0.8 * answers[i].speed * on;
              canvas.bead(point(x), 7.0, theme.series[i], theme.body_edge);
              canvas.label(point(x),
                           fmt::format("{}: {:.3f} m/s, {:.3f} N·s", answers[i].text,
                                       answers[i].speed, answers[i].impulse),
                           theme.ink, draw::Font::text,
                           i == 1 ? draw::Align::left : draw::Align::right,
                           {i == 1 ? 16.0 : -16.0, i == 1 ? -8.0 : 12.0});
            }
          }};
}

/// Semi-implicit Euler over many swings, by parameter and by length.
Picture symplectic_picture() {
  constexpr double h = 0.02, duration = 120.0, q0 = 2.0;
  std::vector<draw::Curve> curves;
  std::array<double, 2> most{};  // the time of the last look, and the error
  for (std::size_t i = 0; i < 2; ++i) {
    const auto bead = start(cycloid_by(i == 0 ? "parameter" : "length", q0))(
        {.integrator = integrators::Scheme::semi_implicit_euler});
    const pictures::Drift drift = pictures::drift("", *bead, duration, h);
    curves.push_back({.label = i == 0 ? "by parameter" : "by length",
                      .points = drift.energy_error,
                      .thickness = 2.2});
    most[i] = i == 0 ? drift.energy_error.back().x : drift.largest_energy_error;
  }
  const std::string caption = fmt::format(
      "semi_implicit_euler, h = {:g} s, from q = {:g}. By the parameter the energy grows, and "
      "after "
      "{:.0f} s the steps go over the end of the wire; by the length it is off by at most {} J.",
      h, q0, most[0], pictures::figure(most[1]));
  return {"symplectic", [=](draw::Pen& pen) {
            draw::draw_plot(pen, draw::page(pen, "Symplectic in s, not in q", caption),
                            {.x = {.label = "time [s]", .min = 0.0, .max = duration},
                             .y = {.label = "energy error [J]", .log = true},
                             .curves = curves});
          }};
}

/// The bead on its wire.
template <class Bead>
class WireStage final : public pictures::Stage {
 public:
  WireStage(const Scene& scene, const RunOptions& run)
      : Stage(run), scene_(scene), motion_(held(), run.method), exact_(exact_motion(scene)) {
    add(motion_, "");
    begin(view_of(scene, path(), run.duration));
  }

  std::string title() const override { return "A bead on a wire: " + scene_.path; }
  std::string caption() override {
    const mechanics::Row row = motion_.row();
    return fmt::format("t = {:.3f} s: q = {}, speed {} m/s (by {}, {}, step {:g} s){}", time(),
                       pictures::rounded(row.state[0], 3), pictures::rounded(row.state[1], 3),
                       scene_.by, run().method.label(), run().step,
                       undisturbed() ? "; the ring is the exact place." : ".");
  }

 private:
  const paths::Path& path() const { return motion_.model().path(); }

  Bead held() {
    Bead bead(scene_);
    bead.pull = [this](const Vector2d& x, const Vector2d& v) {
      const Point F = spring_force(0, point(x), point(v));
      return Vector2d(F.x, F.y);
    };
    return bead;
  }

  void draw_scene(draw::Pen& pen, const draw::Rect& area, const pictures::Show& show) override {
    Canvas canvas(pen, area, view());
    open(canvas, show);
    const draw::Theme& theme = canvas.theme();
    draw_wire(canvas, scene_, path(), run().duration);
    if (show.trail) canvas.curve(trail(0), theme.velocity, 2.0, draw::Dash::dotted);
    const mechanics::Row row = motion_.row();
    const Point x{row.state[2], row.state[3]};
    if (undisturbed())
      if (const auto state = exact_(time()))
        canvas.bead(point(path()(state->q).x), 10.0, draw::transparent, theme.constraint_force);
    if (show.forces && std::isfinite(row.reactions[0])) {
      const double longest = 0.16 * (view().right - view().left) / largest_force();
      canvas.arrow(
          x, longest * Point{row.reactions[0], row.reactions[1]}, theme.constraint_force,
          show.numbers
              ? fmt::format("constraint force {} N",
                            pictures::rounded(std::hypot(row.reactions[0], row.reactions[1])))
              : "");
    }
    canvas.bead(x, 7.0, theme.body, theme.body_edge);
    if (show.names)
      canvas.label(x, "particle", theme.ink, draw::Font::bold, draw::Align::left, {14.0, 14.0});
  }

  /// Where it is and how it moves.
  std::pair<Vector2d, Vector2d> now() const {
    const Bead& bead = motion_.model();
    const Now now = bead.now(motion_.q(), motion_.v());
    return {path()(now.q).x, now.speed * bead.tangent(now.q)};
  }
  std::vector<Point> marks() const override { return {point(now().first)}; }
  double force() override {
    const mechanics::Row row = motion_.row();
    const double force = std::hypot(row.reactions[0], row.reactions[1]);
    return std::isfinite(force) ? force : 0.0;
  }
  std::vector<Outline> outlines() const override {
    return {{.center = point(now().first), .velocity = point(now().second)}};
  }
  Mass hold(std::size_t, Point) override { return {scene_.mass, scene_.mass}; }

  Scene scene_;
  mechanics::Motion<Bead> motion_;
  std::function<std::optional<State>(double)> exact_;
};

}  // namespace

std::vector<Picture> pictures(const Scene& scene, const RunOptions& run) {
  std::vector<Picture> all{scene_picture(scene, run)};
  if (scene.path == "cycloid")
    for (const Picture& one : {motion_picture(), corner_picture(), symplectic_picture()})
      all.push_back(one);
  return all;
}

Picture orders_picture(const std::vector<Order>& orders) {
  std::vector<draw::Curve> curves;
  for (const Order& o : orders) {
    draw::Curve curve{
        .label = fmt::format("{}, by {}: order {:.1f}", o.wire, o.by, std::abs(o.order)),
        .dash = o.by == "parameter" ? draw::Dash::dashed
                : o.by == "length"  ? draw::Dash::solid
                                    : draw::Dash::dotted,
        .thickness = 2.2,
        .markers = true};
    for (std::size_t k = 0; k < o.errors.size(); ++k)
      curve.points.push_back({1.0 / static_cast<double>(coarsest_steps << k), o.errors[k]});
    curves.push_back(curve);
  }
  const auto error_at = [&](std::size_t i) { return pictures::figure(orders[i].errors[3]); };
  const std::string caption = fmt::format(
      "Mean error of RK4 after 1 s over {} start speeds. At h = 1/400 s the error on the "
      "Catmull-Rom spline is {} m by its parameter, {} m by its length, and {} m where steps end "
      "at "
      "the knots.",
      start_speeds, error_at(2), error_at(3), error_at(4));
  return {"orders", [=](draw::Pen& pen) {
            std::vector<draw::Curve> themed = curves;
            for (std::size_t i = 0; i < themed.size(); ++i)
              themed[i].color = pen.theme().series[i < 2 ? 0 : i < 5 ? 1 : 2];
            draw::draw_plot(pen, draw::page(pen, "How smooth a wire is decides the order", caption),
                            {.x = {.label = "step [s]", .log = true},
                             .y = {.label = "mean error of the place [m]", .log = true},
                             .curves = themed,
                             .legend = draw::Legend::above});
          }};
}

std::unique_ptr<pictures::Stage> stage(const Scene& scene, const RunOptions& run) {
  if (scene.by_length()) return std::make_unique<WireStage<BeadByLength>>(scene, run);
  return std::make_unique<WireStage<BeadByParameter>>(scene, run);
}

}  // namespace any_wire
