#include <chipmunk/chipmunk.h>
#include <fmt/format.h>

#include "engine.hpp"

namespace peers {
namespace {

cpVect vec(const Vector2d& u) { return cpv(u.x(), u.y()); }

struct Options {
  int iterations;
  double error_bias;  ///< what is left of a constraint's error after a second; negative: default
};

class ChipmunkRun final : public Run {
 public:
  ChipmunkRun(const Model& model, double step, const Options& options)
      : space_(cpSpaceNew(), cpSpaceFree),
        torque_(model.torque),
        steps_(whole_steps(model, step)),
        step_(model.duration / static_cast<double>(steps_)) {
    cpSpaceSetIterations(space_.get(), options.iterations);
    cpSpaceSetGravity(space_.get(), cpv(0, model.gravity));
    cpBody* const ground = cpSpaceGetStaticBody(space_.get());
    cpBody* before = ground;
    for (std::size_t i = 0; i < model.parts.size(); ++i) {
      const Part& part = model.parts[i];
      cpBody* const body = cpBodyNew(part.mass, part.inertia);
      bodies_.emplace_back(body, cpBodyFree);
      cpSpaceAddBody(space_.get(), body);
      cpBodySetPosition(body, vec(part.x));
      cpBodySetAngle(body, part.theta);
      add(cpPivotJointNew2(before, body, vec(model.pins[i].u2), vec(model.pins[i].u1)), options);
      before = body;
    }
    if (model.rail) {
      constexpr double far = 100.0;  // the rail's ends [m]
      add(cpGrooveJointNew(ground, before, cpv(-far, 0), cpv(far, 0), cpvzero), options);
      add(cpGearJointNew(ground, before, 0, 1), options);
    }
  }
  ~ChipmunkRun() override {
    for (const auto& joint : joints_) cpSpaceRemoveConstraint(space_.get(), joint.get());
    for (const auto& body : bodies_) cpSpaceRemoveBody(space_.get(), body.get());
  }
  ChipmunkRun(const ChipmunkRun&) = delete;
  ChipmunkRun& operator=(const ChipmunkRun&) = delete;

  void run(double) override {
    for (long i = 0; i < steps_; ++i) {
      cpBodySetTorque(bodies_[0].get(), torque_);  // a step clears it
      cpSpaceStep(space_.get(), step_);
    }
  }
  long steps() const override { return steps_; }

  State state() override {
    State state;
    for (const auto& body : bodies_) {
      const cpVect x = cpBodyGetPosition(body.get()), v = cpBodyGetVelocity(body.get());
      const double theta = cpBodyGetAngle(body.get());
      state.push_back({{x.x, x.y},
                       {v.x, v.y},
                       theta,
                       cpBodyGetAngularVelocity(body.get()),
                       dynamics::rotation(theta)});
    }
    return state;
  }
  std::vector<std::pair<double, double>> masses() const override {
    std::vector<std::pair<double, double>> masses;
    for (const auto& body : bodies_)
      masses.emplace_back(cpBodyGetMass(body.get()), cpBodyGetMoment(body.get()));
    return masses;
  }

 private:
  void add(cpConstraint* joint, const Options& options) {
    joints_.emplace_back(joint, cpConstraintFree);
    cpSpaceAddConstraint(space_.get(), joint);
    if (options.error_bias >= 0) cpConstraintSetErrorBias(joint, options.error_bias);
  }

  template <class T>
  using Owner = std::unique_ptr<T, void (*)(T*)>;

  Owner<cpSpace> space_;
  std::vector<Owner<cpBody>> bodies_;
  std::vector<Owner<cpConstraint>> joints_;
  double torque_;
  long steps_;
  double step_;
};

}  // namespace

Engine chipmunk() {
  Engine engine{"Chipmunk", cpVersionString, {}};
  const auto add = [&](const std::string& name, const Options& options, bool is_default,
                       bool in_chain) {
    engine.settings.push_back({.name = name,
                               .first = 1.0 / 60,
                               .is_default = is_default,
                               .in_chain = in_chain,
                               .start = [=](const Model& model, double step) {
                                 return std::make_unique<ChipmunkRun>(model, step, options);
                               }});
  };
  add("10 iterations", {10, -1}, true, true);
  // The collision bias has nothing to act on here: nothing collides.
  for (const int iterations : {10, 30, 100, 1000})
    for (const auto& [words, bias] :
         {std::pair{"", -1.0}, {", error bias 0", 0.0}, {", error bias 1", 1.0}})
      add(fmt::format("{} iterations{}", iterations, words), {iterations, bias}, false,
          bias < 0 && iterations <= 100 && iterations != 30);
  return engine;
}

}  // namespace peers
