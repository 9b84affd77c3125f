#include "slam/map_renderer.hpp"

#include <algorithm>
#include <utility>

#include "matching/rendered_map.hpp"

namespace matchbox_slam {

const SlamMap& MapRenderer::drawn(MapPart& part, const EngineOptions& options) {
  if (const std::shared_ptr<Rendering> begun = std::exchange(rendering_, nullptr);
      begun && begun->map.valid()) {
    take_rendered(begun->map.get(), begun->keys, part);
  }
  const PlacedScans& keys = part.key_scans.all();
  if (is_outdated_) {
    part.map = SlamMap(options.map, options.field);
    drawn_ = 0;
  }
  if (drawn_ < keys.size()) {
    is_outdated_ = true;  // unless all of it can be drawn
    for (; drawn_ < keys.size(); ++drawn_) {
      insert_unrendered(*keys[drawn_].scan->points(), keys[drawn_].map_from_base, options.map,
                        part.map);
    }
    part.map.field.settle();
  }
  is_outdated_ = false;
  return part.map;
}

const SlamMap& MapRenderer::whole(MapPart& part, const EngineOptions& options) {
  static_cast<void>(drawn(part, options));
  part.map.field.render();
  return part.map;
}

void MapRenderer::take_rendered(SlamMap map, const PlacedScans& keys, MapPart& part) {
  const PlacedScans& now = part.key_scans.all();
  const auto is_same = [](const PlacedScan& then, const PlacedScan& key) {
    return then.scan == key.scan && then.map_from_base == key.map_from_base;
  };
  if (!is_outdated_ || keys.size() > now.size() ||
      !std::equal(keys.begin(), keys.end(), now.begin(), is_same)) {
    return;
  }
  part.map = std::move(map);
  is_outdated_ = false;
  drawn_ = keys.size();
}

void MapRenderer::add(const PlacedScan& key, const PointScan& points, MapPart& part,
                      const EngineOptions& options) {
  const bool is_all_drawn = !is_outdated_ && drawn_ == part.key_scans.size();
  part.key_scans.add(key);
  part.key_scans.all().back().scan->keep(points);
  if (is_all_drawn && local_map_.map() == nullptr) {
    insert_scan(points, key.map_from_base, options.map, part.map);
    ++drawn_;
  }
}

void MapRenderer::match_whole(MapPart& part, const EngineOptions& options) {
  local_map_.clear();
  static_cast<void>(whole(part, options));
  is_moved_ = false;
}

bool MapRenderer::begin_whole(const MapPart& part, const EngineOptions& options) {
  const PlacedScans& keys = part.key_scans.all();
  const bool may_take_long = local_map_.map() != nullptr || is_moved_;
  local_map_.clear();
  is_moved_ = false;
  if (!rendering_ && (is_outdated_ || drawn_ < keys.size() || !part.map.field.is_rendered())) {
    is_outdated_ = true;
    rendering_ = std::make_shared<Rendering>(Rendering{
        keys, std::async(std::launch::async, [keys, map = options.map, field = options.field] {
          return rendered(keys, map, field);
        })});
  }
  return may_take_long;
}

}  // namespace matchbox_slam
