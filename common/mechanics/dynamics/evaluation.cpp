#include "mechanics/dynamics/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "mechanics/dynamics/entries.hpp"
#include "mechanics/dynamics/system.hpp"

namespace dynamics {

Evaluation::Evaluation(const System& system) : system_(system.identity_.number) { analyse(system); }

// Finds which blocks of J meet in which block of K = J W J^T, and gives everything its storage.
void Evaluation::analyse(const System& system) {
  using JBlock = Layout::JBlock;
  factored_ = solved_ = false;
  revision_ = 0;  // until all is laid out
  layout_ = system.layout_;
  things_ = {};
  const Vector2d nowhere = Vector2d::Zero();  // yet
  std::map<int, std::vector<JBlock>> blocks_of_column;
  for (const JBlock& block : layout_.J_blocks) blocks_of_column[block.column].push_back(block);
  std::vector<int> dofs;
  for (const ThingInfo& thing : layout_.things) {
    dofs.push_back(thing.dof);
    if (thing.dof == 2)
      things_.particles.push_back({{nowhere, nowhere}, thing.column});
    else
      things_.bodies.push_back({{nowhere, nowhere, 0, 0, rotation(0)}, thing.column});
  }
  dof_ = in_common(dofs);

  std::vector<int> sizes;
  for (const JointInfo& joint : layout_.joints) sizes.push_back(joint.r);
  std::vector<std::vector<int>> joints_of_things;
  for (const auto& [column, blocks] : blocks_of_column) {
    std::vector<int>& joints = joints_of_things.emplace_back();
    for (const JBlock& block : blocks) joints.push_back(block.joint);
  }
  try {
    K_.analyse(sizes, joints_of_things);
  } catch (const std::length_error&) {
    const auto& [column, blocks] = *std::max_element(
        blocks_of_column.begin(), blocks_of_column.end(),
        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    throw std::invalid_argument(
        thing_at(layout_.things, column).name + ": the factor of J W J^T would take more than " +
        std::to_string(BlockLdlt::largest / 1'000'000) + " MB; most joints, " +
        std::to_string(blocks.size()) + ", are on this thing");
  }

  largest_W_theta_ = 0;
  for (const ThingInfo& thing : layout_.things)
    largest_W_theta_ =
        std::max(largest_W_theta_, thing.dof == 3 ? layout_.W[thing.column + 2]
                                                  : std::numeric_limits<double>::infinity());

  pairs_.clear();
  for (const auto& [column, blocks] : blocks_of_column)
    for (const JBlock& a : blocks)
      for (const JBlock& b : blocks)
        if (a.joint != b.joint && K_.after(a.joint, b.joint))
          pairs_.push_back({a.r, b.r, a.dof, column, a.J, b.J, K_.block(a.joint, b.joint)});

  for (int i = 0; JointInfo & joint : layout_.joints) joint.at.K = K_.block(i, i), ++i;

  F0_ = system.weights();
  for (VectorXd* x : {&a_, &F_, &q_}) x->setZero(F0_.size());
  for (VectorXd* x :
       {&C_, &C_t_, &size_, &per_size_, &per_root_K_, &b_, &Cdot_, &lambda_, &mu_, &x_})
    x->setZero(layout_.rows);
  J_.setZero(layout_.size_of_J);
  revision_ = system.revision_;
}

// Calls f(block, r, dof) for each block of J, its size as constants.
template <class F>
void Evaluation::for_each_block_of_J(F&& f) const {
  alike(K_.size(), [&](auto all_r) {
    alike(dof_, [&](auto all_dof) {
      for (const Layout::JBlock& block : layout_.J_blocks)
        fixed<all_r>(block.r, [&](auto r) {
          fixed<all_dof>(block.dof, [&](auto dof) { f(block, r, dof); });
        });
    });
  });
}

// y += sign J x
void Evaluation::add_J(double sign, const VectorXd& x, VectorXd& y) const {
  for_each_block_of_J([&](const Layout::JBlock& block, auto r, auto dof) {
    const ConstBlock<r, dof> J(J_.data() + block.J);
    const ConstBlock<dof, 1> x_thing(x.data() + block.column);
    Block<r, 1>(y.data() + block.row) += sign * J.lazyProduct(x_thing);
  });
}

// x += J^T y
void Evaluation::add_Jt(const VectorXd& y, VectorXd& x) const {
  for_each_block_of_J([&](const Layout::JBlock& block, auto r, auto dof) {
    const ConstBlock<r, dof> J(J_.data() + block.J);
    const Eigen::Vector<double, r> y_joint = ConstBlock<r, 1>(y.data() + block.row);
    Block<dof, 1>(x.data() + block.column) += J.transpose().lazyProduct(y_joint);
  });
}

// K = J W J^T, factored: the joints wrote its diagonal blocks, here are those between two joints.
void Evaluation::factor(double damping) {
  double* const K = K_.K().data();
  const double *const J = J_.data(), *const W = layout_.W.data();
  alike(K_.size(), [&](auto all_r) {
    alike(dof_, [&](auto all_dof) {
      for (const Pair& pair : pairs_)
        fixed<all_dof>(pair.dof, [&](auto dof) {
          fixed<all_r>(pair.r_a, [&](auto r_a) {
            fixed<all_r>(pair.r_b, [&](auto r_b) {
              const ConstBlock<r_a, dof> J_a(J + pair.J_a);
              const ConstBlock<r_b, dof> J_b(J + pair.J_b);
              const double* const W_thing = W + pair.column;
              Eigen::Matrix<double, r_a, r_b> K_ab = Block<r_a, r_b>(K + pair.K);
              for (int k = 0; k < dof; ++k) {
                const Eigen::Vector<double, r_a> JW = J_a.col(k) * W_thing[k];
                for (int j = 0; j < r_b; ++j) K_ab.col(j) += JW * J_b(j, k);
              }
              Block<r_a, r_b>(K + pair.K) = K_ab;
            });
          });
        });
    });
  });
  K_.factor(damping);
  factored_ = true;
  weak_.clear();
  kept_ = 0;
  nearly_dependent_ = limit_ = singular_ = false;
  if (damping == 0 && !K_.sound()) find_weak_rows();  // with damping no pivot is small
}

// ---- What is asked of it ----

void Evaluation::refuse() {
  throw std::logic_error("asked of an evaluation, but nothing was evaluated since it was made " +
                         std::string("or lent to project()"));
}

void Evaluation::check(const char* who, JointHandle handle) const {
  if (handle.system != system_)
    throw std::invalid_argument(std::string(who) + ": a handle of another System, or of none");
  checked();
}

VectorXd Evaluation::lambda(JointHandle joint) const {
  check("lambda", joint);
  const JointInfo& j = layout_.joints[std::size_t(joint.index)];
  return lambda_.segment(j.at.row, j.r);
}

Vector3d Evaluation::reaction(JointHandle joint, int column) const {
  check("reaction", joint);
  return reaction_of(lambda_, joint.index, column);
}

Vector3d Evaluation::reaction_of(const VectorXd& rows, int joint, int column) const {
  const std::vector<Layout::JBlock>& blocks = layout_.J_blocks;  // joint by joint
  Vector3d reaction = Vector3d::Zero();
  for (auto b =
           std::partition_point(blocks.begin(), blocks.end(),
                                [&](const Layout::JBlock& block) { return block.joint < joint; });
       b != blocks.end() && b->joint == joint; ++b)
    if (b->column == column)
      reaction.head(b->dof) =
          Eigen::Map<const Eigen::MatrixXd>(J_.data() + b->J, b->r, b->dof).transpose() *
          rows.segment(b->row, b->r);
  return reaction;
}

double Evaluation::constraint_error() const { return largest(C()) + nan_of(a_); }

double Evaluation::velocity_error(const VectorXd& v) const {
  checked();
  if (v.size() != a_.size())
    throw std::invalid_argument("v must have one entry for each coordinate");
  VectorXd Cdot = C_t_;
  add_J(1, v, Cdot);
  return largest(Cdot) + nan_of(a_) + nan_of(v);
}

double Evaluation::distance() const {
  VectorXd mu = C();
  K_.solve(mu);
  double square = C_.dot(mu);
  for (std::size_t i = 0; i < kept_; ++i) square += std::pow(weak_[i].y.dot(C_), 2);
  return std::sqrt(std::max(square, 0.0)) + nan_of(a_);  // max keeps a NaN that comes first
}

// A row that holds points moves them by C over the size of its gradient there, wherever they are on
// their things; one that holds angles alone turns its things by C, each as its inertia lets it.
double Evaluation::opening() const {
  checked();
  // Of each row, |J| in the places, and in the angles; the radius by which these count, times that.
  VectorXd places = VectorXd::Zero(layout_.rows), angles = places, levers = places;
  for (const Layout::JBlock& block : layout_.J_blocks) {
    const Eigen::Map<const Eigen::MatrixXd> J(J_.data() + block.J, block.r, block.dof);
    const double W_I = block.dof == 3 ? layout_.W[block.column + 2] : 0;
    const double lever = block.dof == 3 ? layout_.radius(block.column) : 0;
    for (int k = 0; k < block.r; ++k) {
      const Eigen::Index row = block.row + k;
      places[row] = std::max(places[row], std::hypot(J(k, 0), J(k, 1)));
      const double turns = block.dof == 3 ? W_I * J(k, 2) * J(k, 2) : 0;
      angles[row] += turns;
      levers[row] += turns * lever;
    }
  }
  double opening = 0;
  for (Eigen::Index row = 0; row < C_.size(); ++row) {
    const double per_C = places[row] > 0   ? 1 / places[row]
                         : angles[row] > 0 ? levers[row] / angles[row]
                                           : 0;
    opening = std::max(opening, std::abs(C_[row]) * per_C);
  }
  return opening;
}

Eigen::MatrixXd Evaluation::jacobian() const {
  checked();
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(layout_.rows, a_.size());
  for (const Layout::JBlock& b : layout_.J_blocks)
    J.block(b.row, b.column, b.r, b.dof) =
        Eigen::Map<const Eigen::MatrixXd>(J_.data() + b.J, b.r, b.dof);
  J.array() += nan_of(a_);
  return J;
}

Counts Evaluation::counts() const {
  checked();
  const auto bytes = [](const auto&... x) {
    return (... + (sizeof(x[0]) * static_cast<std::size_t>(x.size())));
  };
  const int coordinates = static_cast<int>(a_.size()), rank = layout_.rows - left_out();
  return {
      .things = static_cast<int>(layout_.things.size()),
      .coordinates = coordinates,
      .rows = layout_.rows,
      .rank = rank,
      .degrees_of_freedom = coordinates - rank,
      .jacobian_blocks = static_cast<int>(layout_.J_blocks.size()),
      .factor_blocks = K_.blocks(),
      .state_bytes = bytes(a_, a_),
      .workspace_bytes = bytes(things_.particles, things_.bodies, layout_.joints, layout_.J_blocks,
                               pairs_, layout_.M, layout_.W, F0_, F_, a_, q_, C_, size_, per_size_,
                               per_root_K_, b_, Cdot_, lambda_, mu_, x_, J_) +
                         K_.bytes()};
}

std::vector<JointRow> Evaluation::dependent_rows() const {
  checked();
  std::vector<JointRow> rows;
  for (const JointInfo& joint : layout_.joints)
    for (int k = 0; k < joint.r; ++k)
      if (independence(joint.at.row + k) == 0) rows.push_back({joint.name, k + 1});
  return rows;
}

RowState Evaluation::row_state(Eigen::Index row) const {
  if (layout_.joints.empty()) throw std::logic_error("a scene without joints has no rows");
  const auto joint = std::find_if(layout_.joints.rbegin(), layout_.joints.rend(),
                                  [&](auto& j) { return j.at.row <= row; });
  const int k = static_cast<int>(row) - joint->at.row;
  return {{joint->name, k + 1}, joint->unit[k], C_[row], independence(row)};
}

RowState Evaluation::worst_row() const {
  checked();
  Eigen::Index worst = 0;
  double largest = 0;
  for (Eigen::Index row = 0; row < C_.size(); ++row) {
    const double square = K_.diagonal()[row] > 0 ? C_[row] * C_[row] / K_.diagonal()[row] : 0;
    if (square > largest) worst = row, largest = square;
  }
  return row_state(worst);
}

RowState Evaluation::weakest_row() const {
  checked();
  Eigen::Index weakest = 0;
  for (Eigen::Index row = 1; row < C_.size(); ++row)
    if (independence(row) < independence(weakest)) weakest = row;
  return row_state(weakest);
}

}  // namespace dynamics
