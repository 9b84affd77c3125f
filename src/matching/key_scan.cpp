#include "matchbox_slam/matching/key_scan.hpp"

#include <atomic>
#include <cstddef>
#include <map>
#include <mutex>
#include <utility>

#include "common/lru_cache.hpp"
#include "map/scan_surfaces.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "sensor/packed_ranges.hpp"

namespace matchbox_slam {
namespace {

// A map's defaults but for the reach, with whose square the memory grows: a point that far off has
// 7 % of its weight under the first kernel of refinement.
constexpr double kResolution = MapOptions{}.resolution;
constexpr LikelihoodFieldOptions kOptions{LikelihoodFieldOptions{}.sigma, 0.25};

/// Whether a point lies where a laser can measure; farther ones would make the field endless.
bool is_measured(const ScanPoint& point) {
  return point.position.norm() < kFarthestPoint && point.normal.allFinite();
}

/// The scan without points that are no measurements, nor the walls to them.
PointScan without_outliers(const PointScan& scan) {
  PointScan result;
  for (const ScanPoint& point : scan.points) {
    if (is_measured(point)) {
      result.points.push_back(point);
    } else if (!result.points.empty()) {
      result.points.back().joined_to_next = false;
    }
  }
  return result;
}

LikelihoodField field_of(const PointScan& scan) {
  const PointScan points = without_outliers(scan);
  std::vector<SurfaceHit> hits = surfaces_between_hits(points, Pose2{}, kResolution);
  const std::vector<SurfaceHit> own = surfaces_at_hits(points, Pose2{});
  hits.insert(hits.end(), own.begin(), own.end());
  LikelihoodField field(kResolution, kOptions);
  field.update(hits, {});
  return field;
}

std::size_t bytes_of(const PointScan& scan) {
  return sizeof scan + scan.points.capacity() * sizeof(ScanPoint) +
         scan.free_rays.capacity() * sizeof(FreeRay);
}

bool is_alike(const LaserScan& a, const LaserScan& b) {
  return a.angle_min == b.angle_min && a.angle_increment == b.angle_increment &&
         a.time_increment == b.time_increment && a.range_min == b.range_min &&
         a.range_max == b.range_max;
}

/// Whether two scans differ by nothing but what each has of its own.
bool is_alike(const MeasuredScan& a, const MeasuredScan& b) {
  return is_alike(a.scan, b.scan) && a.options == b.options && a.is_of_image == b.is_of_image &&
         a.base_from_laser.matrix() == b.base_from_laser.matrix() &&
         a.laser_motion.matrix() == b.laser_motion.matrix();
}

/// Of each laser what its last scan had that was not its own, so that scans share it.
class ScanLikenesses {
 public:
  std::shared_ptr<const MeasuredScan> of(const MeasuredScan& measured, int laser) {
    const std::lock_guard<std::mutex> lock(mutex_);
    std::shared_ptr<const MeasuredScan>& last = last_[laser];
    if (last == nullptr || !is_alike(measured, *last)) {
      last = std::make_shared<const MeasuredScan>(measured);
    }
    return last;
  }

 private:
  std::mutex mutex_;
  std::map<int, std::shared_ptr<const MeasuredScan>> last_;
};

}  // namespace

struct KeyScanCache {
  LruCache<PointScan> points{std::size_t{8} << 20U, bytes_of};
  LruCache<LikelihoodField> fields{std::size_t{16} << 20U,
                                   [](const LikelihoodField& field) { return field.bytes(); }};
  std::atomic<std::uint64_t> next_key{0};
  ScanLikenesses likenesses;
};

std::shared_ptr<KeyScanCache> make_key_scan_cache() { return std::make_shared<KeyScanCache>(); }

KeyScan::Packed KeyScan::packed_of(MeasuredScan measured, int laser, KeyScanCache& cache) {
  const std::vector<float> ranges = std::exchange(measured.scan.ranges, {});
  const double stamp = std::exchange(measured.scan.stamp, 0.0);
  const Pose2 motion = std::exchange(measured.motion, {});
  return {stamp, motion, pack_ranges(ranges), ranges.size(), cache.likenesses.of(measured, laser)};
}

KeyScan::KeyScan(MeasuredScan measured, std::uint64_t id, int laser,
                 std::shared_ptr<KeyScanCache> cache)
    : id_(id),
      laser_(laser),
      seen_(packed_of(std::move(measured), laser, *cache)),
      cache_(std::move(cache)),
      cache_key_(cache_->next_key++) {}

KeyScan::KeyScan(PointScan points, std::uint64_t id, int laser, std::shared_ptr<KeyScanCache> cache)
    : id_(id),
      laser_(laser),
      seen_(std::make_shared<const PointScan>(std::move(points))),
      cache_(std::move(cache)),
      cache_key_(cache_->next_key++) {}

double KeyScan::stamp() const { return packed() != nullptr ? packed()->stamp : points()->stamp; }

std::optional<MeasuredScan> KeyScan::measured() const {
  if (packed() == nullptr) {
    return std::nullopt;
  }
  MeasuredScan measured = *packed()->like;
  measured.scan.stamp = packed()->stamp;
  measured.motion = packed()->motion;
  measured.scan.ranges = unpack_ranges(packed()->ranges, packed()->beams);
  return measured;
}

std::shared_ptr<const PointScan> KeyScan::points() const {
  if (const auto* points = std::get_if<std::shared_ptr<const PointScan>>(&seen_)) {
    return *points;
  }
  return cache_->points.get(cache_key_, [this] { return project_scan(*measured()); });
}

void KeyScan::keep(const PointScan& points) const {
  if (packed() != nullptr) {
    static_cast<void>(cache_->points.get(cache_key_, [&points] { return points; }));
  }
}

std::shared_ptr<const LikelihoodField> KeyScan::field() const {
  return cache_->fields.get(cache_key_, [this] { return field_of(*points()); });
}

}  // namespace matchbox_slam
