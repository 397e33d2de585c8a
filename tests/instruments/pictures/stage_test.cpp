// What shows a scene in motion: the stage, the player that keeps it at real time, the hand's
// spring.

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <tuple>
#include <vector>

#include "01_particle_on_curve_implicit/held_bead.hpp"
#include "01_particle_on_curve_implicit/study.hpp"
#include "02_parametric_lagrangian/study.hpp"
#include "03_global_jacobian_solver/study.hpp"
#include "04_ground/study.hpp"
#include "05_revolute/study.hpp"
#include "06_prismatic/study.hpp"
#include "07_slider_crank/study.hpp"
#include "09_drivers/study.hpp"
#include "app/chapter.hpp"
#include "app/player.hpp"
#include "catch.hpp"
#include "instruments/draw/offscreen.hpp"
#include "instruments/pictures/mechanism_stage.hpp"
#include "mechanics/joints/revolute.hpp"

namespace {

using measure::RunOptions;
using pictures::Stage;

const RunOptions crank_run{.duration = 2.0, .step = 0.001};

draw::Image picture(Stage& stage) {
  return draw::render({.scale = 0.5}, [&](draw::Pen& pen) { pictures::draw_page(pen, stage); });
}

bool same(const draw::Image& a, const draw::Image& b) { return a.rgba == b.rgba; }

/// A rod that hangs from a pin, at rest, with a hand on it.
class Rod final : public pictures::MechanismStage<> {
 public:
  explicit Rod(const RunOptions& run, double half_width = 1.2)
      : MechanismStage(run, make(run.method)) {
    begin({-half_width, -1.2, half_width, 1.2});
  }

  std::string title() const override { return "rod"; }
  std::string caption() override { return ""; }

  Eigen::Vector2d end() {
    const Eigen::VectorXd& q = motion.q();
    return q.head<2>() + 0.5 * Eigen::Vector2d(std::cos(q[2]), std::sin(q[2]));
  }
  double energy() { return motion.measures().energy; }
  /// The power of the hand [W].
  double power() {
    const Eigen::VectorXd &q = motion.q(), &v = motion.v();
    const Eigen::Vector2d arm =
        dynamics::rotation(q[2]) * Eigen::Vector2d(spring()->u.x, spring()->u.y);
    const Eigen::Vector2d r = q.head<2>() + arm, rdot = v.head<2>() + v[2] * dynamics::S(arm);
    const draw::Point F = spring_force(0, {r.x(), r.y()}, {rdot.x(), rdot.y()});
    return F.x * rdot.x() + F.y * rdot.y();
  }
  using MechanismStage::spring;

  using MechanismStage::view;

  draw::Point on_page(const Eigen::Vector2d& x) const { return lens_.to_page({x.x(), x.y()}); }

 private:
  static mechanics::Mechanism make(const mechanics::Method& method) {
    mechanics::Mechanism mechanism(method);
    dynamics::System& system = mechanism.system;
    const auto rod = system.add_body("rod", 1.0, 1.0 / 12.0, {0.0, 0.5}, std::acos(0.0));
    system.add("pin", joints::Revolute{.u1 = {-0.5, 0.0}}, rod, dynamics::System::world);
    system.set_gravity({0.0, 9.81});
    mechanism.assemble();
    return mechanism;
  }
  void draw_things(draw::Canvas& canvas, const pictures::Show&) override { lens_ = canvas.lens(); }
  std::vector<draw::Point> marks() const override { return {{motion.q()[0], motion.q()[1]}}; }
  double force() override { return 1.0; }
  draw::Point half_size(const dynamics::ThingInfo&) const override { return {0.5, 0.0}; }

  draw::Lens lens_;
};

/// Takes hold of the rod's end and pulls it to a place.
void take_end(Rod& rod, const Eigen::Vector2d& to) {
  picture(rod);
  REQUIRE(rod.grip(rod.on_page(rod.end())));
  rod.pull(rod.on_page(to));
}

}  // namespace

/// Where a colour stands in a picture of a stage, bodies and gaps alone, in points.
std::vector<draw::Point> places(Stage& stage, const draw::Color& color) {
  const draw::Image image = draw::render({.scale = 1.0}, [&](draw::Pen& pen) {
    pictures::draw_page(pen, stage, {.forces = false, .trail = false});
  });
  std::vector<draw::Point> found;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const auto* pixel = &image.rgba[4 * static_cast<std::size_t>(y * image.width + x)];
      if (pixel[0] == color.r && pixel[1] == color.g && pixel[2] == color.b)
        found.push_back({static_cast<double>(x), static_cast<double>(y)});
    }
  return found;
}

