#include "mechanics/dynamics/block_ldlt.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <set>
#include <stdexcept>

namespace dynamics {

namespace {

/// The graph that is eliminated, as the cliques that it is made of: a joint is in two at most.
/// Eliminating a node joins its cliques to one, and no edge is ever written down.
class Graph {
 public:
  Graph(std::size_t nodes, std::vector<std::vector<int>> cliques)
      : members_(std::move(cliques)), cliques_(nodes), seen_(nodes) {
    for (std::size_t c = 0; c < members_.size(); ++c)
      for (int i : members_[c]) cliques_of(i).push_back(c);
  }

  /// The number of i's neighbours: the rest of its largest clique, which is not walked, and of the
  /// others those that are not in it.
  int degree(int i) {
    if (cliques_of(i).empty()) return 0;
    const std::size_t largest = *std::max_element(
        cliques_of(i).begin(), cliques_of(i).end(),
        [&](std::size_t c, std::size_t d) { return members_[c].size() < members_[d].size(); });
    std::size_t degree = members_[largest].size() - 1;
    look_from(i);
    for (std::size_t c : cliques_of(i)) {
      if (c == largest) continue;
      for (int j : members_[c]) {
        if (!is_new(j)) continue;
        const auto& of_j = cliques_of(j);
        degree += std::find(of_j.begin(), of_j.end(), largest) == of_j.end();
      }
    }
    return static_cast<int>(degree);
  }

  /// Takes i out and returns its neighbours, which are a clique from now on.
  std::vector<int> eliminate(int i) {
    std::vector<int> neighbours;
    look_from(i);
    for (std::size_t c : cliques_of(i))
      for (int j : std::exchange(members_[c], {}))
        if (is_new(j)) neighbours.push_back(j);
    for (int j : neighbours) {
      std::erase_if(cliques_of(j), [&](std::size_t c) { return members_[c].empty(); });
      cliques_of(j).push_back(members_.size());
    }
    return members_.emplace_back(std::move(neighbours));
  }

 private:
  std::vector<std::size_t>& cliques_of(int i) { return cliques_[static_cast<std::size_t>(i)]; }
  void look_from(int i) {
    ++look_;
    is_new(i);
  }
  bool is_new(int i) { return std::exchange(seen_[static_cast<std::size_t>(i)], look_) != look_; }

