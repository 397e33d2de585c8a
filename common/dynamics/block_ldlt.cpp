#include "dynamics/block_ldlt.hpp"

#include <algorithm>
#include <limits>
#include <set>

namespace dynamics {

void BlockLdlt::analyse(const std::vector<int>& size,
                        const std::vector<std::pair<int, int>>& edges) {
  const int n = static_cast<int>(size.size());
  std::vector<std::set<int>> neighbours(size.size());
  for (const auto& [i, j] : edges) {
    neighbours[index(i)].insert(j);
    neighbours[index(j)].insert(i);
  }

  // Eliminate the node of fewest neighbours, join those to each other, and so on. Of equal ones,
  // take the one whose neighbours went longest ago: a chain is eaten from both ends in turn, and
  // the processor works on both at once, since neither waits for the other.
  std::vector<int> order, remaining(size.size()), touched(size.size());
  position_.assign(size.size(), 0);
  for (int i = 0; i < n; ++i) remaining[index(i)] = i;
  while (!remaining.empty()) {
    const auto next = std::min_element(remaining.begin(), remaining.end(), [&](int i, int j) {
      return std::pair(neighbours[index(i)].size(), touched[index(i)]) <
             std::pair(neighbours[index(j)].size(), touched[index(j)]);
    });
    const int i = *next;
    remaining.erase(next);
    position_[index(i)] = static_cast<int>(order.size());
    order.push_back(i);
    for (int j : neighbours[index(i)]) {
      touched[index(j)] = static_cast<int>(order.size());
      neighbours[index(j)].erase(i);
      for (int k : neighbours[index(i)])
        if (k != j) neighbours[index(j)].insert(k);
    }
  }

  // What is left of a node's neighbours are those eliminated after it. Give each block its place.
  std::vector<int> row(size.size());
  for (int i = 1; i < n; ++i) row[index(i)] = row[index(i - 1)] + size[index(i - 1)];
  nodes_.clear();
  below_.clear();
  int length = 0;
  const auto place = [&](int i, int j) {
    return std::exchange(length, length + size[index(i)] * size[index(j)]);
  };
  for (int i : order) {
    Node node{i, size[index(i)], row[index(i)], place(i, i), static_cast<int>(below_.size()), 0};
    for (int j : neighbours[index(i)])
      below_.push_back({j, size[index(j)], row[index(j)], place(j, i)});
    node.below_end = static_cast<int>(below_.size());
    std::sort(below_.begin() + node.below_begin, below_.end(),
              [&](const Below& a, const Below& b) { return after(b.node, a.node); });
    nodes_.push_back(node);
  }
  updates_.clear();
  for (const Node& node : nodes_)
    for (int j = node.below_begin; j < node.below_end; ++j)
      for (int k = node.below_begin; k <= j; ++k)
        updates_.push_back(block(below_[index(j)].node, below_[index(k)].node));
  const int rows = n == 0 ? 0 : row.back() + size.back();
  K_.setZero(length);
  L_.setZero(length);
  diagonal_.setZero(rows);
  inverse_pivot_.setZero(rows);
}

int BlockLdlt::block(int i, int j) const {
  const Node& node = nodes_[index(position_[index(j)])];
  if (i == j) return node.block;
  const auto begin = below_.begin() + node.below_begin, end = below_.begin() + node.below_end;
  return std::find_if(begin, end, [&](const Below& b) { return b.node == i; })->block;
}

void BlockLdlt::factor(double damping) {
  L_ = K_;
  double* const K = L_.data();  // a copy of K, which turns into the factor block by block
  for (const Node& node : nodes_)
    for (int k = 0; k < node.size; ++k) {
      double& K_kk = K[node.block + k * (node.size + 1)];
      diagonal_[node.row + k] = K_kk;
      K_kk *= 1 + damping;
    }

  // The rounding that gathers in a pivot grows with the number of rows.
  const double rounding =
      8 * std::numeric_limits<double>::epsilon() * static_cast<double>(diagonal_.size());
  const int* update = updates_.data();
  for (const Node& node : nodes_) {
    fixed(node.size, [&](auto size) {
      constexpr int r = size;
      // The diagonal block: K_ii = L D L^T, L below the diagonal, D inverted aside.
      double L[r][r], inverse_D[r];
      for (int i = 0; i < r; ++i)
        for (int k = 0; k <= i; ++k) L[i][k] = K[node.block + i + k * r];
#pragma GCC unroll 3  // else g++ makes a loop of it, and the whole factor takes a third longer
      for (int k = 0; k < r; ++k) {
        const bool independent = L[k][k] > rounding * diagonal_[node.row + k];
        inverse_D[k] = independent ? 1 / L[k][k] : 0;
        for (int i = k + 1; i < r; ++i) {
          const double L_ik = L[i][k] * inverse_D[k];
          for (int j = k + 1; j <= i; ++j) L[i][j] -= L_ik * L[j][k];
        }
        for (int i = k + 1; i < r; ++i)
          K[node.block + i + k * r] = L[i][k] = L[i][k] * inverse_D[k];
        inverse_pivot_[node.row + k] = inverse_D[k];
      }

      for (int j = node.below_begin; j < node.below_end; ++j) {
        const Below& a = below_[index(j)];
        fixed(a.size, [&](auto s) {
          // The blocks below it: X L^T = K_ji. Row block j of L is X D^-1; X is what is stored.
          double X[s][r];
          for (int i = 0; i < s; ++i)
            for (int k = 0; k < r; ++k) {
              X[i][k] = K[a.block + i + k * s];
              for (int m = 0; m < k; ++m) X[i][k] -= X[i][m] * L[k][m];
            }
          for (int i = 0; i < s; ++i)
            for (int k = 0; k < r; ++k) {
              K[a.block + i + k * s] = X[i][k];
              X[i][k] *= inverse_D[k];
            }
          // What remains for the others: K_jk -= X_j D^-1 X_k^T.
          for (int k = node.below_begin; k <= j; ++k) {
            const Below& b = below_[index(k)];
            double* const K_jk = K + *update++;
            fixed(b.size, [&](auto t) {
              for (int n = 0; n < t; ++n)
                for (int i = 0; i < s; ++i) {
                  double sum = 0;
                  for (int m = 0; m < r; ++m) sum += X[i][m] * K[b.block + n + m * t];
                  K_jk[i + n * s] -= sum;
                }
            });
          }
        });
      }
    });
  }
}

void BlockLdlt::solve(Eigen::VectorXd& b) const {
  const double* const K = L_.data();
  // L y = b, and y scaled by D^-1 at once, from the first node to the last.
  for (const Node& node : nodes_) {
    fixed(node.size, [&](auto size) {
      constexpr int r = size;
      const ConstBlock<r, r> L(K + node.block);
      double y[r];
      for (int k = 0; k < r; ++k) {
        y[k] = b[node.row + k];
        for (int i = 0; i < k; ++i) y[k] -= L(k, i) * y[i];
      }
      for (int k = 0; k < r; ++k) b[node.row + k] = y[k] *= inverse_pivot_[node.row + k];
      for (int j = node.below_begin; j < node.below_end; ++j) {
        const Below& below = below_[index(j)];
        fixed(below.size, [&](auto s) {
          const ConstBlock<s, r> X(K + below.block);
          for (int i = 0; i < s; ++i) {
            double sum = 0;
            for (int k = 0; k < r; ++k) sum += X(i, k) * y[k];
            b[below.row + i] -= sum;
          }
        });
      }
    });
  }
  // L^T x = D^-1 y, from the last node to the first.
  for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
    fixed(node->size, [&](auto size) {
      constexpr int r = size;
      const ConstBlock<r, r> L(K + node->block);
      double Xt_x[r] = {};
      for (int j = node->below_begin; j < node->below_end; ++j) {
        const Below& below = below_[index(j)];
        fixed(below.size, [&](auto s) {
          const ConstBlock<s, r> X(K + below.block);
          for (int k = 0; k < r; ++k)
            for (int i = 0; i < s; ++i) Xt_x[k] += X(i, k) * b[below.row + i];
        });
      }
      double x[r];
      for (int k = r - 1; k >= 0; --k) {
        x[k] = b[node->row + k] - inverse_pivot_[node->row + k] * Xt_x[k];
        for (int i = k + 1; i < r; ++i) x[k] -= L(i, k) * x[i];
      }
      for (int k = 0; k < r; ++k) b[node->row + k] = x[k];
    });
  }
}

std::size_t BlockLdlt::bytes() const {
  return sizeof(double) *
             index(static_cast<int>(2 * K_.size() + diagonal_.size() + inverse_pivot_.size())) +
         sizeof(Node) * nodes_.size() + sizeof(Below) * below_.size() +
         sizeof(int) * (position_.size() + updates_.size());
}

}  // namespace dynamics
