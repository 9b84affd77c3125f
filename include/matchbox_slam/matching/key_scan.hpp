#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// What was derived from key scans last, so that it need not be made again at once: their points up
/// to 8 MB and their fields up to 16 MB, of a hundred scans in corridors. A match looks at a dozen.
/// Shared by the key scans of a run; results do not depend on what it holds.
struct KeyScanCache;

[[nodiscard]] std::shared_ptr<KeyScanCache> make_key_scan_cache();

/// A scan that was inserted into the map: what was seen, not where. It never changes, and takes
/// some 2.6 bytes a beam and 0.2 kB; where it was taken lies beside it, in a PlacedScan.
class KeyScan {
 public:
  /// @param id     number within its run.
  /// @param laser  which of the robot's.
  explicit KeyScan(MeasuredScan measured, std::uint64_t id = 0, int laser = 0,
                   std::shared_ptr<KeyScanCache> cache = make_key_scan_cache());

  /// Of points alone, where it is not known how they were measured.
  explicit KeyScan(PointScan points, std::uint64_t id = 0, int laser = 0,
                   std::shared_ptr<KeyScanCache> cache = make_key_scan_cache());

  /// The same scan by another number.
  KeyScan(KeyScan other, std::uint64_t id) : KeyScan(std::move(other)) { id_ = id; }

  [[nodiscard]] std::uint64_t id() const { return id_; }
  [[nodiscard]] int laser() const { return laser_; }
  [[nodiscard]] double stamp() const;  ///< [s]

  /// None for one that was made of points. Cost: 2 ns a beam.
  [[nodiscard]] std::optional<MeasuredScan> measured() const;

  /// Whether nobody measured it, as MeasuredScan has it.
  [[nodiscard]] bool is_of_image() const {
    return packed() != nullptr && packed()->like->is_of_image;
  }

  /// Pose of the laser in the base at the first beam; null for one that was made of points.
  [[nodiscard]] const Eigen::Isometry3d* base_from_laser() const {
    return packed() == nullptr ? nullptr : &packed()->like->base_from_laser;
  }

  /// In the base frame. Cost: as of `project_scan`, unless they were asked for lately.
  [[nodiscard]] std::shared_ptr<const PointScan> points() const;

  /// Keeps points that are at hand, so that they need not be made again at once.
  /// @param points  the same as those of `points()`.
  void keep(const PointScan& points) const;

  /// The likelihood field of this scan alone, in its own base frame, for matchers of scan to scan:
  /// about 1 MB in a room. Points farther than 100 m from the base are left out, and it has no
  /// `bounds`. Cost: as of a likelihood field's update, unless it was asked for lately.
  [[nodiscard]] std::shared_ptr<const LikelihoodField> field() const;

 private:
  /// What a scan has of its own, its ranges packed.
  struct Packed {
    double stamp;  ///< [s]
    Pose2 motion;
    std::vector<std::uint8_t> ranges;
    std::size_t beams;
    std::shared_ptr<const MeasuredScan> like;  ///< the rest, as most scans of a laser have it
  };

  [[nodiscard]] static Packed packed_of(MeasuredScan measured, int laser, KeyScanCache& cache);
  [[nodiscard]] const Packed* packed() const { return std::get_if<Packed>(&seen_); }

  std::uint64_t id_;
  int laser_;
  std::variant<Packed, std::shared_ptr<const PointScan>> seen_;
  std::shared_ptr<KeyScanCache> cache_;
  std::uint64_t cache_key_;
};

/// A key scan where it was taken, as far as that is known now.
struct PlacedScan {
  std::shared_ptr<const KeyScan> scan;
  Pose2 map_from_base;
};

/// Key scans, oldest first.
using PlacedScans = std::vector<PlacedScan>;

}  // namespace matchbox_slam
