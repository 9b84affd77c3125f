#include "slam/path_uncertainty.hpp"

#include <algorithm>
#include <functional>
#include <queue>
#include <utility>

#include "common/append.hpp"

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

/// [m] from a node to each one by the way of the fewest edges, where that is short enough for them
/// to lie together; else infinite.
std::vector<double> lengths_within_reach(const PoseGraph& graph, const AdjacencyList& links,
                                         std::size_t node) {
  constexpr std::size_t kTogether = 40;   // edges of the graph
  constexpr double kLongTogether = 60.0;  // [m], where key scans are far from one another
  std::vector<double> lengths(graph.poses.size(), kInfinity);
  std::vector<std::size_t> reached{node};
  lengths[node] = 0.0;
  std::size_t begin = 0;
  for (std::size_t edges = 1; edges <= kTogether; ++edges) {
    for (const std::size_t end = reached.size(); begin < end; ++begin) {
      const std::size_t from = reached[begin];
      links.for_each(from, [&](std::size_t edge, std::size_t to) {
        if (is_used(graph.edges[edge]) && lengths[to] == kInfinity) {
          lengths[to] = lengths[from] + length_of(graph.edges[edge]);
          reached.push_back(to);
        }
      });
    }
  }
  for (const std::size_t one : reached) {
    if (lengths[one] > kLongTogether) {
      lengths[one] = kInfinity;
    }
  }
  return lengths;
}

/// [m^2]
double variance_of(const PoseEdge& edge, const PoseGraph& graph, const Eigen::Vector2d& here) {
  const double squared_distance = (graph.poses[edge.from].translation() - here).squaredNorm();
  return 0.5 * edge.covariance.topLeftCorner<2, 2>().trace() +
         edge.covariance(2, 2) * squared_distance;
}

}  // namespace

void AdjacencyList::take_new(const PoseGraph& graph) {
  first_.resize(graph.poses.size(), kNone);
  last_.resize(graph.poses.size(), kNone);
  for (std::size_t edge = ends_.size() / 2; edge < graph.edges.size(); ++edge) {
    for (const std::size_t node : {graph.edges[edge].from, graph.edges[edge].to}) {
      const auto end = static_cast<Number>(ends_.size());
      (first_[node] == kNone ? first_[node] : ends_[last_[node]].next) = end;
      last_[node] = end;
      append_sparingly({static_cast<Number>(node), kNone}, ends_);
    }
  }
}

std::vector<double> PathUncertainty::variances(const std::vector<std::size_t>& nodes,
                                               double enough) const {
  const Eigen::Vector2d here = graph_->poses[node_].translation();
  std::vector<double> least(graph_->poses.size(), kInfinity);
  std::vector<bool> is_open(graph_->poses.size(), false);
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
      const PoseEdge& edge = graph_->edges[number];
      if (!is_used(edge)) {
        return;
      }
      const double there = variance + variance_of(edge, *graph_, here);
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
  const std::vector<double> lengths = lengths_within_reach(*graph_, *links_, node_);
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
