#include "matchbox_slam/matching/key_scan.hpp"

#include <mutex>
#include <utility>

#include "matchbox_slam/map/scan_surfaces.hpp"

namespace matchbox_slam {
namespace {

constexpr double kResolution = 0.05;  // [m]
constexpr LikelihoodFieldOptions kOptions{0.045, 0.25};

}  // namespace

struct KeyScan::LazyField {
  std::once_flag made;
  LikelihoodField field{kResolution, kOptions};
};

KeyScan::KeyScan(PointScan a_scan, const Pose2& a_map_from_base)
    : scan(std::move(a_scan)),
      map_from_base(a_map_from_base),
      field_(std::make_shared<LazyField>()) {}

const LikelihoodField& KeyScan::field() const {
  std::call_once(field_->made, [this] {
    std::vector<SurfaceHit> hits = surfaces_between_hits(scan, map_from_base, kResolution);
    const std::vector<SurfaceHit> own = surfaces_at_hits(scan, map_from_base);
    hits.insert(hits.end(), own.begin(), own.end());
    field_->field.update(hits, {});
  });
  return field_->field;
}

}  // namespace matchbox_slam
