#include "lasers/scan_bundle.hpp"

#include <utility>

namespace matchbox_slam {
namespace {

void project(const MeasuredScan& measured, ScanProjector& projector, PointScan& points) {
  projector.project(measured.scan, measured.base_from_laser, measured.motion, measured.options,
                    measured.laser_motion, points);
}

}  // namespace

void ScanBundle::assign(const ScanInput& primary, const Eigen::Isometry3d& base_from_laser,
                        const Pose2& motion, const ProjectionOptions& options,
                        std::map<int, SecondaryScan> secondary, ScanProjector& projector) {
  primary_.scan = primary.scan;
  primary_.base_from_laser = base_from_laser;
  primary_.motion = motion;
  primary_.options = options;
  primary_.laser_motion = primary.laser_motion;
  secondary_ = std::move(secondary);
  project(primary_, projector, points_);
  if (secondary_.empty()) {
    return;
  }
  together_ = points_;
  for (const auto& [laser, one] : secondary_) {
    append(project_scan(one.measured), one.there_from_base, together_);
  }
}

void ScanBundle::correct_motion(const Pose2& motion, ScanProjector& projector) {
  if (motion != primary_.motion) {
    primary_.motion = motion;
    project(primary_, projector, points_);
  }
}

}  // namespace matchbox_slam
