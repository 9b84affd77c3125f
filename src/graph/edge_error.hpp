#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// By how much poses differ from what an edge says: (x, y, theta) in the frame of `from`.
struct EdgeError {
  Eigen::Vector3d error;
  Eigen::Matrix3d by_from;  ///< derivatives by (x, y, theta) of the pose of `from`
  Eigen::Matrix3d by_to;
};

[[nodiscard]] EdgeError edge_error(const PoseEdge& edge, const Pose2& map_from_from,
                                   const Pose2& map_from_to);

/// At the poses of the graph.
[[nodiscard]] EdgeError edge_error(const PoseGraph& graph, const PoseEdge& edge);

/// Of an error with this covariance.
[[nodiscard]] inline double chi_square(const Eigen::Vector3d& error,
                                       const Eigen::Matrix3d& covariance) {
  return error.dot(covariance.inverse() * error);
}

/// Of an edge, with this share of the variance of its drift.
[[nodiscard]] Eigen::Matrix3d covariance_with_drift(const PoseEdge& edge, double share);

/// A root W of an information: Wᵀ W is the inverse of the covariance.
[[nodiscard]] Eigen::Matrix3d information_root(const Eigen::Matrix3d& covariance);

}  // namespace matchbox_slam
