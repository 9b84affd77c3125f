#include "matchbox_slam/matching/key_scan.hpp"

#include <mutex>
#include <utility>

#include "map/scan_surfaces.hpp"

namespace matchbox_slam {
namespace {

constexpr double kResolution = 0.05;  // [m]
constexpr LikelihoodFieldOptions kOptions{0.045, 0.25};

/// Whether a point lies where a laser can measure; farther ones would make the field endless.
bool is_measured(const ScanPoint& point) {
  constexpr double kFarthest = 100.0;  // [m]
  return point.position.norm() < kFarthest && point.normal.allFinite();
}

/// The scan without points that are no measurements, nor the walls to them.
PointScan measured(const PointScan& scan) {
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

}  // namespace

struct KeyScan::LazyField {
  std::once_flag made;
  // Nothing searches it with bounds.
  LikelihoodField field{kResolution, kOptions, false};
};

KeyScan::KeyScan(PointScan a_scan, const Pose2& a_map_from_base)
    : scan(std::move(a_scan)),
      map_from_base(a_map_from_base),
      field_(std::make_shared<LazyField>()) {}

const LikelihoodField& KeyScan::field() const {
  std::call_once(field_->made, [this] {
    const PointScan points = measured(scan);
    std::vector<SurfaceHit> hits = surfaces_between_hits(points, Pose2{}, kResolution);
    const std::vector<SurfaceHit> own = surfaces_at_hits(points, Pose2{});
    hits.insert(hits.end(), own.begin(), own.end());
    field_->field.update(hits, {});
  });
  return field_->field;
}

}  // namespace matchbox_slam
