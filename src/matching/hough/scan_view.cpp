#include "matching/hough/scan_view.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace matchbox_slam {
namespace {

constexpr int kBearings = 1024;  // 0.35 degrees each, about the step from beam to beam

/// 0...4 over the circle, like the angle but made of basic arithmetic.
double diamond_angle(const Eigen::Vector2d& v) {
  const double size = std::abs(v.x()) + std::abs(v.y());
  const double along = size > 0.0 ? v.x() / size : 1.0;
  return v.y() >= 0.0 ? 1.0 - along : 3.0 + along;
}

int bearing_of(const Eigen::Vector2d& v) {
  return v.allFinite()
             ? std::clamp(static_cast<int>(diamond_angle(v) * (kBearings / 4.0)), 0, kBearings - 1)
             : 0;
}

/// A beam as bearing and range.
struct Beam {
  int bearing;
  float range;
};

}  // namespace

ScanView::ScanView(const PointScan& scan) : range_(kBearings, 0.0F) {
  if (!scan.points.empty() && scan.points.front().origin.allFinite()) {
    origin_ = scan.points.front().origin;
  }
  const auto see = [&](int bearing, float range) {
    float& seen = range_[static_cast<std::size_t>((bearing + kBearings) % kBearings)];
    seen = seen > 0.0F ? std::min(seen, range) : range;
  };
  // Between two beams that are no farther apart than this, 7 degrees, the nearer one's range holds.
  constexpr int kWidestStep = 20;
  int before = -1;
  float range_before = 0.0F;
  for (const ScanPoint& point : scan.points) {
    const Eigen::Vector2d beam = point.position - origin_;
    if (!(beam.norm() < 1e4)) {
      continue;
    }
    const int bearing = bearing_of(beam);
    const auto range = static_cast<float>(beam.norm());
    see(bearing, range);
    const int step = (bearing - before + kBearings + kBearings / 2) % kBearings - kBearings / 2;
    if (before >= 0 && std::abs(step) <= kWidestStep) {
      for (int k = 1; k < std::abs(step); ++k) {
        see(before + (step > 0 ? k : -k), std::min(range, range_before));
      }
    }
    before = bearing;
    range_before = range;
  }
}

double ScanView::depth(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d beam = point - origin_;
  const double range = range_[static_cast<std::size_t>(bearing_of(beam))];
  return range > 0.0 ? range - beam.norm() : 0.0;
}

double ScanView::contradicted(const HoughPoints& points, const Pose2& here_from_points) const {
  // [m], four cells of error of pose and range. The mean relation of hough in intel is 0.074 m;
  // with half of this 0.090, with double 0.078.
  constexpr double kTolerance = 0.2;
  double inside = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d point(static_cast<double>(points.x[i]), static_cast<double>(points.y[i]));
    const auto weight = static_cast<double>(points.weight[i]);
    inside += depth(here_from_points * point) > kTolerance ? weight : 0.0;
    total += weight;
  }
  return total > 0.0 ? inside / total : 0.0;
}

}  // namespace matchbox_slam
