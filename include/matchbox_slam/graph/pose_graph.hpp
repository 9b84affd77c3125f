#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

enum class EdgeKind {
  kMotion,     ///< to the next key scan, or one that is known to lie near; no outlier
  kLoop,       ///< a place seen again; may be wrong
  kCondensed,  ///< what key scans that were taken out said of others; no outlier
};

/// Whether a loop agrees with the motion and with the other loops.
enum class LoopVerdict { kUndecided, kInlier, kOutlier };

/// Where one key scan was taken as seen from another one.
struct PoseEdge {
  std::size_t from = 0;
  std::size_t to = 0;
  Pose2 from_to;               ///< measured pose of `to` in the frame of `from`
  Eigen::Matrix3d covariance;  ///< of `from_to` over (x, y, theta) of the frame of `from`
  EdgeKind kind = EdgeKind::kMotion;
  LoopVerdict verdict = LoopVerdict::kUndecided;  ///< of loops only
  /// What of the covariance's diagonal is the map's drift as it is assumed; loops tell how much of
  /// it there is.
  Eigen::Vector3d drift = Eigen::Vector3d::Zero();
};

/// Where all key scans were taken, and what says so, to be looked at or optimised. The first pose
/// is where the map begins and does not move. Edges that are no loops join all nodes; where nothing
/// is known of a motion, as between two drives, its covariance is wide.
struct PoseGraph {
  std::vector<Pose2> poses;  ///< `map_from_base` by number of key scan
  std::vector<PoseEdge> edges;
};

/// Appends an edge. Memory grows by an eighth: doubled, it would hold a long drive's edges twice.
void add_edge(const PoseEdge& edge, std::vector<PoseEdge>& edges);

/// What optimising changes of a graph. Kept to take it back, it is a tenth of the graph.
struct GraphState {
  std::vector<Pose2> poses;
  std::vector<LoopVerdict> verdicts;  ///< by edge
};

[[nodiscard]] GraphState state_of(const PoseGraph& graph);

/// Of a graph that has the same edges as the one whose state it was.
void set_state(GraphState state, PoseGraph& graph);

/// Whether the edge has a say in where the poses are.
[[nodiscard]] inline bool is_used(const PoseEdge& edge) {
  return edge.kind != EdgeKind::kLoop || edge.verdict == LoopVerdict::kInlier;
}

/// Throws std::invalid_argument, naming the node or the edge, for a graph without poses, poses and
/// measurements that are not finite, covariances that are not symmetric and positive definite,
/// drifts that are no part of them, edges to nodes that there are not or from a node to itself, and
/// for nodes that no edges of motion join to the first one.
void require_sound(const PoseGraph& graph);

}  // namespace matchbox_slam
