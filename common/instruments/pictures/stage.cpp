#include "instruments/pictures/stage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "instruments/draw/page.hpp"
#include "instruments/measure/run.hpp"

namespace pictures {
namespace {

constexpr double samples_kept = 1000.0;
constexpr double reach = 20.0;  // of the mouse, in points

draw::Point turned(draw::Point p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x - s * p.y, s * p.x + c * p.y};
}

}  // namespace

Stage::Stage(measure::RunOptions run)
    : run_(std::move(run)),
      stride_(std::max(1L, std::lround(run_.duration / samples_kept / run_.step))) {}

void Stage::add(mechanics::Simulation& simulation, std::string name) {
  simulations_.push_back({&simulation, nullptr, 0.0});
  names_.push_back(std::move(name));
}

void Stage::begin(const draw::View& view) {
  view_ = view;
  count_from_here();
  remember();
}

void Stage::count_from_here() {
  since_count_ = 0;
  for (Watched& watched : simulations_) {
    watched.watch = std::make_unique<mechanics::Watch>(*watched.simulation);
    watched.balance = watched.simulation->measures().balance();
  }
}

void Stage::advance(long steps) {
  constexpr long unwatched = 20;  // steps that a run which diverges may go on unseen
  while (steps > 0) {
    const long some = std::min({steps, until_next_, unwatched});
    advance_all(some, run_.step);
    steps -= some;
    until_next_ -= some;
    if (until_next_ == 0) remember();
  }
}

void Stage::advance_to(double t) {
  const double steps = std::max(0.0, (t - time()) / run_.step);
  if (run_.method.tolerance == 0.0) return advance(std::lround(steps));
  advance(static_cast<long>(steps));
  if (const double rest = t - time(); rest > 1e-9 * run_.step) advance_all(1, rest);
}

void Stage::advance_all(long steps, double h) {
  since_count_ += steps;
  try {
    for (Watched& watched : simulations_)
      measure::run(*watched.simulation, {steps, h, steps}, *watched.watch);
  } catch (const mechanics::Diverged&) {
    const auto finite = [](const Watched& one) { return one.simulation->measures().finite(); };
    if (std::all_of(simulations_.begin(), simulations_.end(), finite)) remember();
    throw;
  }
}

void Stage::remember() {
  Sample sample{time(), marks(), {}, force()};
  for (std::size_t i = 0; i < simulations_.size(); ++i) sample.errors.push_back(errors_now(i));
  // In large strides, since axes that move with every step cannot be read.
  const double width = view_.right - view_.left, height = view_.bottom - view_.top;
  for (const draw::Point& mark : sample.marks) {
    if (!(std::abs(mark.x) < 1e15 && std::abs(mark.y) < 1e15)) continue;
    if (spring_) continue;  // it would move the place to which a pointer at rest pulls
    if (mark.x < view_.left) view_.left = mark.x - 0.25 * width;
    if (mark.x > view_.right) view_.right = mark.x + 0.25 * width;
    if (mark.y < view_.top) view_.top = mark.y - 0.25 * height;
    if (mark.y > view_.bottom) view_.bottom = mark.y + 0.25 * height;
  }
  samples_.push_back(std::move(sample));
  while (samples_.front().t < time() - run_.duration) samples_.pop_front();
  until_next_ = stride_;
}

Stage::Errors Stage::errors_now(std::size_t simulation) const {
  const Watched& watched = simulations_[simulation];
  const mechanics::Measures now = watched.simulation->measures();
  return {spring_ ? std::numeric_limits<double>::quiet_NaN()
                  : std::abs(now.balance() - watched.balance),
          now.constraint_error};
}

mechanics::Verdict Stage::verdict() const {
  mechanics::Verdict verdict;
  if (spring_) return verdict;
  for (const Watched& watched : simulations_)
    for (const auto& fault : watched.watch->verdict().faults)
      if (std::none_of(verdict.faults.begin(), verdict.faults.end(),
                       [&](const auto& other) { return other.what == fault.what; }))
        verdict.faults.push_back(fault);
  return verdict;
}

void Stage::show_as(const Stage& other) {
  const draw::View& view = other.view_;
  view_ = {std::min(view_.left, view.left), std::min(view_.top, view.top),
           std::max(view_.right, view.right), std::max(view_.bottom, view.bottom)};
  for (const Sample& sample : other.samples_) shown_force_ = std::max(shown_force_, sample.force);
}

double Stage::largest_force() {
  double largest = std::max(shown_force_, force());
  for (const Sample& sample : samples_) largest = std::max(largest, sample.force);
  return largest > 0.0 ? largest : 1.0;
}

void Stage::take_over(const Stage& before) {
  for (std::size_t i = 0; i < simulations_.size(); ++i)
    simulations_[i].simulation->take_over(*before.simulations_[i].simulation);
  samples_ = before.samples_;
  view_ = before.view_;
  undisturbed_ = false;
  count_from_here();
  until_next_ = stride_;
}

void Stage::draw(draw::Pen& pen, const draw::Rect& area, const Show& show) {
  lenses_.clear();
  draw_scene(pen, area, show);
  if (!spring_) return;
  pen.clip(area);
  draw_spring(pen);
  pen.unclip();
}

