// The order in which BlockLdlt eliminates, and the storage of its blocks. Set-up: it happens once.
#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>

#include "mechanics/dynamics/block_ldlt.hpp"

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

}  // namespace dynamics
