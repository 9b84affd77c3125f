#include "slam/path_uncertainty.hpp"

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

namespace matchbox_slam {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// [m] of the way that an edge stands for. Of one that was condensed it may have led anywhere: it
/// is as long as its drift, by that which is assumed of a map (LoopOptions).
double length_of(const PoseEdge& edge) {
  constexpr double kDriftOfMetre = 4e-4;  // [m^2/m]
  const double length = edge.from_to.translation().norm();
  return edge.kind == EdgeKind::kCondensed
             ? std::max(length, 0.5 * edge.covariance.topLeftCorner<2, 2>().trace() / kDriftOfMetre)
             : length;
}

}  // namespace

/// [m] from the node to each one by the way of the fewest edges, where that is short enough for
/// them to lie together; else infinite.
std::vector<double> PathUncertainty::lengths_within_reach() const {
  constexpr std::size_t kMaxPathEdges = 40;  // edges of the graph
  constexpr double kMaxPathLength = 60.0;    // [m], where key scans are far from one another
  std::vector<double> lengths(poses_.size(), kInfinity);
  std::vector<std::size_t> reached{node_};
  lengths[node_] = 0.0;
  std::size_t begin = 0;
  for (std::size_t edges = 1; edges <= kMaxPathEdges; ++edges) {
    for (const std::size_t end = reached.size(); begin < end; ++begin) {
      const std::size_t from = reached[begin];
      links_->for_each(from, [&](std::size_t edge, std::size_t to) {
        if (is_used((*edges_)[edge]) && lengths[to] == kInfinity) {
          lengths[to] = lengths[from] + length_of((*edges_)[edge]);
          reached.push_back(to);
        }
      });
    }
  }
  for (const std::size_t one : reached) {
    if (lengths[one] > kMaxPathLength) {
      lengths[one] = kInfinity;
    }
  }
  return lengths;
}

/// [m^2]
double PathUncertainty::variance_of(const PoseEdge& edge, const Eigen::Vector2d& here) const {
  const double squared_distance = (poses_[edge.from].translation() - here).squaredNorm();
  return 0.5 * edge.covariance.topLeftCorner<2, 2>().trace() +
         edge.covariance(2, 2) * squared_distance;
}

std::vector<double> PathUncertainty::variances(const std::vector<std::size_t>& nodes,
                                               double enough) const {
  const Eigen::Vector2d here = poses_[node_].translation();
  std::vector<double> least(poses_.size(), kInfinity);
  std::vector<bool> is_open(poses_.size(), false);
  std::size_t open = 0;
  for (const std::size_t node : nodes) {
    open += is_open[node] ? 0 : 1;
    is_open[node] = true;
  }
  using Reached = std::pair<double, std::size_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
  least[node_] = 0.0;
  next.push({0.0, node_});
  while (!next.empty() && open > 0) {
    const auto [variance, from] = next.top();
    next.pop();
    if (variance > least[from]) {
      continue;
    }
    open -= is_open[from] ? 1 : 0;
    is_open[from] = false;
    links_->for_each(from, [&, variance = variance](std::size_t number, std::size_t to) {
      const PoseEdge& edge = (*edges_)[number];
      if (!is_used(edge)) {
        return;
      }
      const double there = variance + variance_of(edge, here);
      if (there < least[to] && there <= enough) {
        least[to] = there;
        next.push({there, to});
      }
    });
  }
  std::vector<double> asked;
  asked.reserve(nodes.size());
  for (const std::size_t node : nodes) {
    asked.push_back(least[node]);
  }
  return asked;
}

std::vector<bool> PathUncertainty::weakly_connected(const std::vector<std::size_t>& nodes,
                                                    double sigma) const {
  const std::vector<double> lengths = lengths_within_reach();
  std::vector<std::size_t> far;
  for (const std::size_t node : nodes) {
    if (lengths[node] == kInfinity) {
      far.push_back(node);
    }
  }
  const std::vector<double> far_variances = variances(far, sigma * sigma);
  auto variance = far_variances.begin();
  std::vector<bool> apart;
  apart.reserve(nodes.size());
  for (const std::size_t node : nodes) {
    apart.push_back(lengths[node] == kInfinity && *variance++ > sigma * sigma);
  }
  return apart;
}

}  // namespace matchbox_slam
