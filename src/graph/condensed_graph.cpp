#include "graph/condensed_graph.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "graph/adjacency_list.hpp"
#include "graph/joined_nodes.hpp"
#include "graph/relative_motion.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kMostOfNode = 3;  // condensed edges, unless more hold the graph together
constexpr std::size_t kNone = static_cast<std::size_t>(-1);

bool is_loop(const PoseEdge& edge) { return edge.kind == EdgeKind::kLoop; }

std::size_t other_end(const PoseEdge& edge, std::size_t node) {
  return edge.from == node ? edge.to : edge.from;
}

RelativeMotion motion_from(const PoseEdge& edge, std::size_t node) {
  return edge.from == node ? motion_of(edge) : reversed(motion_of(edge));
}

/// [m^2]; the heading as it tells a metre on.
double variance_of(const PoseEdge& edge) { return edge.covariance.trace(); }

/// From the lower to the higher number, as all edges are.
PoseEdge edge_of(std::size_t from, std::size_t to, const RelativeMotion& from_to, EdgeKind kind,
                 LoopVerdict verdict) {
  const RelativeMotion motion = from < to ? from_to : reversed(from_to);
  PoseEdge edge{
      std::min(from, to), std::max(from, to), motion.pose, motion.covariance, kind, verdict};
  edge.drift = drift_apart(motion.drift);
  return edge;
}

void require_kept_ends(const PoseGraph& graph, const std::vector<bool>& is_taken) {
  if (is_taken.size() != graph.poses.size()) {
    throw std::invalid_argument("condensed: told of " + std::to_string(is_taken.size()) +
                                " nodes whether they are taken out of a graph of " +
                                std::to_string(graph.poses.size()));
  }
  if (is_taken.empty() || is_taken.front() || is_taken.back()) {
    throw std::invalid_argument("condensed: the first and the last node stay");
  }
}

class Condenser {
 public:
  Condenser(PoseGraph graph, const std::vector<bool>& is_taken)
      : graph_(std::move(graph)),
        is_taken_(is_taken),
        is_gone_(graph_.edges.size(), false),
        links_(graph_),
        heirs_(graph_.poses.size(), kNone) {}

  CondensedGraph run() {
    for (std::size_t node = 1; node < is_taken_.size(); ++node) {
      if (is_taken_[node]) {
        take_out(node);
      }
    }
    return renumbered();
  }

 private:
  [[nodiscard]] std::vector<std::size_t> edges_at(std::size_t node) const {
    std::vector<std::size_t> edges;
    links_.for_each(node, [&](std::size_t edge, std::size_t /*to*/) {
      if (!is_gone_[edge]) {
        edges.push_back(edge);
      }
    });
    return edges;
  }

  /// An edge between two nodes that is no loop; kNone where there is none.
  [[nodiscard]] std::size_t edge_between(std::size_t a, std::size_t b) const {
    std::size_t found = kNone;
    links_.for_each(a, [&](std::size_t edge, std::size_t to) {
      if (found == kNone && to == b && !is_gone_[edge] && !is_loop(graph_.edges[edge])) {
        found = edge;
      }
    });
    return found;
  }

  void add(const PoseEdge& edge) {
    const std::size_t same = is_loop(edge) ? kNone : edge_between(edge.from, edge.to);
    if (same == kNone) {
      graph_.edges.push_back(edge);
      is_gone_.push_back(false);
      links_.take_new(graph_.poses.size(), graph_.edges);
    } else {
      PoseEdge& kept = graph_.edges[same];
      kept = edge_of(edge.from, edge.to,
                     fused(motion_from(kept, edge.from), motion_from(edge, edge.from)),
                     EdgeKind::kCondensed, LoopVerdict::kUndecided);
    }
  }

  /// Of the edges that are no loops the surest one, rather to a place nearby: its other end is
  /// joined to all others. kNone where there is none.
  [[nodiscard]] std::size_t edge_to_heir(const std::vector<std::size_t>& edges) const {
    constexpr double kVariancePerSquareMetre = 1e-3;  // [m^2] a squared metre: a guess
    std::size_t best = kNone;
    double least = 0.0;
    for (const std::size_t edge : edges) {
      const PoseEdge& one = graph_.edges[edge];
      const double cost =
          variance_of(one) + kVariancePerSquareMetre * one.from_to.translation().squaredNorm();
      if (!is_loop(one) && (best == kNone || cost < least)) {
        best = edge;
        least = cost;
      }
    }
    return best;
  }

