#pragma once

#include <map>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/lasers/secondary_lasers.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"

namespace matchbox_slam {

/// A scan of the primary laser, and what others saw since its last one, by laser.
class ScanBundle {
 public:
  /// Takes others, in the memory that there is.
  /// @param base_from_laser  of the primary one.
  /// @param motion           of the base during the primary scan.
  /// @param secondary          in the base at the primary one.
  void assign(const ScanInput& primary, const Eigen::Isometry3d& base_from_laser,
              const Pose2& motion, const ProjectionOptions& options,
              std::map<int, SecondaryScan> secondary, ScanProjector& projector);

  [[nodiscard]] const MeasuredScan& primary() const { return primary_; }
  [[nodiscard]] const PointScan& points() const { return points_; }  ///< of the primary one
  [[nodiscard]] const std::map<int, SecondaryScan>& secondary() const { return secondary_; }

  /// The points of all lasers as one scan, to be matched.
  [[nodiscard]] const PointScan& all() const { return secondary_.empty() ? points_ : together_; }

  /// The base has really moved so during the primary scan; its points follow.
  void correct_motion(const Pose2& motion, ScanProjector& projector);

 private:
  MeasuredScan primary_;
  std::map<int, SecondaryScan> secondary_;
  PointScan points_;
  PointScan together_;  ///< where others saw something, too
};

}  // namespace matchbox_slam
