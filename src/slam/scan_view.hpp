#pragma once

#include <Eigen/Core>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// How far a scan saw in each direction: tells of any place whether the scan looked at it.
class ScanView {
 public:
  ScanView(const PointScan& scan, const Pose2& map_from_base);

  enum class Look {
    kNone,     ///< it did not look there, or not so far
    kHit,      ///< something is there
    kThrough,  ///< it saw what lies behind: nothing is there
    kBlocked,  ///< something stands before it
  };
  [[nodiscard]] Look at(const Eigen::Vector2d& place) const;

 private:
  struct Reach {
    float nearest;  ///< [m]
    float farthest;
  };

  Pose2 map_from_laser_;  ///< at the first beam
  std::vector<Reach> reaches_;
};

}  // namespace matchbox_slam
