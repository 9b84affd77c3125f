#include "graph/condensed_graph.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

#include "graph/relative_motion.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kMostOfNode = 3;  // edges that do not join it to the next node
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
                 Belief belief) {
  const RelativeMotion motion = from < to ? from_to : reversed(from_to);
  PoseEdge edge{std::min(from, to), std::max(from, to), motion.pose, motion.covariance, kind,
                belief};
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
        edges_of_(graph_.poses.size()),
        heirs_(graph_.poses.size(), kNone) {
    for (std::size_t edge = 0; edge < graph_.edges.size(); ++edge) {
      note(edge);
    }
  }

  CondensedGraph run() {
    std::size_t before = 0;
    for (std::size_t node = 1; node < is_taken_.size(); ++node) {
      if (is_taken_[node]) {
        take_out(node, before);
      } else {
        before = node;
      }
    }
    return renumbered();
  }

 private:
  void note(std::size_t edge) {
    edges_of_[graph_.edges[edge].from].push_back(edge);
    edges_of_[graph_.edges[edge].to].push_back(edge);
  }

  [[nodiscard]] std::vector<std::size_t> edges_at(std::size_t node) const {
    std::vector<std::size_t> edges;
    std::copy_if(edges_of_[node].begin(), edges_of_[node].end(), std::back_inserter(edges),
                 [this](std::size_t edge) { return !is_gone_[edge]; });
    return edges;
  }

  /// An edge between two nodes that is no loop; kNone where there is none.
  [[nodiscard]] std::size_t edge_between(std::size_t a, std::size_t b) const {
    for (const std::size_t edge : edges_of_[a]) {
      const PoseEdge& one = graph_.edges[edge];
      if (!is_gone_[edge] && !is_loop(one) && other_end(one, a) == b) {
        return edge;
      }
    }
    return kNone;
  }

  void add(const PoseEdge& edge) {
    const std::size_t same = is_loop(edge) ? kNone : edge_between(edge.from, edge.to);
    if (same == kNone) {
      graph_.edges.push_back(edge);
      is_gone_.push_back(false);
      note(graph_.edges.size() - 1);
    } else {
      PoseEdge& kept = graph_.edges[same];
      kept = edge_of(edge.from, edge.to,
                     fused(motion_from(kept, edge.from), motion_from(edge, edge.from)),
                     EdgeKind::kCondensed, Belief::kUndecided);
    }
  }

  /// Of those to a node before or after it the surest one: its other end is joined to all others.
  [[nodiscard]] std::size_t surest(const std::vector<std::size_t>& edges, std::size_t node,
                                   std::size_t before) const {
    std::size_t best = kNone;
    bool is_best_next = false;
    for (const std::size_t edge : edges) {
      const PoseEdge& one = graph_.edges[edge];
      if (is_loop(one)) {
        continue;
      }
      const std::size_t other = other_end(one, node);
      const bool is_next = other == before || other == node + 1;
      if (best == kNone || (is_next && !is_best_next) ||
          (is_next == is_best_next && variance_of(one) < variance_of(graph_.edges[best]))) {
        best = edge;
        is_best_next = is_next;
      }
    }
    return best;
  }

  /// @param before  node before it that is left.
  void take_out(std::size_t node, std::size_t before) {
    const std::vector<std::size_t> edges = edges_at(node);
    const std::size_t best = surest(edges, node, before);
    if (best == kNone) {
      throw std::invalid_argument("condensed: no edges of motion join node " +
                                  std::to_string(node) + " to others");
    }
    const std::size_t heir = other_end(graph_.edges[best], node);
    const RelativeMotion from_heir = motion_from(graph_.edges[best], heir);
    heirs_[node] = heir;
    const auto used = std::count_if(edges.begin(), edges.end(), [this](std::size_t edge) {
      return is_used(graph_.edges[edge]);
    });
    const double others = std::max(1.0, static_cast<double>(used - 1));
    for (const std::size_t edge : edges) {
      const PoseEdge one = graph_.edges[edge];
      const std::size_t other = other_end(one, node);
      is_gone_[edge] = true;
      if (other != heir) {
        add(edge_of(heir, other, composed(from_heir, motion_from(one, node), others),
                    is_loop(one) ? EdgeKind::kLoop : EdgeKind::kCondensed, one.belief));
      }
    }
  }

  /// Edges of condensed nodes that are more than a node needs: the least sure ones go.
  void sparsify(const std::vector<std::size_t>& numbers) {
    std::vector<std::pair<double, std::size_t>> ranked;
    for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
      const PoseEdge& edge = graph_.edges[i];
      const bool is_to_next = !is_gone_[i] && numbers[edge.to] == numbers[edge.from] + 1;
      if (!is_gone_[i] && edge.kind == EdgeKind::kCondensed && !is_to_next) {
        ranked.emplace_back(variance_of(edge), i);
      }
    }
    std::sort(ranked.begin(), ranked.end());
    std::vector<std::size_t> kept(graph_.poses.size(), 0);
    for (const auto& [variance, i] : ranked) {
      const PoseEdge& edge = graph_.edges[i];
      is_gone_[i] = std::min(kept[edge.from], kept[edge.to]) >= kMostOfNode;
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
    sparsify(result.numbers);
    for (std::size_t i = 0; i < graph_.edges.size(); ++i) {
      if (!is_gone_[i]) {
        PoseEdge edge = graph_.edges[i];
        edge.from = result.numbers[edge.from];
        edge.to = result.numbers[edge.to];
        add_edge(edge, result.graph);
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
  std::vector<std::vector<std::size_t>> edges_of_;
  std::vector<std::size_t> heirs_;  ///< by node that was taken out
};

}  // namespace

CondensedGraph condensed(PoseGraph graph, const std::vector<bool>& is_taken) {
  require_kept_ends(graph, is_taken);
  return Condenser(std::move(graph), is_taken).run();
}

}  // namespace matchbox_slam
