// Compiled as C++17: Simbody's headers do not compile as C++20.

#include <Simbody.h>
#include <fmt/format.h>

#include "engine.hpp"

namespace peers {
namespace {

using SimTK::Inertia;
using SimTK::MobilizedBody;
using SimTK::Real;
using SimTK::Transform;
using SimTK::Vec3;

Vec3 vec(const Vector2d& u) { return {u.x(), u.y(), 0}; }

using MakeIntegrator = std::function<std::unique_ptr<SimTK::Integrator>(const SimTK::System&)>;

template <class Integrator, auto... options>
std::unique_ptr<SimTK::Integrator> make(const SimTK::System& system) {
  return std::make_unique<Integrator>(system, options...);
}

struct Options {
  double constraint_tolerance;  ///< as a multiple of the accuracy; 0: a tenth, as it comes
  bool as_it_comes;             ///< the accuracy too
};

/// Minimal coordinates: a tree of pins. A rail takes the place of the slider's pin, which then
/// closes the loop by two constraints.
class SimbodyRun final : public Run {
 public:
  SimbodyRun(const Model& model, const MakeIntegrator& make_integrator, double accuracy,
             const Options& options)
      : model_(model), matter_(system_), forces_(system_) {
    SimTK::Force::UniformGravity(forces_, matter_, Vec3(0, model.gravity, 0));
    for (std::size_t i = 0; i < model.parts.size(); ++i) {
      const Part& part = model.parts[i];
      const SimTK::Body::Rigid body(
          SimTK::MassProperties(part.mass, Vec3(0), Inertia(part.inertia)));
      MobilizedBody before = i == 0 ? MobilizedBody(matter_.updGround()) : bodies_.back();
      const Vec3 u1 = vec(model.pins[i].u1), u2 = vec(model.pins[i].u2);
      if (model.rail && i + 1 == model.parts.size()) {
        MobilizedBody::Slider slider(matter_.updGround(), Transform(), body, Transform());
        for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(0, 1, 0)})
          SimTK::Constraint::PointInPlane(slider, SimTK::UnitVec3(normal), dot(normal, u1), before,
                                          u2);
        bodies_.push_back(slider);
      } else {
        bodies_.push_back(MobilizedBody::Pin(before, Transform(u2), body, Transform(u1)));
      }
    }
    if (model.torque != 0)
      SimTK::Force::MobilityConstantForce(forces_, bodies_[0], 0, model.torque);

    SimTK::State state = system_.realizeTopology();
    double before = 0;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const bool slider = model.rail && i + 1 == bodies_.size();
      bodies_[i].setOneQ(state, 0, slider ? model.parts[i].x.x() : model.parts[i].theta - before);
      before = model.parts[i].theta;
    }
    integrator_ = make_integrator(system_);
    if (!options.as_it_comes) integrator_->setAccuracy(accuracy);
    if (options.constraint_tolerance > 0)
      integrator_->setConstraintTolerance(options.constraint_tolerance * accuracy);
    integrator_->setReturnEveryInternalStep(true);
    integrator_->setFinalTime(model.duration);
    integrator_->initialize(state);
  }

  void run(double allowed) override {
    const double started = measure::cpu_seconds();
    for (long i = 0; integrator_->getTime() < model_.duration; ++i) {
      integrator_->stepTo(model_.duration);
      if (i % 16 == 0) check_time(started, allowed, integrator_->getTime());
    }
  }
  long steps() const override { return integrator_->getNumStepsTaken(); }

  State state() override {
    const SimTK::State& now = integrator_->getState();
    system_.realize(now, SimTK::Stage::Velocity);
    State state;
    double angle = 0;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const bool slider = model_.rail && i + 1 == bodies_.size();
      angle = slider ? model_.parts[i].theta : angle + bodies_[i].getOneQ(now, 0);
      const Vec3 x = bodies_[i].getBodyOriginLocation(now),
                 v = bodies_[i].getBodyOriginVelocity(now);
      state.push_back({{x[0], x[1]},
                       {v[0], v[1]},
                       angle,
                       bodies_[i].getBodyAngularVelocity(now)[2],
                       dynamics::rotation(angle)});
    }
    return state;
  }
  std::vector<std::pair<double, double>> masses() const override {
    std::vector<std::pair<double, double>> masses;
    for (const MobilizedBody& body : bodies_) {
      const SimTK::MassProperties& mass = body.getBody().getDefaultRigidBodyMassProperties();
      masses.emplace_back(mass.getMass(), mass.calcInertia().getMoments()[2]);
    }
    return masses;
  }

 private:
  Model model_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  std::vector<MobilizedBody> bodies_;
  std::unique_ptr<SimTK::Integrator> integrator_;
};

}  // namespace

Engine simbody() {
  int major = 0, minor = 0, build = 0;
  SimTK_version_simbody(&major, &minor, &build);
  Engine engine{"Simbody", fmt::format("{}.{}.{}", major, minor, build), {}};
  const auto add = [&](const std::string& name, const MakeIntegrator& integrator,
                       double tolerance = 0, bool in_chain = false, bool as_it_comes = false) {
    const Options options{tolerance, as_it_comes};
    const auto start = [=](const Model& model, double accuracy) {
      return std::make_unique<SimbodyRun>(model, integrator, accuracy, options);
    };
    engine.settings.push_back({name, Rung::accuracy, 1e-3, as_it_comes, in_chain, start});
  };
  const MakeIntegrator merson = make<SimTK::RungeKuttaMersonIntegrator>;
  add("RungeKuttaMerson", merson, 0, true, true);
  add("RungeKuttaMerson", merson, 0, true);
  add("RungeKuttaMerson, constraint tolerance = accuracy", merson, 1);
  add("RungeKuttaMerson, constraint tolerance = accuracy/1000", merson, 1e-3);
  add("RungeKuttaFeldberg", make<SimTK::RungeKuttaFeldbergIntegrator>);
  add("RungeKutta3", make<SimTK::RungeKutta3Integrator>);
  add("Verlet", make<SimTK::VerletIntegrator>);
  using SimTK::CPodes;
  using SimTK::CPodesIntegrator;
  // Not with Adams: its functional iteration ends in NaN on the slider-crank at every accuracy, and
  // with Newton's a single call may take minutes, which cannot be cut short; nor in a chain.
  add("CPodes, BDF, Newton", make<CPodesIntegrator, CPodes::BDF, CPodes::Newton>);
  return engine;
}

}  // namespace peers