double extent(const std::vector<draw::Point>& points) {
  double largest = 0.0;
  for (const draw::Point& a : points)
    for (const draw::Point& b : points) largest = std::max(largest, draw::length(a - b));
  return largest;
}

const draw::Color warning = draw::theme("light").warning;

TEST_CASE(
    "a torn crank keeps its rod's length, and its joints are drawn as far apart as they are") {
  const auto torn = slider_crank::stage({}, crank_run), whole = slider_crank::stage({}, crank_run);
  torn->advance_to(26.0);
  REQUIRE(torn->samples().back().errors[0].constraint > 0.3);  // [m]
  whole->show_as(*torn);
  torn->show_as(*torn);
  const draw::Color rod = draw::theme("light").series[0];
  REQUIRE(places(*whole, rod).size() > 500);
  CHECK(extent(places(*torn, rod)) == Approx(extent(places(*whole, rod))).margin(3.0));
  CHECK(places(*whole, warning).empty());
  CHECK(extent(places(*torn, warning)) > 0.3 / 1.3 * extent(places(*whole, rod)));
}

TEST_CASE("an open joint of any scene is seen, a closed one shows nothing") {
  constexpr auto euler = integrators::Scheme::explicit_euler;
  using Make = std::function<std::unique_ptr<Stage>(const RunOptions&)>;
  const std::vector<std::tuple<const char*, Make, RunOptions>> scenes{
      {"1", [](const RunOptions& run) { return particle_on_curve::stage({}, run); }, {20.0, 0.1}},
      {"2",
       [](const RunOptions& run) { return parametric_lagrangian::stage({}, run); },
       {20.0, 0.1}},
      {"3", [](const RunOptions& run) { return dumbbell::stage({}, run); }, {20.0, 0.1}},
      {"5", [](const RunOptions& run) { return revolute::stage({.links = 2}, run); }, {2.0, 0.01}},
      {"6",
       [](const RunOptions& run) { return prismatic::stage({.spin = 5.0}, run); },
       {2.0, 0.02}},
      {"7", [](const RunOptions& run) { return slider_crank::stage({}, run); }, {2.0, 0.005}},
      {"7, frame",
       [](const RunOptions& run) { return slider_crank::stage({.simulate_frame = true}, run); },
       {2.0, 0.005}},
      {"9", [](const RunOptions& run) { return drivers::stage({}, run); }, {2.0, 0.02}}};
  for (const auto& [name, make, run] : scenes) {
    INFO("chapter " << name);
    RunOptions coarse = run;
    coarse.method.integrator = euler;
    const auto stage = make(coarse);
    CHECK(places(*stage, warning).empty());
    stage->advance_to(0.5 * run.duration);
    CHECK(places(*stage, warning).size() > 20);
  }
  const auto off_its_place = ground::stage({.offset_x = 0.1}, {5.0, 0.01});
  CHECK(places(*off_its_place, warning).size() > 20);
  CHECK(places(*ground::stage({}, {5.0, 0.01}), warning).empty());
}

TEST_CASE("a number on a label is short, whatever it is") {
  CHECK(pictures::rounded(9.81) == "9.81");
  CHECK(pictures::rounded(0.0) == "0.00");
  CHECK(pictures::rounded(-12.345, 1) == "−12.3");
  CHECK(pictures::rounded(2262557168192917.5) == "2.26·10¹⁵");
  CHECK(pictures::rounded(1.5e-7) == "1.50·10⁻⁷");
  for (double x = 1e-300; x < 1e300; x *= 7.0) {
    INFO(x);
    const std::string text = pictures::rounded(x);
    const auto letters = std::count_if(text.begin(), text.end(), [](char byte) {
      return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;  // each begins with another byte
    });
    CHECK(letters <= 11);  // "1.23·10⁻¹⁰⁰"
    CHECK(std::stod(text) > 0.0);
  }
}

TEST_CASE("without --step a scene that turns faster has a shorter one, the default scene its own") {
  double rate = 1.0;
  app::Chapter chapter;
  chapter.defaults = {.duration = 5.0, .step = 0.005};
  CHECK(app::default_step(chapter, 5.0) == 0.005);
  chapter.fastest = [&] { return rate; };
  for (const auto& [turns, step] :
       {std::pair{0.0, 0.005}, {20.0, 0.005}, {50.0, 0.002}, {1e4, 1e-5}, {1e300, 5e-6}}) {
    rate = turns;
    CHECK(app::default_step(chapter, 5.0) == Approx(step).epsilon(1e-12));
  }
}

