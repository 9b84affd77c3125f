#include "slam/temporary_map.hpp"

#include <utility>

namespace matchbox_slam {

void TemporaryMap::add(const PointScan& scan, int laser, const Pose2& map_from_base,
                       const SlamMap& lasting, const MapOptions& options) {
  // A guess: the way through two or three rooms. Half and double were not tried.
  constexpr std::size_t kMinScans = 50;
  if (drawn_ == 2 * kMinScans) {
    map_ = std::exchange(next_, std::nullopt);
    drawn_ = kMinScans;
  }
  if (!map_) {
    map_ = lasting;
  }
  if (drawn_ >= kMinScans && !next_) {
    next_ = lasting;
  }
  insert_scan(scan, map_from_base, options, *map_);
  if (next_) {
    insert_scan(scan, map_from_base, options, *next_);
  }
  ++drawn_;
  last_drawn_[laser] = map_from_base;
}

}  // namespace matchbox_slam
