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
/// loops over them cost less when they are unrolled. all: the n of all blocks where they are alike,
/// so that nobody has to look; 0 where they are not.
template <int all = 0, class F>
inline void fixed(int n, F&& f) {
  if constexpr (all != 0) {
    f(std::integral_constant<int, all>());
  } else if (n == 1) {
    f(std::integral_constant<int, 1>());
  } else if (n == 2) {
    f(std::integral_constant<int, 2>());
  } else {
    f(std::integral_constant<int, 3>());
  }
}

/// Calls f with `all`, from 0 to 3, as a compile-time constant, for use in fixed().
template <class F>
inline void alike(int all, F&& f) {
  if (all == 0)
    f(std::integral_constant<int, 0>());
  else
    fixed(all, f);
}

/// The number that all have in common; 0 where they differ or there are none.
inline int in_common(const std::vector<int>& numbers) {
  for (const int n : numbers)
    if (n != numbers.front()) return 0;
  return numbers.empty() ? 0 : numbers.front();
}

/// A block of r rows and c columns that stands somewhere in a flat array.
template <int r, int c>
using Block = Eigen::Map<Eigen::Matrix<double, r, c>>;
template <int r, int c>
using ConstBlock = Eigen::Map<const Eigen::Matrix<double, r, c>>;

class BlockLdlt {
 public:
  /// Finds order, fill and storage. size: the rows of each node, 1 to 3. Node i has the rows from
  /// size[0] + ... + size[i-1] on. cliques: nodes each two of which have a block that is not zero,
  /// as all joints of one thing. Near-linear in the number of blocks and of their updates; n nodes
  /// of one clique have n^2/2 and n^3/6 of these. std::length_error, before anything is stored,
  /// when they would take more than `largest` bytes.
  void analyse(const std::vector<int>& size, const std::vector<std::vector<int>>& cliques);
  static constexpr std::size_t largest = 2'000'000'000;  // so that an int counts all blocks

  /// Whether node i is eliminated after node j.
  bool after(int i, int j) const { return position_[index(i)] > position_[index(j)]; }

  /// Where in K() the block of rows i and columns j begins, column by column; i is j or after j.
  int block(int i, int j) const;

  /// The blocks of K, to be filled in before factor(). The factor is kept apart.
  Eigen::VectorXd& K() { return K_; }

  /// Pivots count as parts of their rows' own diagonal entries. K squares: at the smallest a row
  /// has lost all but a thousandth to those before it, and six of a double's digits. A small one is
  /// worth a look.
  static constexpr double smallest_pivot = 1e-6, small_pivot = 1e-2;
  /// What the least is, as far as it matters.
  enum class Pivot { none, small, sound };

  /// Factors K, its diagonal raised to (1 + damping) times itself. A row whose pivot is not above
  /// the smallest that is allowed, say NaN, depends on those eliminated before it, nearly or
  /// wholly. It is set aside.
  void factor(double damping = 0, double smallest = smallest_pivot);

  /// Overwrites b with the solution of K x = b without the rows set aside, where x is 0.
  void solve(Eigen::VectorXd& b) const;

  /// Whether all pivots are more than small; whether no row is set aside; whether this one is.
  bool sound() const { return sound_; }
  bool complete() const { return complete_; }
  bool set_aside(Eigen::Index row) const { return inverse_pivot_[row] == 0; }

  /// The diagonal of K as it was at the last factor().
  const Eigen::VectorXd& diagonal() const { return diagonal_; }
  /// What the rows before it left of a row's diagonal entry, its pivot, relative to all of it: from
  /// 1 to the smallest, and 0 when it is set aside.
  double independence(Eigen::Index row) const {
    return inverse_pivot_[row] == 0 ? 0 : 1 / (inverse_pivot_[row] * diagonal_[row]);
  }

  /// The size of all nodes; 0 where they differ.
  int size() const { return size_; }
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
  int find_below(int i, int j) const;  // the block of rows i and columns j, in below_
  template <int all>
  void factor_blocks(double damping, double smallest);
  template <int all>
  void solve_blocks(double* x, double faded) const;
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  int size_ = 0;
  bool sound_ = true, complete_ = true;
  std::vector<int> position_;  // of each node in the order of elimination
  std::vector<Node> nodes_;    // in that order
  std::vector<Below> below_;
  std::vector<int> updates_;
  Eigen::VectorXd K_, L_, diagonal_, inverse_pivot_;
};

}  // namespace dynamics