TEST_CASE("a stage shows the same at a time however the way there was cut") {
  const auto at_once = slider_crank::stage({}, crank_run), cut = slider_crank::stage({}, crank_run);
  at_once->advance(777);
  for (const long steps : {1, 2, 0, 300, 7, 400, 67}) {
    cut->advance(steps);
    picture(*cut);
  }
  CHECK(cut->time() == at_once->time());
  CHECK(cut->samples().size() == at_once->samples().size());
  CHECK(same(picture(*cut), picture(*at_once)));
  cut->advance(1);
  CHECK_FALSE(same(picture(*cut), picture(*at_once)));
}

TEST_CASE("a stage keeps the last duration of its way, and no more") {
  const auto stage = slider_crank::stage({}, crank_run);
  stage->advance(5000);
  CHECK(stage->samples().front().t == Approx(3.0));
  CHECK(stage->samples().back().t == Approx(5.0));
  CHECK(stage->samples().size() == 1001);
}

TEST_CASE("a run that diverges is remembered up to its end") {
  const auto stage = slider_crank::stage(
      {}, {.duration = 20.0, .step = 0.02, .method = {integrators::Scheme::explicit_euler}});
  CHECK_THROWS_AS(stage->advance(1000), mechanics::Diverged);
  CHECK(stage->samples().back().t == stage->time());
  CHECK(stage->samples().back().errors[0].energy > 1.0);
}

TEST_CASE("with a tolerance a stage comes to any time exactly") {
  const auto stage = slider_crank::stage(
      {}, {.duration = 2.0,
           .step = 0.04,
           .method = {integrators::Scheme::dop853, mechanics::Stabilization::none, 0, 0, 1e-9}});
  for (const double t : {0.1, 0.333, 1.0, 1.01}) {
    stage->advance_to(t);
    CHECK(stage->time() == Approx(t).epsilon(1e-12));
  }
}

TEST_CASE("a stage goes on under another load from where another is, and counts its energy anew") {
  const auto before = slider_crank::stage({}, crank_run);
  before->advance(600);
  const auto after = slider_crank::stage({.torque = 0.0}, {.duration = 2.0, .step = 0.0005});
  after->take_over(*before);
  CHECK(after->time() == before->time());
  CHECK(after->samples().size() == before->samples().size());
  after->advance(4);
  before->advance(2);
  CHECK(after->time() == before->time());
  const draw::Point a = after->samples().back().marks[0], b = before->samples().back().marks[0];
  CHECK(draw::length(a - b) < 1e-5);
  CHECK(draw::length(a - b) > 0.0);  // the torque of 2 N·m is gone
  after->advance(1000);
  CHECK(after->samples().back().errors[0].energy < 1e-5);
}

TEST_CASE("the hand pulls what it holds towards the mouse, and its work is the change of energy") {
  Rod rod({.duration = 2.0, .step = 1e-4});
  const Eigen::Vector2d to(0.8, 0.6);
  take_end(rod, to);
  const double far = (rod.end() - to).norm(), energy = rod.energy();
  double work = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double before = rod.power();
    rod.advance(1);
    work += 0.5e-4 * (before + rod.power());
  }
  CHECK((rod.end() - to).norm() < 0.7 * far);
  CHECK(std::abs(work) > 0.1);
  CHECK(rod.energy() - energy == Approx(work).epsilon(1e-4));
  CHECK(std::isnan(rod.samples().back().errors[0].energy));  // the spring's work is no error
  rod.release();
  rod.advance(1000);
  CHECK(rod.samples().back().errors[0].energy < 1e-6);
}

TEST_CASE(
    "what is seen grows with the scene, but not under a hand: its pointer stays where it is") {
  Rod rod({.duration = 0.5, .step = 0.001}, 0.1);
  take_end(rod, {1.0, 0.0});
  rod.advance_to(1.0);
  CHECK(rod.view().right == 0.1);
  rod.release();
  rod.advance_to(2.0);
  CHECK(rod.view().right > 0.1);
}

TEST_CASE("the hand's spring is as soft as the step needs") {
  for (const double step : {1e-4, 0.01, 0.1, 1.0}) {
    INFO(step);
    Rod rod({.duration = 20.0 * step, .step = step});
    take_end(rod, {0.8, 0.6});
    const double mass = 0.25;  // of a free rod at its end
    CHECK(step * std::sqrt(rod.spring()->k / mass) < 0.5001);
    CHECK(step * rod.spring()->c / mass < 0.5001);
  }
}

TEST_CASE("the hand takes what is near, and nothing where nothing is") {
  Rod rod({.duration = 2.0, .step = 1e-3});
  CHECK_FALSE(rod.grip({480.0, 300.0}));  // not drawn yet
  picture(rod);
  const draw::Point end = rod.on_page(rod.end());
  CHECK(rod.grip(end + draw::Point{0.0, 19.0}));
  rod.release();
  CHECK_FALSE(rod.gripped());
  CHECK_FALSE(rod.grip(end + draw::Point{0.0, 25.0}));
}

