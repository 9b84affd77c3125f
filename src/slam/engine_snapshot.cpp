// What an engine is saved as, and how it goes on from there.

#include <algorithm>
#include <iterator>
#include <utility>

#include "matchbox_slam/geometry/transform2.hpp"
#include "slam/engine_parts.hpp"

namespace matchbox_slam {
namespace {

/// The key scans that a map shows: what lies elsewhere a damaged file may have put anywhere.
class ShownKeyScans {
 public:
  explicit ShownKeyScans(const MapComponent& component)
      : map_(component.map.occupancy), known_(map_.known_bounds()) {}

  /// By where its beams end: the base itself no laser need have seen.
  [[nodiscard]] bool contains(const PlacedScan& key) const {
    const Transform2 to_map(key.map_from_base);
    const auto is_known = [&](const Eigen::Vector2d& end) {
      return known_.contains(map_.geometry().cell_at(to_map * end));
    };
    const std::shared_ptr<const PointScan> scan = key.scan->points();
    return std::all_of(scan->points.begin(), scan->points.end(),
                       [&](const ScanPoint& point) { return is_known(point.position); }) &&
           std::all_of(scan->free_rays.begin(), scan->free_rays.end(),
                       [&](const FreeRay& ray) { return is_known(ray.end); });
  }

 private:
  const OccupancyGrid& map_;
  CellBox known_;
};

/// Of a map that was saved, which has none.
void count_reflections(MapComponent& component, bool is_of_key_scans) {
  ReflectionGrid& reflection = component.map.reflection;
  if (!reflection.empty()) {
    return;
  }
  if (!is_of_key_scans) {
    reflection.count(component.map.occupancy);
  }
  const ShownKeyScans shown(component);
  for (const PlacedScan& key : component.key_scans.all()) {
    if (!key.scan->is_of_image() && shown.contains(key)) {
      reflection.count(*key.scan->points(), key.map_from_base);
    }
  }
}

/// The local map that was saved.
LocalMap drawn_again(const LocalMapContents& contents, const MapComponent& component,
                     const EngineOptions& options) {
  const PlacedScans& keys = component.key_scans.all();
  const ShownKeyScans shown(component);
  PlacedScans drawn;
  for (const std::uint64_t id : contents.drawn) {
    if (shown.contains(keys.at(id))) {
      drawn.push_back(keys[id]);
    }
  }
  return {contents.center, drawn, keys.size(), options.map, options.field};
}

std::optional<LocalMapContents> contents_of(const LocalMap& map) {
  return map.map() ? std::optional(LocalMapContents{map.center(), map.drawn()}) : std::nullopt;
}

}  // namespace

void SlamEngine::Parts::start_from(EngineState start) {
  LocalizationState& localization = start.localization;
  std::vector<MapComponent> components{
      {std::move(start.map), std::move(start.key_scans), std::move(start.last_inserted), 0.0}};
  std::move(localization.components.begin(), localization.components.end(),
            std::back_inserter(components));
  for (MapComponent& component : components) {
    check_map(component.map, options());
    count_reflections(component, start.is_of_key_scans);
  }
  const std::size_t drawn = components.front().key_scans.size();
  LocalMap local_map =
      start.local_map ? drawn_again(*start.local_map, components.front(), options()) : LocalMap();
  mapping_ = Mapping(
      MapComponents(std::move(components), localization.active, std::move(localization.pending)),
      LoopCloser(std::move(start.loops)), {std::move(local_map), start.is_moved, drawn},
      start.is_continued, start.is_of_key_scans, options());
  hypotheses_ = PoseHypotheses(std::move(localization.hypotheses));
  if (const auto& fork = hypotheses_.state().fork) {
    mapping_.fork_as_of(fork->key_scans, std::move(localization.inserted_before_fork));
  }
  if (localization.search.indexed > 0) {
    static_cast<void>(mapping_.whole());  // drawn, as it was searched
  }
  relocalizer_ = Relocalizer(std::move(localization.search), mapping_.components());
  tracker_.set_state(start.motion);
  scan_count_ = start.scan_count;
  secondary_lasers_ = std::move(start.secondary_lasers);
}

EngineState SlamEngine::Parts::snapshot() {
  static_cast<void>(mapping_.drawn());
  const MapComponents& components = mapping_.components();
  return {components.map().map,
          components.map().key_scans,
          tracker_.state(),
          components.map().last_inserted,
          scan_count_,
          {hypotheses_.state(),
           mapping_.inserted_before_fork(),
           components.waiting(),
           {components.all().begin() + 1, components.all().end()},
           components.active_number(),
           relocalizer_.search()},
          mapping_.loops().state(),
          contents_of(mapping_.renderer().local_map()),
          mapping_.renderer().is_moved(),
          mapping_.is_continued(),
          mapping_.is_of_key_scans(),
          secondary_lasers_};
}

}  // namespace matchbox_slam
