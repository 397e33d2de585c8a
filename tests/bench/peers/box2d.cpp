#include <box2d/box2d.h>
#include <fmt/format.h>

#include "engine.hpp"

namespace peers {
namespace {

b2Vec2 vec(const Vector2d& u) { return {static_cast<float>(u.x()), static_cast<float>(u.y())}; }

class Box2dRun final : public Run {
 public:
  Box2dRun(const Model& model, double step, int velocity_iterations, int position_iterations)
      : world_({0.0F, static_cast<float>(model.gravity)}),
        torque_(static_cast<float>(model.torque)),
        steps_(whole_steps(model, step)),
        step_(static_cast<float>(model.duration / static_cast<double>(steps_))),
        velocity_iterations_(velocity_iterations),
        position_iterations_(position_iterations) {
    world_.SetAllowSleeping(false);
    b2BodyDef fixed;
    b2Body* const ground = world_.CreateBody(&fixed);
    b2Body* before = ground;
    for (std::size_t i = 0; i < model.parts.size(); ++i) {
      const Part& part = model.parts[i];
      b2BodyDef def;
      def.type = b2_dynamicBody;
      def.position = vec(part.x);
      def.angle = static_cast<float>(part.theta);
      b2Body* const body = world_.CreateBody(&def);
      const b2MassData mass{
          static_cast<float>(part.mass), {0.0F, 0.0F}, static_cast<float>(part.inertia)};
      body->SetMassData(&mass);
      b2RevoluteJointDef pin;
      pin.bodyA = before;
      pin.bodyB = body;
      pin.localAnchorA = vec(model.pins[i].u2);
      pin.localAnchorB = vec(model.pins[i].u1);
      world_.CreateJoint(&pin);
      bodies_.push_back(body);
      before = body;
    }
    if (model.rail) {
      b2PrismaticJointDef rail;
      rail.bodyA = ground;
      rail.bodyB = before;
      rail.localAxisA = {1.0F, 0.0F};
      world_.CreateJoint(&rail);
    }
  }

  void run(double) override {
    for (long i = 0; i < steps_; ++i) {
      bodies_[0]->ApplyTorque(torque_, true);  // a step clears it
      world_.Step(step_, velocity_iterations_, position_iterations_);
    }
  }
  long steps() const override { return steps_; }

  State state() override {
    State state;
    for (const b2Body* body : bodies_) {
      const b2Vec2 x = body->GetWorldCenter(), v = body->GetLinearVelocity();
      const double theta = body->GetAngle();
      state.push_back(
          {{x.x, x.y}, {v.x, v.y}, theta, body->GetAngularVelocity(), dynamics::rotation(theta)});
    }
    return state;
  }
  std::vector<std::pair<double, double>> masses() const override {
    std::vector<std::pair<double, double>> masses;
    for (const b2Body* body : bodies_) masses.emplace_back(body->GetMass(), body->GetInertia());
    return masses;
  }

 private:
  b2World world_;
  std::vector<b2Body*> bodies_;
  float torque_;
  long steps_;
  float step_;
  int velocity_iterations_, position_iterations_;
};

}  // namespace

Engine box2d() {
  std::string version = PEERS_BOX2D_VERSION;
  if (version.empty())
    version = fmt::format("{}.{}.{}", b2_version.major, b2_version.minor, b2_version.revision);
  Engine engine{"Box2D", version, {}};
  const auto add = [&](int velocity, int position, bool is_default, bool in_chain) {
    engine.settings.push_back({.name = fmt::format("{}/{} iterations", velocity, position),
                               .first = 1.0 / 60,
                               .is_default = is_default,
                               .in_chain = in_chain,
                               .start = [=](const Model& model, double step) {
                                 return std::make_unique<Box2dRun>(model, step, velocity, position);
                               }});
  };
  add(8, 3, true, true);
  add(8, 3, false, true);
  add(20, 10, false, false);
  add(50, 20, false, true);
  add(100, 50, false, false);
  add(500, 200, false, false);
  add(2000, 1000, false, false);
  return engine;
}

}  // namespace peers
