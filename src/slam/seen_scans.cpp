#include "slam/seen_scans.hpp"

#include <utility>

namespace matchbox_slam {
namespace {

void project(const MeasuredScan& measured, ScanProjector& projector, PointScan& points) {
  projector.project(measured.scan, measured.base_from_laser, measured.motion, measured.options,
                    measured.laser_motion, points);
}

}  // namespace

void SeenScans::assign(const ScanInput& leading, const Eigen::Isometry3d& base_from_laser,
                       const Pose2& motion, const ProjectionOptions& options,
                       std::map<int, FurtherScan> further, ScanProjector& projector) {
  leading_.scan = leading.scan;
  leading_.base_from_laser = base_from_laser;
  leading_.motion = motion;
  leading_.options = options;
  leading_.laser_motion = leading.laser_motion;
  further_ = std::move(further);
  project(leading_, projector, points_);
  if (further_.empty()) {
    return;
  }
  together_ = points_;
  for (const auto& [laser, one] : further_) {
    append(project_scan(one.measured), one.there_from_base, together_);
  }
}

void SeenScans::put_right(const Pose2& motion, ScanProjector& projector) {
  if (motion != leading_.motion) {
    leading_.motion = motion;
    project(leading_, projector, points_);
  }
}

}  // namespace matchbox_slam
