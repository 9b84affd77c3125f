#pragma once

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// Moves all poses but the first to where the edges in use fit best, from where they are: least
/// squares by Ceres, the only file that knows it.
/// @param tolerance    it stops when an iteration lessens the chi-square by less than this share.
/// @param drift_share  of the drift's variance that there is.
void move_to_best_poses(PoseGraph& graph, double tolerance, double drift_share = 1.0);

}  // namespace matchbox_slam