  std::vector<std::vector<int>> members_;          // of each clique
  std::vector<std::vector<std::size_t>> cliques_;  // of each node
  std::vector<std::size_t> seen_;
  std::size_t look_ = 0;
};

}  // namespace

void BlockLdlt::analyse(const std::vector<int>& size,
                        const std::vector<std::vector<int>>& cliques) {
  // What the blocks below a node's diagonal and their updates will need.
  std::size_t updates = 0, bytes = 0;
  const auto count = [&](std::size_t below, int rows) {
    updates += below * (below + 1) / 2;
    bytes += below * sizeof(Below) + 2 * (below + 1) * index(rows * rows) * sizeof(double);
    if (bytes + updates * sizeof(int) > largest)
      throw std::length_error("the factor of so many blocks is too large");
  };

  // Eliminate the node of fewest neighbours, join those to each other, and so on. Of equal ones,
  // take the one whose neighbours went longest ago: a chain is eaten from both ends in turn, and
  // the processor works on both at once, since neither waits for the other.
  using Key = std::array<int, 3>;  // number of neighbours, when one of them went last, node
  Graph graph(size.size(), cliques);
  std::vector<std::vector<int>> neighbours(size.size());
  std::vector<int> order;
  std::vector<Key> key(size.size());
  std::set<Key> remaining;
  for (int i = 0; i < static_cast<int>(size.size()); ++i)
    remaining.insert(key[index(i)] = {graph.degree(i), 0, i});
  while (!remaining.empty() && (*remaining.begin())[0] + 1 < static_cast<int>(remaining.size())) {
    const int i = (*remaining.begin())[2];
    remaining.erase(remaining.begin());
    order.push_back(i);
    neighbours[index(i)] = graph.eliminate(i);
    count(neighbours[index(i)].size(), size[index(i)]);
    for (int j : neighbours[index(i)]) {
      remaining.erase(key[index(j)]);
      key[index(j)] = {graph.degree(j), static_cast<int>(order.size()), j};
      remaining.insert(key[index(j)]);
    }
  }
  // All that remain are neighbours of each other, and stay so: after the first go the others as
  // they stand.
  if (!remaining.empty()) {
    const int first = (*remaining.begin())[2];
    std::vector<int> others;
    for (const Key& k : remaining)
      if (k[2] != first) others.push_back(k[2]);
    std::sort(others.begin(), others.end());
    others.insert(others.begin(), first);
    for (std::size_t i = 0; i < others.size(); ++i)
      count(others.size() - i - 1, size[index(others[i])]);
    for (auto i = others.begin(); i != others.end(); ++i) {
      order.push_back(*i);
      neighbours[index(*i)].assign(i + 1, others.end());
    }
  }
  size_ = in_common(size);
  position_.resize(size.size());
  for (std::size_t k = 0; k < order.size(); ++k) position_[index(order[k])] = static_cast<int>(k);

  // A node's neighbours at that time are those eliminated after it. Give each block its place.
  std::vector<int> row(size.size());
  int rows = 0, length = 0;
  for (std::size_t i = 0; i < size.size(); ++i) row[i] = std::exchange(rows, rows + size[i]);
  nodes_.clear();
  below_.clear();
  const auto place = [&](int i, int j) {
    return std::exchange(length, length + size[index(i)] * size[index(j)]);
  };
  for (int i : order) {
    std::vector<int>& beside = neighbours[index(i)];
    std::sort(beside.begin(), beside.end(),
              [&](int j, int k) { return position_[index(j)] < position_[index(k)]; });
    Node node{i, size[index(i)], row[index(i)], place(i, i), static_cast<int>(below_.size()), 0};
    for (int j : beside) below_.push_back({j, size[index(j)], row[index(j)], place(j, i)});
    node.below_end = static_cast<int>(below_.size());
    nodes_.push_back(node);
    neighbours[index(i)] = {};
  }
  // The blocks (j, k) that a node updates, for each j those of k up to j itself. Those of one k
  // follow each other below k, often without a gap.
  updates_.clear();
  updates_.reserve(updates);
  std::vector<int> next;  // for each k, in below_
  for (const Node& node : nodes_) {
    next.clear();
    for (int j = node.below_begin; j < node.below_end; ++j) {
      const int node_j = below_[index(j)].node;
      for (int k = node.below_begin; k < j; ++k) {
        int& at = next[index(k - node.below_begin)];
        if (below_[index(at)].node != node_j) at = find_below(node_j, below_[index(k)].node);
        updates_.push_back(below_[index(at++)].block);
      }
      const Node& diagonal = nodes_[index(position_[index(node_j)])];
      updates_.push_back(diagonal.block);
      next.push_back(diagonal.below_begin);
    }
  }
  K_.setZero(length);
  L_.setZero(length);
  diagonal_.setZero(rows);
  inverse_pivot_.setZero(rows);
}

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

void BlockLdlt::solve(Eigen::VectorXd& b) const {
  alike(size_, [&](auto all) { solve_blocks<all>(b.data()); });
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
void BlockLdlt::solve_blocks(double* x) const {
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
      for (int k = 0; k < r; ++k) x[node->row + k] = z[k];
    });
}

std::size_t BlockLdlt::bytes() const {
  return sizeof(double) * index(static_cast<int>(K_.size() + L_.size() + diagonal_.size() +
                                                 inverse_pivot_.size())) +
         sizeof(Node) * nodes_.size() + sizeof(Below) * below_.size() +
         sizeof(int) * (position_.size() + updates_.size());
}

}  // namespace dynamics