void Stage::draw_spring(draw::Pen& pen) const {
  const Outline thing = outlines()[spring_->thing];
  const draw::Point arm = turned(spring_->u, thing.angle), r = thing.center + arm,
                    rdot = thing.velocity + thing.turning * draw::Point{-arm.y, arm.x};
  const draw::Lens& lens = lenses_[spring_->canvas];
  const draw::Point from = lens.to_page(r), to = lens.to_page(spring_->to);
  const draw::Color color = pen.theme().applied_force;
  pen.line(from, to, color, 1.6, draw::Dash::dashed);
  pen.circle(from, 3.0, color);
  const std::string pull =
      fmt::format("pull {} N", rounded(draw::length(spring_force(spring_->thing, r, rdot))));
  const bool left = to.x > lens.area.center().x;  // where there is room
  pen.text(to + draw::Point{left ? -14.0 : 14.0, -14.0}, pull, color, draw::Font::text,
           left ? draw::Align::right : draw::Align::left, true);
}

void Stage::open(draw::Canvas& canvas, const Show& show) {
  if (show.numbers) canvas.axes("m");
  lenses_.push_back(canvas.lens());
}

std::vector<draw::Point> Stage::trail(std::size_t mark) const {
  std::vector<draw::Point> points;
  points.reserve(samples_.size() + 1);
  for (const Sample& sample : samples_) points.push_back(sample.marks[mark]);
  points.push_back(marks()[mark]);
  return points;
}

bool Stage::grip(draw::Point pointer) {
  double nearest = reach;
  std::optional<Spring> found;
  const std::vector<Outline> things = outlines();
  for (std::size_t i = 0; i < things.size(); ++i) {
    const Outline& thing = things[i];
    if (thing.canvas >= lenses_.size()) continue;  // not drawn yet
    const draw::Lens& lens = lenses_[thing.canvas];
    if (!lens.area.contains(pointer)) continue;
    const draw::Point p = turned(lens.to_world(pointer) - thing.center, -thing.angle);
    const draw::Point u{std::clamp(p.x, -thing.half_width, thing.half_width),
                        std::clamp(p.y, -thing.half_height, thing.half_height)};
    const double distance = lens.scale * draw::length(p - u);
    if (!(distance < nearest)) continue;
    nearest = distance;
    found = Spring{.thing = i, .u = u, .to = {}, .canvas = thing.canvas};
  }
  if (!found) return false;
  // As hard as the whole scene's mass asks for a swing of a fraction of the time that is shown, but
  // never so hard that the spring would bring the step to its limit.
  const Mass mass = hold(found->thing, found->u);
  const double rate = 20.0 / run_.duration, limit = 0.5 / run_.step;
  found->k = std::min(mass.all * rate * rate, mass.at_point * limit * limit);
  found->c = std::min(mass.all * rate, mass.at_point * limit);
  spring_ = found;
  undisturbed_ = false;
  pull(pointer);
  return true;
}

draw::Point Stage::spring_force(std::size_t thing, draw::Point r, draw::Point rdot) const {
  if (!spring_ || spring_->thing != thing) return {};
  return spring_->k * (spring_->to - r) - spring_->c * rdot;
}

void Stage::pull(draw::Point pointer) {
  if (spring_) spring_->to = lenses_[spring_->canvas].to_world(pointer);
}

void Stage::release() {
  if (!spring_) return;
  spring_.reset();
  count_from_here();
}

void draw_page(draw::Pen& pen, Stage& stage, const Show& show) {
  std::string caption = stage.caption();
  if (const auto verdict = stage.verdict(); show.verdict && !verdict.right())
    caption += fmt::format(" Far from right: {}.", verdict.words());
  else if (!show.else_say.empty())
    caption.append(" ").append(show.else_say);
  std::string title = stage.title();
  if (!pen.shows_caption()) title += fmt::format(", t = {:.3f} s", stage.time());
  stage.draw(pen, draw::page(pen, title, caption), show);
}

Picture beside(std::string name, std::string title, std::unique_ptr<Stage> left,
               std::string left_name, std::unique_ptr<Stage> right, std::string right_name,
               double t, std::string caption, const Show& show) {
  for (Stage* stage : {left.get(), right.get()}) {
    try {
      stage->advance_to(t);
    } catch (const mechanics::Diverged&) {  // it is shown where it had to stop
    }
  }
  left->show_as(*right);
  right->show_as(*left);
  const std::array<std::shared_ptr<Stage>, 2> stages{std::move(left), std::move(right)};
  const std::array names{std::move(left_name), std::move(right_name)};
  return {std::move(name), [=](draw::Pen& pen) {
            const draw::Rect content = draw::page(pen, title, caption);
            const double line = draw::Pen::line_height(draw::Font::bold), gap = 20.0;
            const double width = 0.5 * (content.width - gap);
            for (std::size_t i = 0; i < 2; ++i) {
              const double x = content.left + static_cast<double>(i) * (width + gap);
              pen.text({x, content.top + 0.5 * line}, names[i],
                       i == 0 ? pen.theme().warning : pen.theme().ink, draw::Font::bold);
              stages[i]->draw(pen, {x, content.top + line, width, content.height - line}, show);
            }
          }};
}

Picture picture_at(std::unique_ptr<Stage> stage, double t, const Show& show) {
  stage->advance_to(t);
  return {fmt::format("at_{}s", t), [stage = std::shared_ptr<Stage>(std::move(stage)),
                                     show](draw::Pen& pen) { draw_page(pen, *stage, show); }};
}

}  // namespace pictures
