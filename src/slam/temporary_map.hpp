#pragma once

#include <optional>

#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"

namespace matchbox_slam {

/// What a robot that localises matches against: the map, which stays as it is, and what the robot
/// has seen of late, drawn over a copy of it. So things that were moved since the map was made are
/// known once they were seen, as they are while mapping, and speak against the right pose no more
/// (Meyer-Delius et al., "Temporary maps for robust localization in semi-static environments",
/// 2010). It is forgotten scan by scan, and when the robot is lost. A value.
class TemporaryMap {
 public:
  /// Nothing, where nothing was seen since.
  [[nodiscard]] const SlamMap* map() const { return map_ ? &*map_ : nullptr; }

  /// Draws a scan.
  /// @param points    of it.
  /// @param lasting   the map, with its field rendered.
  void add(const PlacedScan& scan, const PointScan& points, const SlamMap& lasting,
           const MapOptions& options);

  void clear();

 private:
  std::optional<SlamMap> map_;
  PlacedScans drawn_;
};

}  // namespace matchbox_slam
