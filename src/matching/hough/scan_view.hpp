#pragma once

#include <Eigen/Core>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/matching/hough/hough_transform.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// The space that a scan saw to be free, by bearing from the laser.
class ScanView {
 public:
  explicit ScanView(const PointScan& scan);

  /// How far within the free space a point of the scan's frame lies, along the beam [m]; not above
  /// 0 where nothing was seen.
  [[nodiscard]] double depth(const Eigen::Vector2d& point) const;

  /// The share of points, by the length of wall that they stand for, that would lie in the space
  /// that the scan saw to be free, 0...1. Cost: the points.
  [[nodiscard]] double contradicted(const HoughPoints& points, const Pose2& here_from_points) const;

 private:
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  std::vector<float> range_;  ///< [m], 0 where there was no beam
};

}  // namespace matchbox_slam