  void take_out(std::size_t node) {
    const std::vector<std::size_t> edges = edges_at(node);
    const std::size_t best = edge_to_heir(edges);
    if (best == kNone) {
      throw std::invalid_argument("condensed: no edges of motion join node " +
                                  std::to_string(node) + " to others");
    }
    const std::size_t heir = other_end(graph_.edges[best], node);
    const RelativeMotion from_heir = motion_from(graph_.edges[best], heir);
    heirs_[node] = heir;
    // What all others have in common is shared out among them: the inverse weights add up to one,
    // in which case each may be taken for independent, and the less sure ones bear more of it.
    double sum = 0.0;
    for (const std::size_t edge : edges) {
      const PoseEdge& one = graph_.edges[edge];
      sum += is_used(one) && other_end(one, node) != heir ? 1.0 / std::sqrt(variance_of(one)) : 0.0;
    }
    for (const std::size_t edge : edges) {
      const PoseEdge one = graph_.edges[edge];
      const std::size_t other = other_end(one, node);
      is_gone_[edge] = true;
      if (other != heir) {
        const double weight = is_used(one) ? std::sqrt(variance_of(one)) * sum : 1.0;
        add(edge_of(heir, other, composed(from_heir, motion_from(one, node), weight),
                    is_loop(one) ? EdgeKind::kLoop : EdgeKind::kCondensed, one.verdict));
      }
    }
  }

  /// Of condensed edges those stay, the surest first, that join what is not joined yet, or a node
  /// that has few.
  void sparsify() {
    JoinedNodes joined(graph_.poses.size());
    std::vector<std::pair<double, std::size_t>> ranked;
    for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
      const PoseEdge& edge = graph_.edges[i];
      if (!is_gone_[i] && edge.kind == EdgeKind::kCondensed) {
        ranked.emplace_back(variance_of(edge), i);
      } else if (!is_gone_[i] && edge.kind == EdgeKind::kMotion) {
        static_cast<void>(joined.join(edge.from, edge.to));
      }
    }
    std::sort(ranked.begin(), ranked.end());
    std::vector<std::size_t> kept(graph_.poses.size(), 0);
    for (const auto& [variance, i] : ranked) {
      const PoseEdge& edge = graph_.edges[i];
      const bool is_needed = joined.join(edge.from, edge.to);
      is_gone_[i] = !is_needed && std::min(kept[edge.from], kept[edge.to]) >= kMostOfNode;
      if (!is_gone_[i]) {
        ++kept[edge.from];
        ++kept[edge.to];
      }
    }
  }

  [[nodiscard]] CondensedGraph renumbered() {
    CondensedGraph result;
    result.numbers.resize(is_taken_.size());
    for (std::size_t node = 0; node < is_taken_.size(); ++node) {
      if (!is_taken_[node]) {
        result.numbers[node] = result.graph.poses.size();
        result.graph.poses.push_back(graph_.poses[node]);
      }
    }
    for (std::size_t node = 0; node < is_taken_.size(); ++node) {
      std::size_t heir = node;
      while (is_taken_[heir]) {
        heir = heirs_[heir];
      }
      result.numbers[node] = result.numbers[heir];
    }
    sparsify();
    for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
      if (!is_gone_[i]) {
        PoseEdge edge = graph_.edges[i];
        edge.from = result.numbers[edge.from];
        edge.to = result.numbers[edge.to];
        add_edge(edge, result.graph.edges);
      }
    }
    // The newest last, as they are where none was taken out.
    std::stable_sort(result.graph.edges.begin(), result.graph.edges.end(),
                     [](const PoseEdge& a, const PoseEdge& b) { return a.to < b.to; });
    return result;
  }

  PoseGraph graph_;
  const std::vector<bool>& is_taken_;
  std::vector<bool> is_gone_;  ///< by edge
  AdjacencyList links_;
  std::vector<std::size_t> heirs_;  ///< by node that was taken out
};

}  // namespace

CondensedGraph condensed(PoseGraph graph, const std::vector<bool>& is_taken) {
  require_kept_ends(graph, is_taken);
  return Condenser(std::move(graph), is_taken).run();
}

}  // namespace matchbox_slam
