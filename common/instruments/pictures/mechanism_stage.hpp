#pragma once

#include <set>
#include <utility>

#include "instruments/pictures/stage.hpp"
#include "mechanics/motion/mechanism.hpp"

namespace pictures {

/// A Mechanism, or a model made of one, on a stage: what chapters 3 to 7 show.
template <class Model = mechanics::Mechanism>
class MechanismStage : public Stage {
 protected:
  using Motion = mechanics::Motion<Model>;

  MechanismStage(const measure::RunOptions& run, Model mechanism)
      : Stage(run), motion(std::move(mechanism), run.method) {
    add(motion, "");
  }

  /// All but the names.
  virtual void draw_things(draw::Canvas& canvas, const Show& show) = 0;
  /// Half the width and height of a thing's box [m]; a particle has none.
  virtual draw::Point half_size(const dynamics::ThingInfo& thing) const = 0;

  Motion motion;

 private:
  void draw_scene(draw::Pen& pen, const draw::Rect& area, const Show& show) override {
    draw::Canvas canvas(pen, area, view());
    open(canvas, show);
    draw_things(canvas, show);
    if (show.names) draw_names(canvas);
  }

  /// The names of the things above them, unless there are too many to be read.
  void draw_names(draw::Canvas& canvas) const {
    const auto& things = motion.model().system.things();
    if (things.size() > 20) return;
    for (const dynamics::ThingInfo& thing : things)
      canvas.label({motion.q()[thing.column], motion.q()[thing.column + 1] - half_size(thing).y},
                   thing.name, canvas.theme().ink, draw::Font::bold, draw::Align::center,
                   {0.0, -18.0});
  }

  std::vector<Outline> outlines() const override {
    std::vector<Outline> all;
    for (const dynamics::ThingInfo& thing : motion.model().system.things()) {
      const double *q = motion.q().data() + thing.column, *v = motion.v().data() + thing.column;
      const draw::Point half = half_size(thing);
      all.push_back({{q[0], q[1]}, {v[0], v[1]}, 0.0, half.x, half.y});
      if (thing.dof == 3) all.back().angle = q[2], all.back().turning = v[2];
    }
    return all;
  }

  /// The force of the spring on a thing; a law of its own, so that only what was touched has one.
  Mass hold(std::size_t held, draw::Point u) override {
    dynamics::System& system = motion.model().system;
    const auto& things = system.things();
    const dynamics::ThingInfo& thing = things[held];
    if (laws_.insert(held).second) {
      if (thing.dof == 3)
        apply(system.thing<dynamics::Body>(thing.name), held);
      else
        apply(system.thing<dynamics::Particle>(thing.name), held);
    }
    const Eigen::VectorXd& W = system.W();
    double all = 0.0, give = W[thing.column];
    for (const dynamics::ThingInfo& each : things) all += 1.0 / W[each.column];
    if (thing.dof == 3) give += W[thing.column + 2] * (u.x * u.x + u.y * u.y);
    return {all, 1.0 / give};
  }

  template <class Thing>
  void apply(dynamics::Handle<Thing> handle, std::size_t held) {
    motion.model().system.apply(handle, [this, held](double, const Thing& thing) {
      const draw::Point u = spring() ? spring()->u : draw::Point{};
      const auto touched = dynamics::point(thing, Eigen::Vector2d(u.x, u.y));
      const draw::Point F =
          spring_force(held, {touched.r.x(), touched.r.y()}, {touched.rdot.x(), touched.rdot.y()});
      return dynamics::Force<Thing>(touched.J.transpose() * Eigen::Vector2d(F.x, F.y));
    });
  }

  std::set<std::size_t> laws_;
};

}  // namespace pictures