TEST_CASE("both beads of chapter 2 feel the hand alike") {
  const RunOptions run{.duration = 20.0, .step = 0.01};
  const Eigen::Vector2d hand(3.0, -2.0);
  const auto pull = [&](const Eigen::Vector2d&, const Eigen::Vector2d&) { return hand; };
  mechanics::Motion<parabola::HeldBead> held(parabola::HeldBead({.x0 = 20.0}, 0.0, 0.0, pull), {});
  const double energy = held.measures().energy;
  const Eigen::Vector2d start = held.q();
  held.advance(300, run.step);
  CHECK(held.measures().energy - energy == Approx(hand.dot(held.q() - start)).epsilon(1e-6));
  CHECK(held.measures().constraint_error < 1e-6);

  // The panels stand side by side: the same pull on the left bead and on the right one.
  const auto left = parametric_lagrangian::stage({.x0 = 20.0}, run);
  const auto right = parametric_lagrangian::stage({.x0 = 20.0}, run);
  picture(*left);
  picture(*right);
  draw::Point bead{0.0, 0.0};
  for (double x = 60.0; x < 480.0 && !left->gripped(); x += 10.0)
    for (double y = 100.0; y < 560.0 && !left->gripped(); y += 10.0)
      if (left->grip({x, y})) bead = {x, y};
  const draw::Point panel{0.5 * (960.0 - 28.0 + 24.0), 0.0}, pulled = bead + draw::Point{80.0, 0.0};
  REQUIRE(left->gripped());
  REQUIRE(right->grip(bead + panel));
  left->pull(pulled);
  right->pull(pulled + panel);
  left->advance(300);
  right->advance(300);
  const auto x_of = [](const Stage& stage, std::size_t i) {
    return stage.samples().back().marks[i].x;
  };
  CHECK(x_of(*left, 0) == Approx(x_of(*right, 1)).epsilon(1e-6));
  CHECK(x_of(*right, 0) == Approx(x_of(*left, 1)).epsilon(1e-6));
  CHECK(std::abs(x_of(*left, 0) - x_of(*left, 1)) > 1.0);
}

TEST_CASE("the player follows the wall clock whatever the frame rate") {
  for (const double frame : {1.0 / 240.0, 1.0 / 60.0, 0.21}) {
    INFO(frame);
    app::Player player;
    long steps = 0;
    double wall = 0.0;
    for (; wall < 3.0; wall += frame)
      player.play(
          frame, 2.0, 0.001, [&](long some) { steps += some; }, [] { return 0.0; });
    CHECK(static_cast<double>(steps) * 0.001 == Approx(2.0 * wall).margin(0.0011));
    CHECK(player.kept() == 1.0);
  }
}

TEST_CASE("the player does not make up for the time in which the program stood still") {
  app::Player player;
  long steps = 0;
  const auto frame = [&](double wall) {
    player.play(
        wall, 2.0, 0.001, [&](long some) { steps += some; }, [] { return 0.0; });
  };
  frame(600.0);
  CHECK(steps == std::lround(2.0 * app::Player::longest / 0.001));
  CHECK(player.kept() < 0.01);
  for (int i = 0; i < 300; ++i) frame(1.0 / 60.0);
  CHECK(player.kept() > 0.95);
}

TEST_CASE("a step longer than a frame is taken when its time has come") {
  app::Player player;
  long steps = 0;
  for (int frame = 0; frame < 60; ++frame)
    player.play(
        1.0 / 60.0, 1.0, 0.25, [&](long some) { steps += some; }, [] { return 0.0; });
  CHECK((steps == 3 || steps == 4));
}

TEST_CASE("the player drops what does not fit into a frame, and tells how much") {
  app::Player player;
  long steps = 0;
  double clock = 0.0;
  for (int frame = 0; frame < 200; ++frame)  // each step takes twice as long as it simulates
    player.play(
        0.02, 1.0, 0.001,
        [&](long some) {
          steps += some;
          clock += 0.002 * static_cast<double>(some);
        },
        [&] { return clock; });
  const double simulated = static_cast<double>(steps) * 0.001;
  CHECK(simulated < 0.45 * 4.0);
  CHECK(simulated > 0.25 * 4.0);
  CHECK(player.kept() == Approx(simulated / 4.0).margin(0.05));
  // A pause does not make it catch up.
  player.rest();
  CHECK(player.kept() == 1.0);
  steps = 0;
  player.play(
      0.005, 1.0, 0.001, [&](long some) { steps += some; }, [] { return 0.0; });
  CHECK((steps == 4 || steps == 5));
}
