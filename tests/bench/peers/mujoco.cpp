#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <map>

#include "engine.hpp"

namespace peers {
namespace {

struct Options {
  mjtIntegrator integrator = mjINT_EULER;
  mjtSolver solver = mjSOL_NEWTON;
  bool exact = false;        ///< the solver goes on down to rounding
  double stiff_steps = 0;    ///< solref's time constant in steps; 0: as it comes
  double stiff_seconds = 0;  ///< the same in seconds; 0: as it comes
};

/// The bodies as a tree of hinges, each placed in the frame of the one before at its start, so that
/// all joint coordinates are 0 there. A rail takes the place of the slider's hinge, which then
/// closes the loop as a constraint: `connect` is the one kind of MuJoCo's that can.
///
/// A long chain comes in files that include each other, since MuJoCo's reader refuses elements
/// nested deeper than 100 in one.
class Xml {
 public:
  explicit Xml(const Model& model) : model_(model) {
    const int tree = model.size() - (model.rail ? 1 : 0);
    constexpr int links_a_file = 50;
    std::string inner;
    for (int first = (tree - 1) / links_a_file * links_a_file; first >= 0; first -= links_a_file) {
      const int last = std::min(tree, first + links_a_file);
      std::string text;
      for (int i = first; i < last; ++i) text += open_body(i);
      text += inner;
      for (int i = first; i < last; ++i) text += "</body>";
      if (first > 0) {
        const std::string name = fmt::format("links_from_{}.xml", first);
        files_.emplace_back(name, "<mujoco>" + text + "</mujoco>");
        inner = fmt::format("<include file=\"{}\"/>", name);
      } else {
        inner = text;
      }
    }
    std::string loop;
    if (model.rail) {
      const Part& slider = model.parts.back();
      inner += fmt::format(
          "<body name=\"{0}\" pos=\"{1:.17g} {2:.17g} 0\"><joint type=\"slide\" axis=\"1 0 0\"/>"
          "{3}</body>",
          tree, slider.x.x(), slider.x.y(), inertial(slider));
      const Vector2d pin = model.pins.back().u2;
      loop = fmt::format(
          "<equality><connect body1=\"{}\" body2=\"{}\" anchor=\"{:.17g} {:.17g} 0\"/></equality>",
          tree - 1, tree, pin.x(), pin.y());
    }
    files_.emplace_back("model.xml", fmt::format("<mujoco><compiler angle=\"radian\"/>"
                                                 "<option gravity=\"0 {:.17g} 0\"/>"
                                                 "<worldbody>{}</worldbody>{}</mujoco>",
                                                 model.gravity, inner, loop));
  }

  /// Throws std::runtime_error with MuJoCo's words.
  mjModel* load() const {
    const auto disk = std::make_unique<mjVFS>();
    mj_defaultVFS(disk.get());
    for (const auto& [name, text] : files_) {
      mj_makeEmptyFileVFS(disk.get(), name.c_str(), static_cast<int>(text.size()));
      std::copy(text.begin(), text.end(),
                static_cast<char*>(disk->filedata[mj_findFileVFS(disk.get(), name.c_str())]));
    }
    std::array<char, 500> error{};
    mjModel* const model =
        mj_loadXML("model.xml", disk.get(), error.data(), static_cast<int>(error.size()));
    mj_deleteVFS(disk.get());
    if (model == nullptr) throw std::runtime_error(error.data());
    return model;
  }

 private:
  static std::string inertial(const Part& part) {
    return fmt::format(
        "<inertial pos=\"0 0 0\" mass=\"{0:.17g}\" diaginertia=\"{1:.17g} {1:.17g} {1:.17g}\"/>",
        part.mass, part.inertia);
  }

  std::string open_body(int i) const {
    const Part& part = model_.parts[static_cast<std::size_t>(i)];
    Vector2d x = part.x;
    double theta = part.theta;
    if (i > 0) {
      const Part& before = model_.parts[static_cast<std::size_t>(i - 1)];
      x = dynamics::rotation(before.theta).transpose() * (part.x - before.x);
      theta -= before.theta;
    }
    const Vector2d u1 = model_.pins[static_cast<std::size_t>(i)].u1;
    return fmt::format(
        "<body name=\"{}\" pos=\"{:.17g} {:.17g} 0\" euler=\"0 0 {:.17g}\">"
        "<joint type=\"hinge\" axis=\"0 0 1\" pos=\"{:.17g} {:.17g} 0\"/>{}",
        i, x.x(), x.y(), theta, u1.x(), u1.y(), inertial(part));
  }

