#pragma once

#include <map>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/further_lasers.hpp"

namespace matchbox_slam {

/// A scan of the leading laser, and what others saw since its last one, by laser.
class SeenScans {
 public:
  /// Takes others, in the memory that there is.
  /// @param base_from_laser  of the leading one.
  /// @param motion           of the base during the leading scan.
  /// @param further          in the base at the leading one.
  void assign(const ScanInput& leading, const Eigen::Isometry3d& base_from_laser,
              const Pose2& motion, const ProjectionOptions& options,
              std::map<int, FurtherScan> further, ScanProjector& projector);

  [[nodiscard]] const MeasuredScan& leading() const { return leading_; }
  [[nodiscard]] const PointScan& points() const { return points_; }  ///< of the leading one
  [[nodiscard]] const std::map<int, FurtherScan>& further() const { return further_; }

  /// The points of all lasers as one scan, to be matched.
  [[nodiscard]] const PointScan& all() const { return further_.empty() ? points_ : together_; }

  /// The base has really moved so during the leading scan; its points follow.
  void put_right(const Pose2& motion, ScanProjector& projector);

 private:
  MeasuredScan leading_;
  std::map<int, FurtherScan> further_;
  PointScan points_;
  PointScan together_;  ///< where others saw something, too
};

}  // namespace matchbox_slam
