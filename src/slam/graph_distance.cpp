#include "matchbox_slam/slam/graph_distance.hpp"

#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace matchbox_slam {

namespace {

struct Way {
  std::size_t to;
  double variance;
};
using Ways = std::vector<std::vector<Way>>;

Ways ways_between(const PoseGraph& graph, const Eigen::Vector2d& here) {
  Ways ways(graph.poses.size());
  for (const PoseEdge& edge : graph.edges) {
    if (is_used(edge)) {
      const double squared_distance = (graph.poses[edge.from].translation() - here).squaredNorm();
      const double variance = 0.5 * edge.covariance.topLeftCorner<2, 2>().trace() +
                              edge.covariance(2, 2) * squared_distance;
      ways[edge.from].push_back({edge.to, variance});
      ways[edge.to].push_back({edge.from, variance});
    }
  }
  return ways;
}

std::vector<double> least_variances(const Ways& ways, std::size_t node) {
  std::vector<double> variances(ways.size(), std::numeric_limits<double>::infinity());
  using Reached = std::pair<double, std::size_t>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> next;
  variances[node] = 0.0;
  next.push({0.0, node});
  while (!next.empty()) {
    const auto [variance, from] = next.top();
    next.pop();
    if (variance > variances[from]) {
      continue;
    }
    for (const Way& way : ways[from]) {
      if (const double there = variance + way.variance; there < variances[way.to]) {
        variances[way.to] = there;
        next.push({there, way.to});
      }
    }
  }
  return variances;
}

std::vector<std::size_t> fewest_edges(const Ways& ways, std::size_t node) {
  std::vector<std::size_t> edges(ways.size(), std::numeric_limits<std::size_t>::max());
  std::queue<std::size_t> next;
  edges[node] = 0;
  next.push(node);
  for (; !next.empty(); next.pop()) {
    for (const Way& way : ways[next.front()]) {
      if (edges[way.to] > edges[next.front()] + 1) {
        edges[way.to] = edges[next.front()] + 1;
        next.push(way.to);
      }
    }
  }
  return edges;
}

}  // namespace

GraphWays ways_from(const PoseGraph& graph, std::size_t node) {
  const Ways ways = ways_between(graph, graph.poses[node].translation());
  return {least_variances(ways, node), fewest_edges(ways, node)};
}

std::vector<bool> apart(const GraphWays& ways, double sigma) {
  constexpr std::size_t kTogether = 40;  // edges of the graph
  std::vector<bool> apart(ways.variances.size());
  for (std::size_t i = 0; i < apart.size(); ++i) {
    apart[i] = ways.edges[i] > kTogether && ways.variances[i] > sigma * sigma;
  }
  return apart;
}

}  // namespace matchbox_slam
