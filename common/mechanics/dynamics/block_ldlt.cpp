#include "mechanics/dynamics/block_ldlt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dynamics {

int BlockLdlt::block(int i, int j) const {
  if (i == j) return nodes_[index(position_[index(j)])].block;
  return below_[index(find_below(i, j))].block;
}

// The blocks below a node's diagonal stand in the order of elimination.
int BlockLdlt::find_below(int i, int j) const {
  const Node& node = nodes_[index(position_[index(j)])];
  const auto begin = below_.begin() + node.below_begin, end = below_.begin() + node.below_end;
  const auto at =
      std::partition_point(begin, end, [&](const Below& b) { return after(i, b.node); });
  return static_cast<int>(at - below_.begin());
}

namespace {

/// Turns A, of which the lower triangle is given, into L of A = L D L^T. A row whose pivot is not
/// above `smallest` of K_kk is set aside: its 1 / D is 0, and so is its column of L. Inlined by
/// force: all else waits for these numbers, and a call would pass them through memory.
template <int r>
[[gnu::always_inline]] inline BlockLdlt::Pivot factor_node(double (&A)[r][r], const double (&K)[r],
                                                           double smallest,
                                                           double (&inverse_D)[r]) {
  constexpr double small = BlockLdlt::small_pivot;
  if constexpr (r == 2) {  // most joints, and most of the time: two divisions at once
    const double a = A[0][0], b = A[1][0], det = a * A[1][1] - b * b;
    if (a > small * K[0] && det > small * K[1] * a) {
      inverse_D[0] = 1 / a;
      inverse_D[1] = a / det;
      A[1][0] = b * inverse_D[0];
      return BlockLdlt::Pivot::sound;
    }
  }
  BlockLdlt::Pivot least = BlockLdlt::Pivot::sound;
  for (int k = 0; k < r; ++k) {
    const bool holds = A[k][k] > smallest * K[k];
    if (!(A[k][k] > small * K[k]))
      least = holds ? std::min(least, BlockLdlt::Pivot::small) : BlockLdlt::Pivot::none;
    inverse_D[k] = holds ? 1 / A[k][k] : 0;
    for (int i = k + 1; i < r; ++i) {
      const double L_ik = A[i][k] * inverse_D[k];
      for (int j = k + 1; j <= i; ++j) A[i][j] -= L_ik * A[j][k];
    }
    for (int i = k + 1; i < r; ++i) A[i][k] *= inverse_D[k];
  }
  return least;
}

}  // namespace

void BlockLdlt::factor(double damping, double smallest) {
  alike(size_, [&](auto all) { factor_blocks<all>(damping, smallest); });
}

// Down a chain that hangs at rest forces fade from joint to joint, by and by to numbers so small
// that a processor takes a hundred times as long over them, and so do all that follow from them.
// What has faded to 1e-140 of all together is let go, in a scene of so many joints that it comes to
// that.
void BlockLdlt::solve(Eigen::VectorXd& b) const {
  const double faded = nodes_.size() < 100 ? 0 : 1e-140 * b.lpNorm<1>();
  alike(size_, [&](auto all) { solve_blocks<all>(b.data(), faded); });
}

