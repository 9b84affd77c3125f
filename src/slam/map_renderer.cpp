#include "slam/map_renderer.hpp"

#include <utility>

#include "matching/rendered_map.hpp"

namespace matchbox_slam {

const SlamMap& MapRenderer::drawn(MapComponent& component, const EngineOptions& options) {
  if (const std::shared_ptr<Rendering> begun = std::exchange(rendering_, nullptr);
      begun && begun->map.valid()) {
    take_rendered(begun->map.get(), begun->keys, component);
  }
  const PlacedScans& keys = component.key_scans.all();
  if (is_outdated_) {
    component.map = SlamMap(options.map, options.field);
    drawn_ = 0;
  }
  if (drawn_ < keys.size()) {
    is_outdated_ = true;  // unless all of it can be drawn
    for (; drawn_ < keys.size(); ++drawn_) {
      insert_unrendered(*keys[drawn_].scan->points(), keys[drawn_].map_from_base, options.map,
                        MapUse::kShown, component.map);
    }
    component.map.field.settle();
  }
  is_outdated_ = false;
  return component.map;
}

const SlamMap& MapRenderer::whole(MapComponent& component, const EngineOptions& options) {
  static_cast<void>(drawn(component, options));
  component.map.field.render();
  return component.map;
}

void MapRenderer::take_rendered(SlamMap map, const PlacedScans& keys, MapComponent& component) {
  if (!is_outdated_ || !begins_with(component.key_scans.all(), keys)) {
    return;
  }
  component.map = std::move(map);
  is_outdated_ = false;
  drawn_ = keys.size();
}

void MapRenderer::add(const PlacedScan& key, const PointScan& points, MapComponent& component,
                      const EngineOptions& options) {
  const bool is_all_drawn = !is_outdated_ && drawn_ == component.key_scans.size();
  component.key_scans.add(key);
  component.key_scans.all().back().scan->keep(points);
  if (is_all_drawn && local_map_.map() == nullptr) {
    insert_scan(points, key.map_from_base, options.map, component.map);
    ++drawn_;
  }
}

void MapRenderer::match_whole(MapComponent& component, const EngineOptions& options) {
  local_map_.clear();
  static_cast<void>(whole(component, options));
  is_moved_ = false;
}

bool MapRenderer::begin_whole(const MapComponent& component, const EngineOptions& options) {
  const PlacedScans& keys = component.key_scans.all();
  const bool may_take_long = local_map_.map() != nullptr || is_moved_;
  local_map_.clear();
  is_moved_ = false;
  if (!rendering_ && (is_outdated_ || drawn_ < keys.size() || !component.map.field.is_rendered())) {
    is_outdated_ = true;
    rendering_ = std::make_shared<Rendering>(Rendering{
        keys, std::async(std::launch::async, [keys, map = options.map, field = options.field] {
          return rendered(keys, map, field, MapUse::kShown);
        })});
  }
  return may_take_long;
}

}  // namespace matchbox_slam
