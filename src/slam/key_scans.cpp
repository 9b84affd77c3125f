#include "matchbox_slam/slam/key_scans.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace matchbox_slam {

void KeyScans::add(MeasuredScan measured, int laser, const Pose2& map_from_base) {
  scans_.push_back(
      {std::make_shared<const KeyScan>(std::move(measured), scans_.size(), laser, cache_),
       map_from_base});
}

void KeyScans::add(PointScan points, int laser, const Pose2& map_from_base) {
  scans_.push_back(
      {std::make_shared<const KeyScan>(std::move(points), scans_.size(), laser, cache_),
       map_from_base});
}

void KeyScans::add(const PlacedScan& other) {
  const KeyScan& scan = *other.scan;
  if (std::optional<MeasuredScan> measured = scan.measured()) {
    add(std::move(*measured), scan.laser(), other.map_from_base);
  } else {
    add(*scan.points(), scan.laser(), other.map_from_base);
  }
}

void KeyScans::insert(std::size_t before, const PlacedScans& others) {
  const PlacedScans behind(scans_.begin() + static_cast<std::ptrdiff_t>(before), scans_.end());
  scans_.resize(before);
  for (const PlacedScan& other : others) {
    add(other);
  }
  for (const PlacedScan& placed : behind) {
    scans_.push_back(
        {std::make_shared<const KeyScan>(*placed.scan, scans_.size()), placed.map_from_base});
  }
}

void KeyScans::move(std::uint64_t id, const Pose2& map_from_base) {
  scans_.at(id).map_from_base = map_from_base;
}

void KeyScans::move(const std::vector<Pose2>& map_from_base) {
  for (std::size_t i = 0; i < scans_.size(); ++i) {
    move(i, map_from_base.at(i));
  }
}

void KeyScans::take_out(const std::vector<bool>& is_taken) {
  PlacedScans kept;
  for (const PlacedScan& placed : scans_) {
    if (!is_taken.at(placed.scan->id())) {
      const bool has_moved = placed.scan->id() != kept.size();
      kept.push_back(
          {has_moved ? std::make_shared<const KeyScan>(*placed.scan, kept.size()) : placed.scan,
           placed.map_from_base});
    }
  }
  scans_ = std::move(kept);
}

std::vector<Pose2> KeyScans::poses(std::size_t count) const {
  std::vector<Pose2> poses;
  poses.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    poses.push_back(scans_.at(i).map_from_base);
  }
  return poses;
}

void KeyScans::copy_newest(std::size_t most, PlacedScans& newest) const {
  newest.assign(scans_.end() - static_cast<std::ptrdiff_t>(std::min(most, scans_.size())),
                scans_.end());
}

}  // namespace matchbox_slam
