// A chapter of your own: the four-bar linkage with all that the tutorial's program offers.
#include <fmt/format.h>

#include <array>
#include <memory>

#include "app/chapter.hpp"
#include "instruments/draw/canvas.hpp"
#include "instruments/pictures/mechanism_stage.hpp"
#include "scene.hpp"

namespace four_bar {
namespace {

draw::Point point(const Vector2d& x) { return {x.x(), x.y()}; }

/// The scene in motion, to be drawn: what `snapshot` and `live` show.
class FourBarStage final : public pictures::MechanismStage<> {
 public:
  FourBarStage(const Scene& scene, const measure::RunOptions& run)
      : MechanismStage(run, make_mechanism(scene, run.method)), scene_(scene) {
    const double margin = 0.2 * scene.ground, high = scene.rocker + margin;
    begin({-scene.crank - margin, -high, scene.ground + scene.rocker + margin, high});
  }

  std::string title() const override { return "Four-bar linkage"; }
  std::string caption() override {
    return fmt::format("t = {:.3f} s: crank at {} rad, rocker at {} rad, joints open by {} m.",
                       time(), pictures::rounded(motion.q()[2]), pictures::rounded(motion.q()[8]),
                       pictures::figure(motion.measures().constraint_error));
  }

 private:
  void draw_things(draw::Canvas& canvas, const pictures::Show& show) override {
    const auto& theme = canvas.theme();
    for (const double x : {0.0, scene_.ground}) canvas.ground({x, 0});
    if (show.trail) canvas.curve(trail(0), theme.velocity, 1.6, draw::Dash::dotted);
    const std::array lengths{scene_.crank, scene_.coupler, scene_.rocker};
    for (std::size_t i = 0; i < lengths.size(); ++i) {
      const Vector2d from = end(i, -lengths[i] / 2), to = end(i, lengths[i] / 2);
      canvas.link(point(from), point(to), 9.0, theme.series[i], theme.body_edge);
      canvas.pin(point(from));
    }
    canvas.pin(marks()[0]);
  }
  /// The point of a bar that lies so far [m] from its middle, along it.
  Vector2d end(std::size_t bar, double along) const {
    const auto q = motion.q().segment<3>(3 * static_cast<Eigen::Index>(bar));
    return q.head<2>() + along * Vector2d(std::cos(q[2]), std::sin(q[2]));
  }
  /// What leaves a trail: the end of the rocker.
  std::vector<draw::Point> marks() const override { return {point(end(2, scene_.rocker / 2))}; }
  double force() override { return 0; }  // none is drawn
  draw::Point half_size(const dynamics::ThingInfo& thing) const override {
    if (thing.name == "crank") return {scene_.crank / 2, 0};
    return {(thing.name == "coupler" ? scene_.coupler : scene_.rocker) / 2, 0};
  }

  Scene scene_;
};

}  // namespace
}  // namespace four_bar

// [chapter]
int main(int argc, char** argv) {
  four_bar::Scene scene;
  app::Chapter chapter;
  chapter.directory = "08_four_bar";
  chapter.title = "Four-bar linkage";
  chapter.parameters = {
      {"--crank", "m", "length of the crank", &scene.crank, app::positive},
      {"--coupler", "m", "length of the coupler", &scene.coupler, app::positive},
      {"--rocker", "m", "length of the rocker", &scene.rocker, app::positive},
      {"--torque", "N·m", "on the crank", &scene.torque, app::any, app::acts | app::switchable},
      {"--theta0", "rad", "angle of the crank at the start", &scene.theta0, {-100.0, 100.0}},
      {"--gravity", "m/s²", "gravity, downwards", &scene.gravity, app::not_negative, app::acts},
  };
  chapter.defaults = {.duration = 1.0, .step = 0.001};
  chapter.start = [&](const mechanics::Method& method) {
    return std::make_unique<mechanics::Motion<mechanics::Mechanism>>(
        four_bar::make_mechanism(scene, method), method);
  };
  chapter.quantities = {{"rocker angle", "rad"}};
  chapter.errors = [&](const mechanics::Row& row) {  // of each body x, y, θ and their rates
    const double theta = row.state[2], psi = row.state[14];
    return std::vector{std::abs(psi - scene.rocker_angle(theta))};
  };
  chapter.ladder = {
      .methods = measure::methods_to_compare(625.0, 50.0), .duration = 1.0, .coarsest = 0.01};
  chapter.stage = [&](const measure::RunOptions& run) {
    return std::make_unique<four_bar::FourBarStage>(scene, run);
  };
  chapter.pictures = [&](const measure::RunOptions& run) {
    return std::vector{pictures::picture_at(chapter.stage(run), 0.0)};
  };
  return app::run_chapter(argc, argv, chapter);
}
// [chapter]
