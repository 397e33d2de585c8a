#include "model.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "05_revolute/exact.hpp"
#include "07_slider_crank/exact.hpp"

namespace peers {
namespace {

std::size_t index(int i) { return static_cast<std::size_t>(i); }

Vector2d free_end(const Model& model, const State& state) {
  return state.back().x + state.back().A * -model.pins.back().u1;  // a rod is pinned at its start
}

}  // namespace

Model slider_crank() {
  const ::slider_crank::Scene scene;
  const double theta = scene.theta0, phi = scene.rod_angle(theta), half = scene.rod / 2;
  const Vector2d crank_pin = dynamics::rotation(theta) * Vector2d(scene.crank, 0);
  const Vector2d rod_centre = crank_pin + dynamics::rotation(phi) * Vector2d(half, 0);
  return {.parts = {{scene.wheel_mass, scene.wheel_inertia(), Vector2d::Zero(), theta},
                    {scene.rod_mass, scene.rod_inertia(), rod_centre, phi},
                    {scene.slider_mass, scene.slider_inertia(), {scene.slider_x(theta), 0}, 0}},
          .pins = {{Vector2d::Zero(), Vector2d::Zero()},
                   {{-half, 0}, {scene.crank, 0}},
                   {Vector2d::Zero(), {half, 0}}},
          .rail = true,
          .torque = scene.torque,
          .gravity = scene.gravity,
          .duration = 2.0};
}

Model chain(int links) {
  const revolute::Scene scene{.links = links};
  const Vector2d begin(-scene.l() / 2, 0), end(scene.l() / 2, 0);
  Model model{.gravity = scene.gravity, .duration = 0.5};
  for (int i = 0; i < links; ++i) {
    model.parts.push_back({scene.m(), scene.I(), {(i + 0.5) * scene.l(), 0}, 0});
    model.pins.push_back({begin, i == 0 ? Vector2d::Zero() : end});
  }
  return model;
}

State start(const Model& model) {
  State state;
  for (const Part& part : model.parts)
    state.push_back({part.x, Vector2d::Zero(), part.theta, 0, dynamics::rotation(part.theta)});
  return state;
}

double joint_gap(const Model& model, const State& state) {
  double gap = model.rail ? std::abs(state.back().x.y()) : 0.0;
  Vector2d x = Vector2d::Zero();
  dynamics::Matrix2d A = dynamics::Matrix2d::Identity();
  for (int i = 0; i < model.size(); ++i) {
    const auto& [u1, u2] = model.pins[index(i)];
    const dynamics::Body& body = state[index(i)];
    gap = std::max(gap, (body.x + body.A * u1 - x - A * u2).norm());
    x = body.x;
    A = body.A;
  }
  return gap;
}

double kinetic_energy(const Model& model, const State& state) {
  double energy = 0;
  for (std::size_t i = 0; i < state.size(); ++i)
    energy += (model.parts[i].mass * state[i].v.squaredNorm() +
               model.parts[i].inertia * state[i].omega * state[i].omega) /
              2;
  return energy;
}

double energy_balance(const Model& model, const State& state) {
  double energy = kinetic_energy(model, state);
  for (std::size_t i = 0; i < state.size(); ++i)
    energy -= model.parts[i].mass * model.gravity * state[i].x.y();
  return energy - model.torque * (state[0].theta - model.parts[0].theta);
}

std::optional<double> error(const Model& model, const State& state) {
  if (model.rail) {
    static const long double theta = ::slider_crank::Exact({}).at(model.duration)->theta;
    return static_cast<double>(std::abs(state[0].theta - theta));
  }
  const int links = model.size();
  if (links > revolute::longest_with_exact_answer) return std::nullopt;
  static std::map<int, Vector2d> ends;
  if (!ends.contains(links)) {
    const revolute::Scene scene{.links = links};
    ends[links] = links == 1 ? revolute::exact_pendulum(scene, model.duration).end
                             : revolute::ChainReference(scene).exact(model.duration)->end;
  }
  return (free_end(model, state) - ends[links]).norm();
}

}  // namespace peers
