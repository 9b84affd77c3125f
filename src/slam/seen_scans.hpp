#pragma once

#include <map>
#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "matchbox_slam/slam/further_lasers.hpp"

namespace matchbox_slam {

/// A scan of the leading laser, and what others saw since its last one, by laser.
class SeenScans {
 public:
  /// @param further  in the base at the leading one.
  SeenScans(const MeasuredScan& leading, const std::map<int, FurtherScan>& further);

  [[nodiscard]] const MeasuredScan& leading() const { return leading_; }
  [[nodiscard]] const PointScan& points() const { return points_; }  ///< of the leading one
  [[nodiscard]] const std::map<int, FurtherScan>& further() const { return further_; }

  /// The points of all lasers as one scan, to be matched.
  [[nodiscard]] const PointScan& all() const { return together_ ? *together_ : points_; }

  /// The base has really moved so during the leading scan; its points follow.
  void put_right(const Pose2& motion);

 private:
  MeasuredScan leading_;
  std::map<int, FurtherScan> further_;
  PointScan points_;
  std::optional<PointScan> together_;  ///< none where one laser saw all
};

}  // namespace matchbox_slam
