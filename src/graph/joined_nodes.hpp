#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace matchbox_slam {

/// Which nodes edges join, directly or not (union-find, Tarjan 1975).
class JoinedNodes {
 public:
  explicit JoinedNodes(std::size_t nodes) : parents_(nodes) {
    std::iota(parents_.begin(), parents_.end(), std::size_t{0});
  }

  /// Returns whether they were not joined yet.
  bool join(std::size_t a, std::size_t b) {
    const std::size_t root_a = root_of(a);
    const std::size_t root_b = root_of(b);
    parents_[root_a] = root_b;
    return root_a != root_b;
  }

  [[nodiscard]] bool are_joined(std::size_t a, std::size_t b) { return root_of(a) == root_of(b); }

 private:
  std::size_t root_of(std::size_t node) {
    while (parents_[node] != node) {
      node = parents_[node] = parents_[parents_[node]];
    }
    return node;
  }

  std::vector<std::size_t> parents_;
};

}  // namespace matchbox_slam