template <int all>
void BlockLdlt::factor_blocks(double damping, double smallest) {
  L_ = K_;
  double* const K = L_.data();  // a copy of K, which turns into L block by block
  const Below* const below = below_.data();
  const int* update = updates_.data();
  BlockLdlt::Pivot least = BlockLdlt::Pivot::sound;
  for (const Node& node : nodes_)
    fixed<all>(node.size, [&](auto size) {
      constexpr int r = size;
      double L[r][r], inverse_D[r], diagonal[r];
      for (int i = 0; i < r; ++i)
        for (int k = 0; k <= i; ++k) L[i][k] = K[node.block + i + k * r];
      for (int k = 0; k < r; ++k) {
        const double K_kk = K_[node.block + k * (r + 1)];
        diagonal_[node.row + k] = diagonal[k] = K_kk;
        L[k][k] += damping * K_kk;
      }
      least = std::min(least, factor_node<r>(L, diagonal, smallest, inverse_D));
      for (int k = 0; k < r; ++k) {
        inverse_pivot_[node.row + k] = inverse_D[k];
        for (int i = k + 1; i < r; ++i) K[node.block + i + k * r] = L[i][k];
      }

      for (int j = node.below_begin; j < node.below_end; ++j)
        fixed<all>(below[j].size, [&](auto s) {
          // A block below it: K_ji = X L^T, X = L_ji D. What remains: K_jk -= X L_ki^T.
          Eigen::Matrix<double, s, r> X = ConstBlock<s, r>(K + below[j].block), L_ji;
          for (int k = 0; k < r; ++k) {
            for (int m = 0; m < k; ++m) X.col(k) -= L[k][m] * X.col(m);
            L_ji.col(k) = inverse_D[k] * X.col(k);
          }
          Block<s, r>(K + below[j].block) = L_ji;
          for (int k = node.below_begin; k < j; ++k)
            fixed<all>(below[k].size, [&](auto t) {
              const ConstBlock<t, r> L_ki(K + below[k].block);
              Block<s, t>(K + *update++) -= X.lazyProduct(L_ki.transpose());
            });
          Block<s, s>(K + *update++) -= X.lazyProduct(L_ji.transpose());
        });
    });
  sound_ = least == BlockLdlt::Pivot::sound;
  complete_ = least != BlockLdlt::Pivot::none;
}

template <int all>
void BlockLdlt::solve_blocks(double* x, double faded) const {
  const double* const K = L_.data();
  const Below* const below = below_.data();
  // L y = b, from the first node to the last, and z = D^-1 y.
  for (const Node& node : nodes_)
    fixed<all>(node.size, [&](auto size) {
      constexpr int r = size;
      double y[r];
      for (int k = 0; k < r; ++k) {
        y[k] = x[node.row + k];
        for (int i = 0; i < k; ++i) y[k] -= K[node.block + k + i * r] * y[i];
        if (faded > 0 && std::abs(y[k]) < faded) y[k] = 0;
      }
      for (int j = node.below_begin; j < node.below_end; ++j)
        fixed<all>(below[j].size, [&](auto s) {
          const ConstBlock<s, r> L(K + below[j].block);
          Eigen::Vector<double, s> y_j = ConstBlock<s, 1>(x + below[j].row);
          for (int k = 0; k < r; ++k) y_j -= y[k] * L.col(k);
          Block<s, 1>(x + below[j].row) = y_j;
        });
      for (int k = 0; k < r; ++k) x[node.row + k] = y[k] * inverse_pivot_[node.row + k];
    });
  // L^T x = z, from the last node to the first.
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node)
    fixed<all>(node->size, [&](auto size) {
      constexpr int r = size;
      double z[r];
      for (int k = 0; k < r; ++k) z[k] = x[node->row + k];
      for (int j = node->below_begin; j < node->below_end; ++j)
        fixed<all>(below[j].size, [&](auto s) {
          const double* const L = K + below[j].block;
          for (int k = 0; k < r; ++k)
            for (int i = 0; i < s; ++i) z[k] -= L[i + k * s] * x[below[j].row + i];
        });
      for (int k = r - 1; k >= 0; --k)
        for (int i = k + 1; i < r; ++i) z[k] -= K[node->block + i + k * r] * z[i];
      for (int k = 0; k < r; ++k) x[node->row + k] = faded > 0 && std::abs(z[k]) < faded ? 0 : z[k];
    });
}

std::size_t BlockLdlt::bytes() const {
  return sizeof(double) * index(static_cast<int>(K_.size() + L_.size() + diagonal_.size() +
                                                 inverse_pivot_.size())) +
         sizeof(Node) * nodes_.size() + sizeof(Below) * below_.size() +
         sizeof(int) * (position_.size() + updates_.size());
}

}  // namespace dynamics
