#pragma once

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// Of the variances: a sixty-fourth of the deviation.
constexpr double kLeastDriftShare = 1.0 / 4096.0;

/// How much of the drift that edges assume there is, by how likely it makes the inliers: the share
/// that has the largest marginal likelihood, times a prior. It differs a hundredfold between
/// buildings and lasers; and where too much is assumed, corridors are bent that should have been
/// longer. What is assumed holds until loops speak for less.
/// @param graph  its poses are near to where all that is used fits best.
/// @return the share of its variances, kLeastDriftShare to 1.
[[nodiscard]] double learn_drift(const PoseGraph& graph);

}  // namespace matchbox_slam
