#pragma once

#include <cstddef>
#include <map>
#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"

namespace matchbox_slam {

/// What a robot that localises matches against: the map, which stays as it is, and what the robot
/// has seen of late, drawn over a copy of it. So things that were moved since the map was made are
/// known once they were seen, as they are while mapping, and speak against the right pose no more
/// (Meyer-Delius et al., "Temporary maps for robust localization in semi-static environments",
/// 2010). A value.
class TemporaryMap {
 public:
  /// Shows the newest 50 to 100 scans. Null where nothing was seen since it was cleared.
  [[nodiscard]] const SlamMap* map() const { return map_ ? &*map_ : nullptr; }
  /// map_from_base of the newest scan that was drawn, by laser.
  [[nodiscard]] const std::map<int, Pose2>& last_drawn() const { return last_drawn_; }

  /// @param lasting  the map, with its field rendered.
  void add(const PointScan& scan, int laser, const Pose2& map_from_base, const SlamMap& lasting,
           const MapOptions& options);

  void clear() { *this = {}; }

 private:
  std::optional<SlamMap> map_;
  std::optional<SlamMap> next_;  ///< takes its place when that shows too many
  std::size_t drawn_ = 0;        ///< scans that it shows
  std::map<int, Pose2> last_drawn_;
};

}  // namespace matchbox_slam
