#include "tools/drive_record.hpp"

#include <algorithm>
#include <cmath>

namespace matchbox_slam {
namespace {

/// In the direction that is known least [m].
float sigma_of_position(const Eigen::Matrix3d& covariance) {
  const double mean = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double half = 0.5 * (covariance(0, 0) - covariance(1, 1));
  return static_cast<float>(std::sqrt(mean + std::hypot(half, covariance(0, 1))));
}

}  // namespace

void DriveRecord::add(const ScanOutcome& outcome, double stamp) {
  scans_.push_back({outcome.stamp, stamp, sigma_of_position(outcome.covariance), outcome.state,
                    outcome.certainty});
}

std::vector<PagePoint> DriveRecord::points(const SlamRun& run) const {
  const std::vector<StampedPose2>& poses = run.trajectory();
  std::vector<PagePoint> points;
  points.reserve(scans_.size());
  for (const Scan& scan : scans_) {
    PagePoint point;
    point.time = scan.run_stamp - scans_.front().run_stamp;
    point.stamp = scan.stamp;
    point.sigma = scan.sigma;
    point.state = scan.state;
    point.certainty = scan.certainty;
    const auto pose =
        std::lower_bound(poses.begin(), poses.end(), scan.run_stamp,
                         [](const StampedPose2& one, double time) { return one.stamp < time; });
    if (pose != poses.end() && pose->stamp == scan.run_stamp && run.is_in_map(pose->stamp)) {
      point.place = pose->pose.translation();
    }
    points.push_back(point);
  }
  return points;
}

}  // namespace matchbox_slam
