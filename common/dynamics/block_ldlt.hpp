// The factorisation K = L D L^T of a symmetric positive semidefinite matrix of small blocks, which
// stores and touches only the blocks that are not zero. Here K = J W J^T: a node is a joint, its
// size the joint's rows, and an edge says that two joints share a thing.
//
// Eliminating a joint couples all joints that were still connected to it. Which blocks fill in
// depends on the order alone, so order and fill are found once, before the first number. Nodes of
// few neighbours go first; a chain, however long, then has no fill at all.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <type_traits>
#include <utility>
#include <vector>

namespace dynamics {

/// Calls f with n, which is 1, 2 or 3, as a compile-time constant: the blocks are so small that
/// loops over them cost less when they are unrolled.
template <class F>
inline void fixed(int n, F&& f) {
  switch (n) {
    case 1:
      return f(std::integral_constant<int, 1>());
    case 2:
      return f(std::integral_constant<int, 2>());
    default:
      return f(std::integral_constant<int, 3>());
  }
}

/// A block of r rows and c columns that stands somewhere in a flat array.
template <int r, int c>
using Block = Eigen::Map<Eigen::Matrix<double, r, c>>;
template <int r, int c>
using ConstBlock = Eigen::Map<const Eigen::Matrix<double, r, c>>;

class BlockLdlt {
 public:
  /// Finds order, fill and storage. size: the rows of each node, 1 to 3. Node i has the rows from
  /// size[0] + ... + size[i-1] on. edges: the pairs of nodes whose block is not zero.
  void analyse(const std::vector<int>& size, const std::vector<std::pair<int, int>>& edges);

  /// Whether node i is eliminated after node j.
  bool after(int i, int j) const { return position_[index(i)] > position_[index(j)]; }

  /// Where in K() the block of rows i and columns j begins, column by column; i is j or after j.
  int block(int i, int j) const;

  /// The blocks of K, to be filled in before factor(). The factor is kept apart.
  Eigen::VectorXd& K() { return K_; }

  /// Factors K, its diagonal raised to (1 + damping) times itself.
  ///
  /// A row whose pivot has fallen to rounding, relative to the row's own diagonal entry, depends on
  /// the rows eliminated before it. It is left out and its unknown is 0: of redundant rows, the
  /// one that is eliminated last gets none of the load. NaN counts as dependent.
  void factor(double damping = 0);

  /// Overwrites b with the solution of K x = b. Rows found dependent are not looked at.
  void solve(Eigen::VectorXd& b) const;

  /// For each row, 1 / pivot, or 0 where the row depends on others.
  const Eigen::VectorXd& inverse_pivots() const { return inverse_pivot_; }
  /// The diagonal of K as it was at the last factor().
  const Eigen::VectorXd& diagonal() const { return diagonal_; }

  int rank() const { return static_cast<int>((inverse_pivot_.array() != 0).count()); }
  int blocks() const { return static_cast<int>(nodes_.size() + below_.size()); }
  std::size_t bytes() const;

 private:
  struct Node {
    int node, size, row, block;  // block: where the diagonal block begins
    int below_begin, below_end;  // its blocks below the diagonal, in below_
  };
  struct Below {
    int node, size, row, block;
  };
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  std::vector<int> position_;  // of each node in the order of elimination
  std::vector<Node> nodes_;    // in that order
  std::vector<Below> below_;
  std::vector<int> updates_;
  Eigen::VectorXd K_, L_, diagonal_, inverse_pivot_;
};

}  // namespace dynamics
