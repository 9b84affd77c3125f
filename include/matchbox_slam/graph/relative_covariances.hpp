#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// How well the graph knows where nodes are as seen from one of them: for each of `nodes` the
/// covariance of `reference_from_node` over (x, y, theta) of the reference's frame, first order, at
/// the graph's poses, by all edges of motion and the loops that are inliers. All at once cost
/// hardly more than one (sparse inverse: Takahashi, Fagan and Chen 1973). Throws
/// std::invalid_argument as require_sound does, std::out_of_range for nodes that there are not.
[[nodiscard]] std::vector<Eigen::Matrix3d> relative_covariances(
    const PoseGraph& graph, std::size_t reference, const std::vector<std::size_t>& nodes);

}  // namespace matchbox_slam
