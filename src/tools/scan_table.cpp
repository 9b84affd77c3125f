#include "tools/scan_table.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "common/number_text.hpp"

namespace matchbox_slam {
namespace {

constexpr const char* kHead =
    "stamp,x,y,theta,cov_xx,cov_xy,cov_xt,cov_yy,cov_yt,cov_tt,state,certainty,status,score,"
    "contradiction,rival_share,inserted\n";

}  // namespace

void ScanTable::add(const ScanOutcome& outcome) {
  const Pose2& pose = outcome.map_from_base;
  const Eigen::Matrix3d& covariance = outcome.covariance;
  rows_ += fixed_text(outcome.stamp, 6);
  for (const double value :
       {pose.x, pose.y, pose.theta, covariance(0, 0), covariance(0, 1), covariance(0, 2),
        covariance(1, 1), covariance(1, 2), covariance(2, 2)}) {
    rows_ += "," + fixed_text(value, 9);
  }
  for (const char* word :
       {to_string(outcome.state), to_string(outcome.certainty), to_string(outcome.match.status)}) {
    rows_ += std::string(",") + word;
  }
  for (const double value :
       {outcome.match.score, outcome.match.contradiction, outcome.match.rival_share}) {
    rows_ += "," + fixed_text(value, 4);
  }
  rows_ += outcome.inserted ? ",1\n" : ",0\n";
}

std::string ScanTable::text() const { return kHead + rows_; }

Trajectory key_scan_trajectory(const KeyScans& key_scans) {
  std::vector<StampedPose2> poses;
  for (const PlacedScan& key : key_scans.all()) {
    poses.push_back({key.scan->points()->stamp, key.map_from_base});
  }
  std::stable_sort(poses.begin(), poses.end(),
                   [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  poses.erase(std::unique(poses.begin(), poses.end(),
                          [](const auto& a, const auto& b) { return a.stamp == b.stamp; }),
              poses.end());
  return Trajectory(std::move(poses));
}

}  // namespace matchbox_slam
