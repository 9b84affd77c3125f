#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// All key scans of a map, oldest first, each with its number as id, and where they were taken: the
/// one home of these poses, which the graph's edges are about (LoopState). Copies share the scans,
/// and not where they were taken.
class KeyScans {
 public:
  void add(MeasuredScan measured, int laser, const Pose2& map_from_base);
  /// Of points alone, as maps have them that were begun before release 1.0.
  void add(PointScan points, int laser, const Pose2& map_from_base);

  /// What another one saw, as a key scan of these.
  void add(const PlacedScan& other);

  /// The same of several, which come before the one of this number; the ids of others become their
  /// numbers again.
  void insert(std::size_t before, const PlacedScans& others);

  /// Says anew where a key scan was taken. Throws std::out_of_range for an id that there is not.
  void move(std::uint64_t id, const Pose2& map_from_base);
  /// The same of all, in their order.
  void move(const std::vector<Pose2>& map_from_base);

  /// Those from this id on are no more.
  void forget_since(std::uint64_t id) { scans_.resize(id); }

  /// Those are no more; the ids of others become their numbers again.
  /// @param is_taken  by id.
  void take_out(const std::vector<bool>& is_taken);

  [[nodiscard]] const PlacedScans& all() const { return scans_; }
  [[nodiscard]] bool empty() const { return scans_.empty(); }
  [[nodiscard]] std::size_t size() const { return scans_.size(); }

  /// Where the first ones were taken, so many. Throws std::out_of_range when there are fewer.
  [[nodiscard]] std::vector<Pose2> poses(std::size_t count) const;
  [[nodiscard]] std::vector<Pose2> poses() const { return poses(size()); }

  /// The last ones, up to so many, oldest first.
  void copy_newest(std::size_t most, PlacedScans& newest) const;

 private:
  PlacedScans scans_;
  std::shared_ptr<KeyScanCache> cache_ = make_key_scan_cache();
};

}  // namespace matchbox_slam
