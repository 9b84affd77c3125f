#pragma once

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// Moves all poses but the first to where the edges in use fit best, from where they are: least
/// squares by Ceres, the only file that knows it.
/// @param drift_share  of the drift's variance that there is.
/// @param tolerance    it stops when an iteration lessens the chi-square by less than this share.
/// @return false: they still moved when the iterations were used up.
bool move_to_best_poses(PoseGraph& graph, double drift_share, double tolerance);

}  // namespace matchbox_slam