  const Model& model_;
  std::vector<std::pair<std::string, std::string>> files_;
};

using OwnedModel = std::unique_ptr<mjModel, void (*)(mjModel*)>;

/// Compiled once for each scene: for a long chain that takes much longer than a run.
OwnedModel compiled(const Model& model, double step, const Options& options) {
  static std::map<std::pair<int, bool>, OwnedModel> models;
  const auto [found, missing] =
      models.try_emplace({model.size(), model.rail}, nullptr, mj_deleteModel);
  if (missing) found->second.reset(Xml(model).load());
  OwnedModel copy(mj_copyModel(nullptr, found->second.get()), mj_deleteModel);
  mjOption& option = copy->opt;
  option.timestep = step;
  option.integrator = options.integrator;
  option.solver = options.solver;
  if (options.exact) {
    option.iterations = 1000;
    option.tolerance = 1e-15;
  }
  const double stiff =
      options.stiff_seconds > 0 ? options.stiff_seconds : options.stiff_steps * step;
  if (stiff > 0 && copy->neq > 0) {
    copy->eq_solref[0] = stiff;
    copy->eq_solref[1] = 1;                            // damping ratio
    copy->eq_solimp[0] = copy->eq_solimp[1] = 0.9999;  // MuJoCo takes no more
  }
  return copy;
}

class MujocoRun final : public Run {
 public:
  MujocoRun(const Model& model, double step, const Options& options)
      : parts_(model.parts),
        rail_(model.rail),
        steps_(whole_steps(model, step)),
        model_(compiled(model, model.duration / static_cast<double>(steps_), options)),
        data_(mj_makeData(model_.get()), mj_deleteData) {
    data_->qfrc_applied[0] = model.torque;
  }

  void run(double) override {
    for (long i = 0; i < steps_; ++i) mj_step(model_.get(), data_.get());
    for (const mjWarningStat& warning : data_->warning)
      if (warning.number > 0)
        throw std::runtime_error(
            mju_warningText(static_cast<int>(&warning - data_->warning), warning.lastinfo));
  }
  long steps() const override { return steps_; }

  State state() override {
    mj_forward(model_.get(), data_.get());
    State state;
    double theta = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const int body = static_cast<int>(i) + 1;  // 0 is the world
      const bool slider = rail_ && i + 1 == parts_.size();
      if (!slider) theta += data_->qpos[i];
      const double turned = slider ? 0.0 : theta;
      const mjtNum* const x = data_->xipos + 3 * body;
      std::array<mjtNum, 6> v{};
      mj_objectVelocity(model_.get(), data_.get(), mjOBJ_BODY, body, v.data(), 0);
      const double angle = parts_[i].theta + turned;
      state.push_back({{x[0], x[1]}, {v[3], v[4]}, angle, v[2], dynamics::rotation(angle)});
    }
    return state;
  }
  std::vector<std::pair<double, double>> masses() const override {
    std::vector<std::pair<double, double>> masses;
    for (std::size_t i = 1; i <= parts_.size(); ++i)
      masses.emplace_back(model_->body_mass[i], model_->body_inertia[3 * i + 2]);
    return masses;
  }

 private:
  std::vector<Part> parts_;
  bool rail_;
  long steps_;
  OwnedModel model_;
  std::unique_ptr<mjData, void (*)(mjData*)> data_;
};

}  // namespace

Engine mujoco() {
  // Its own words reach the reader as a failed run's; by itself it would print or log to a file.
  mju_user_warning = [](const char*) {};
  mju_user_error = [](const char* message) { throw std::runtime_error(message); };

  Engine engine{"MuJoCo", mj_versionString(), {}};
  const auto add = [&](const std::string& name, double first, bool is_default, bool in_chain,
                       const Options& options) {
    engine.settings.push_back({.name = name,
                               .first = first,
                               .is_default = is_default,
                               .in_chain = in_chain,
                               .start = [=](const Model& model, double step) {
                                 return std::make_unique<MujocoRun>(model, step, options);
                               }});
  };
  add("Euler, Newton", 1.0 / 60, true, true, {});
  add("Euler, Newton", 0.002, true, true, {});
  for (const auto& [name, integrator] :
       {std::pair{"Euler", mjINT_EULER}, {"RK4", mjINT_RK4}, {"implicit", mjINT_IMPLICIT}}) {
    add(fmt::format("{}, Newton", name), 1.0 / 60, false, integrator != mjINT_IMPLICIT,
        {.integrator = integrator});
    add(fmt::format("{}, Newton, solref 2 steps", name), 1.0 / 60, false, false,
        {.integrator = integrator, .exact = true, .stiff_steps = 2});
  }
  for (const auto& [name, solver] : {std::pair{"CG", mjSOL_CG}, {"PGS", mjSOL_PGS}})
    add(fmt::format("RK4, {}, solref 2 steps", name), 1.0 / 60, false, false,
        {.integrator = mjINT_RK4, .solver = solver, .exact = true, .stiff_steps = 2});
  for (const double seconds : {1e-2, 1e-3, 1e-4})
    add(fmt::format("RK4, Newton, solref {:g} s", seconds), std::min(1.0 / 60, seconds / 2), false,
        false, {.integrator = mjINT_RK4, .exact = true, .stiff_seconds = seconds});
  return engine;
}

}  // namespace peers
