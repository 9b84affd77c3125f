#include "slam/map_meeting.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "slam/recovery.hpp"

namespace matchbox_slam {
namespace {

/// Key scans are farther apart than the scans that a robot is searched with, and nothing waits for
/// them.
RecoveryOptions unhurried(RecoveryOptions options) {
  constexpr int kTimesAsMany = 10;  // twice as Relocalizer has it where scans are rare: a guess
  options.interval = 0.0;
  options.key_scans *= kTimesAsMany;
  return options;
}

/// Whether two meetings are the same one, by where they have a key scan.
bool is_same(const Pose2& there_from_map, const Pose2& other, const Pose2& map_from_base) {
  constexpr double kDistance = 1.0;  // [m], more than maps drift where they meet: a guess
  constexpr double kAngle = 0.3;     // [rad], likewise
  const Eigen::Vector3d off = difference(there_from_map * map_from_base, other * map_from_base);
  return off.head<2>().norm() < kDistance && std::abs(off.z()) < kAngle;
}

}  // namespace

std::optional<MapMeeting> find_meeting(const PlacedScans& way, const MapPart& there,
                                       const EngineOptions& options, const IsBelieved& is_believed,
                                       const std::function<void(double done)>& progress) {
  constexpr std::size_t kWalked = 1;  // the part that the robot makes; it has left none
  std::vector<MapPart> parts{there, {SlamMap(options.map, options.field), {}, {}, 0.0, kWalked}};
  MapPart& walked = parts[kWalked];
  const std::vector<SearchedPlace> places = searched_places(parts, kWalked);
  const RecoveryOptions recovery = unhurried(options.recovery);
  PlaceSearch search;
  std::vector<Pose2> not_believed;
  for (std::size_t i = 0; i < way.size(); ++i) {
    progress(static_cast<double>(i) / static_cast<double>(way.size()));
    const Pose2& map_from_base = way[i].map_from_base;
    const std::shared_ptr<const PointScan> points = way[i].scan->points();
    walked.key_scans.add(way[i]);
    insert_scan(*points, map_from_base, options.map, walked.map);
    search.stamp = std::numeric_limits<double>::lowest();  // stamps may go back between drives
    const std::optional<PlaceHypothesis> found =
        search_places(*points, map_from_base, parts, kWalked, places, recovery, search);
    if (!found) {
      continue;
    }
    const MapMeeting meeting{i, found->part_from_apart};
    const bool is_told =
        std::any_of(not_believed.begin(), not_believed.end(), [&](const Pose2& there_from_map) {
          return is_same(there_from_map, meeting.there_from_map, map_from_base);
        });
    if (!is_told && is_believed(meeting)) {
      return meeting;
    }
    not_believed.push_back(meeting.there_from_map);
    search.hypotheses.erase(search.hypotheses.begin());  // it is the first one
  }
  return std::nullopt;
}

}  // namespace matchbox_slam
