#include "merging/map_meeting.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace matchbox_slam {
namespace {

constexpr std::size_t kWalkedComponent = 1;  // the component that the robot makes; it has no parent

/// Whether two meetings are the same one, by where they have a key scan.
bool is_same(const Pose2& there_from_map, const Pose2& other, const Pose2& map_from_base) {
  // More than maps drift where they meet: a guess.
  return are_near(there_from_map * map_from_base, other * map_from_base, 1.0, 0.3);
}

}  // namespace

MeetingWalk::MeetingWalk(const MapComponent& there, const EngineOptions& options)
    : options_(options),
      components_{there, {SlamMap(options.map, options.field), {}, {}, 0.0, kWalkedComponent}},
      index_(components_, kWalkedComponent) {}

std::optional<Pose2> MeetingWalk::go_on_to(const PlacedScan& key) {
  MapComponent& walked = components_[kWalkedComponent];
  walked.key_scans.add(key);
  insert_scan(*key.scan->points(), key.map_from_base, options_.map, walked.map);
  const std::optional<PlaceHypothesis> found =
      search_places(key.map_from_base, components_, kWalkedComponent, index_, options_, search_);
  if (!found) {
    return std::nullopt;
  }
  search_.hypotheses.erase(search_.hypotheses.begin());  // it is the first one
  const bool is_told =
      std::any_of(not_believed_.begin(), not_believed_.end(), [&](const Pose2& there_from_map) {
        return is_same(there_from_map, found->component_from_active, key.map_from_base);
      });
  return is_told ? std::nullopt : std::optional(found->component_from_active);
}

void MeetingWalk::disbelieve(const Pose2& there_from_map) {
  not_believed_.push_back(there_from_map);
}

std::optional<MapMeeting> find_meeting(const PlacedScans& way, const MapComponent& there,
                                       const EngineOptions& options, const IsBelieved& is_believed,
                                       const std::function<void(double done)>& progress) {
  MeetingWalk walk(there, options);
  for (std::size_t i = 0; i < way.size(); ++i) {
    progress(static_cast<double>(i) / static_cast<double>(way.size()));
    if (const std::optional<Pose2> there_from_map = walk.go_on_to(way[i])) {
      const MapMeeting meeting{i, *there_from_map};
      if (is_believed(meeting)) {
        return meeting;
      }
      walk.disbelieve(*there_from_map);
    }
  }
  return std::nullopt;
}

}  // namespace matchbox_slam
