#include "slam/temporary_map.hpp"

#include <cstddef>

namespace matchbox_slam {

void TemporaryMap::add(const PlacedScan& scan, const PointScan& points, const SlamMap& lasting,
                       const MapOptions& options) {
  // As many as a local map is made of: in twice the way that these take what is older is forgotten.
  constexpr std::size_t kMost = 100;
  drawn_.push_back(scan);
  if (map_ && drawn_.size() <= kMost) {
    insert_scan(points, scan.map_from_base, options, *map_);
    return;
  }
  if (drawn_.size() > kMost) {
    drawn_.erase(drawn_.begin(), drawn_.end() - kMost / 2);
  }
  map_ = lasting;
  for (const PlacedScan& drawn : drawn_) {
    insert_unrendered(*drawn.scan->points(), drawn.map_from_base, options, *map_);
  }
  map_->field.render();
}

void TemporaryMap::clear() {
  map_.reset();
  drawn_.clear();
}

}  // namespace matchbox_slam
