#include "matchbox_slam/slam/graph_distance.hpp"

#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

namespace matchbox_slam {

namespace {

struct Way {
  std::size_t to;
  double variance;
  double length;  // [m]
};

/// Those of all nodes in one piece, as they are found anew with each key scan: with 24,000 of these
/// a list for each node took two fifths of the mapping's time.
struct Ways {
  std::vector<std::size_t> begin;  ///< of each node's ways among all, and their end
  std::vector<Way> all;

  [[nodiscard]] std::size_t nodes() const { return begin.size() - 1; }
};

Ways ways_between(const PoseGraph& graph, const Eigen::Vector2d& here) {
  Ways ways;
  ways.begin.assign(graph.poses.size() + 1, 0);
  for (const PoseEdge& edge : graph.edges) {
    if (is_used(edge)) {
      ++ways.begin[edge.from + 1];
      ++ways.begin[edge.to + 1];
    }
  }
  std::partial_sum(ways.begin.begin(), ways.begin.end(), ways.begin.begin());
  ways.all.resize(ways.begin.back());
  std::vector<std::size_t> next = ways.begin;
  for (const PoseEdge& edge : graph.edges) {
    if (is_used(edge)) {
      const double squared_distance = (graph.poses[edge.from].translation() - here).squaredNorm();
      const double variance = 0.5 * edge.covariance.topLeftCorner<2, 2>().trace() +
                              edge.covariance(2, 2) * squared_distance;
      const double length = edge.from_to.translation().norm();
      ways.all[next[edge.from]++] = {edge.to, variance, length};
      ways.all[next[edge.to]++] = {edge.from, variance, length};
    }
  }
  return ways;
}

std::vector<double> least_variances(const Ways& ways, std::size_t node) {
  std::vector<double> variances(ways.nodes(), std::numeric_limits<double>::infinity());
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
    for (std::size_t i = ways.begin[from]; i < ways.begin[from + 1]; ++i) {
      const Way& way = ways.all[i];
      if (const double there = variance + way.variance; there < variances[way.to]) {
        variances[way.to] = there;
        next.push({there, way.to});
      }
    }
  }
  return variances;
}

/// Fills in `edges` and `lengths`.
void find_fewest_edges(const Ways& ways, std::size_t node, GraphWays& found) {
  std::queue<std::size_t> next;
  found.edges.assign(ways.nodes(), std::numeric_limits<std::size_t>::max());
  found.lengths.assign(ways.nodes(), std::numeric_limits<double>::infinity());
  found.edges[node] = 0;
  found.lengths[node] = 0.0;
  next.push(node);
  for (; !next.empty(); next.pop()) {
    const std::size_t from = next.front();
    for (std::size_t i = ways.begin[from]; i < ways.begin[from + 1]; ++i) {
      const Way& way = ways.all[i];
      if (found.edges[way.to] > found.edges[from] + 1) {
        found.edges[way.to] = found.edges[from] + 1;
        found.lengths[way.to] = found.lengths[from] + way.length;
        next.push(way.to);
      }
    }
  }
}

}  // namespace

GraphWays ways_from(const PoseGraph& graph, std::size_t node) {
  const Ways ways = ways_between(graph, graph.poses[node].translation());
  GraphWays found;
  found.variances = least_variances(ways, node);
  find_fewest_edges(ways, node, found);
  return found;
}

std::vector<bool> apart(const GraphWays& ways, double sigma) {
  constexpr std::size_t kTogether = 40;   // edges of the graph
  constexpr double kLongTogether = 60.0;  // [m], where key scans are far from one another
  std::vector<bool> apart(ways.variances.size());
  for (std::size_t i = 0; i < apart.size(); ++i) {
    const bool is_far = ways.edges[i] > kTogether || ways.lengths[i] > kLongTogether;
    apart[i] = is_far && ways.variances[i] > sigma * sigma;
  }
  return apart;
}

}  // namespace matchbox_slam
