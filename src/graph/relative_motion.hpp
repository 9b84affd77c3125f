#pragma once

#include <Eigen/Core>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"

namespace matchbox_slam {

/// Where one node is as seen from another one, which is what an edge measures. All covariances are
/// over (x, y, theta) of the first one's frame, and first order.
struct RelativeMotion {
  Pose2 pose;
  Eigen::Matrix3d covariance;
  Eigen::Matrix3d drift;  ///< what of the covariance is the map's drift as it is assumed
};

/// Of an edge, from `from` to `to`.
[[nodiscard]] RelativeMotion motion_of(const PoseEdge& edge);

/// The way back.
[[nodiscard]] RelativeMotion reversed(const RelativeMotion& motion);

/// One motion after another that is independent of it.
/// @param weight  how many times the covariance of the first one counts.
[[nodiscard]] RelativeMotion composed(const RelativeMotion& first, const RelativeMotion& second,
                                      double weight = 1.0);

/// What two independent measurements of the same motion say together.
[[nodiscard]] RelativeMotion fused(const RelativeMotion& a, const RelativeMotion& b);

/// The largest drift along x, y and heading apart that is less than this one, by its covariance:
/// with any share of it the covariance is no less than with that share of the whole drift.
[[nodiscard]] Eigen::Vector3d drift_apart(const Eigen::Matrix3d& drift);

}  // namespace matchbox_slam
