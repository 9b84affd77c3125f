#include "slam/scan_profile.hpp"

#include <algorithm>
#include <cmath>

#include "matchbox_slam/geometry/transform2.hpp"
#include "sensor/take_some.hpp"

namespace matchbox_slam {
namespace {

void see(const Eigen::Vector2d& point, ScanProfile& profile) {
  const auto sector = std::min(static_cast<std::size_t>(sectors_to(point)), kSectors - 1);
  const auto range = static_cast<float>(point.norm());
  float& nearest = profile[sector];
  nearest = nearest == 0.0F ? range : std::min(nearest, range);
}

/// As it would have been seen from elsewhere.
ScanProfile moved(const ScanProfile& profile, const Transform2& new_from_old) {
  ScanProfile seen = {};
  for (std::size_t i = 0; i < profile.size(); ++i) {
    if (profile[i] > 0.0F) {
      const double angle = angle_of(i);
      see(new_from_old *
              (static_cast<double>(profile[i]) * Eigen::Vector2d(std::cos(angle), std::sin(angle))),
          seen);
    }
  }
  return seen;
}

}  // namespace

ScanProfile profile_of(const PointScan& scan) {
  constexpr std::size_t kBeams = 360;
  ScanProfile profile = {};
  take_some(scan, kBeams, [&](const ScanPoint& point) { see(point.position, profile); });
  return profile;
}

double changed_share(const ScanProfile& profile, const ScanProfile& before,
                     const Pose2& before_from_profile) {
  // As much as a wall seen at a slant differs within a sector.
  constexpr float kDistance = 0.2F;  // [m]
  constexpr float kRangeShare = 0.1F;
  const ScanProfile expected = moved(before, Transform2(before_from_profile.inverse()));
  std::size_t both = 0;
  std::size_t changed = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) {
    if (profile[i] > 0.0F && expected[i] > 0.0F) {
      ++both;
      const float differs = std::abs(profile[i] - expected[i]);
      changed += differs > kDistance + kRangeShare * profile[i] ? 1 : 0;
    }
  }
  return both > 0 ? static_cast<double>(changed) / static_cast<double>(both) : 0.0;
}

}  // namespace matchbox_slam
