#pragma once

#include <deque>
#include <memory>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// An earlier scan that was inserted into the map, and where.
class KeyScan {
 public:
  KeyScan(PointScan a_scan, const Pose2& a_map_from_base);

  const PointScan scan;
  const Pose2 map_from_base;

  /// The likelihood field of this scan alone, in its own base frame, for matchers of scan to scan.
  /// Made when it is first asked for, from whichever thread, and kept: about 1 MB in a room. Points
  /// farther than 100 m from the base are left out, and it has no `bounds`. Cost then: as of a
  /// likelihood field's update.
  [[nodiscard]] const LikelihoodField& field() const;

 private:
  struct LazyField;
  std::shared_ptr<LazyField> field_;  ///< shared by copies, which are of the same scan
};

/// Key scans, oldest first. Shared, never changed once made.
using KeyScans = std::deque<std::shared_ptr<const KeyScan>>;

}  // namespace matchbox_slam
