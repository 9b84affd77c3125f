#include "tools/scan_table.hpp"

#include <algorithm>
#include <iomanip>
#include <ostream>
#include <utility>
#include <vector>

namespace matchbox_slam {
namespace {

constexpr const char* kHead =
    "stamp,x,y,theta,cov_xx,cov_xy,cov_xt,cov_yy,cov_yt,cov_tt,state,certainty,status,score,"
    "evidence,rival_share,inserted";

}  // namespace

ScanTable::ScanTable(ByteSink sink) : text_(std::move(sink)) {
  text_.line() << std::fixed << kHead;
  text_.end_line();
}

void ScanTable::add(const ScanOutcome& outcome) {
  std::ostream& row = text_.line();
  const Pose2& pose = outcome.map_from_base;
  const Eigen::Matrix3d& covariance = outcome.covariance;
  row << std::setprecision(6) << outcome.stamp << std::setprecision(9);
  for (const double value :
       {pose.x, pose.y, pose.theta, covariance(0, 0), covariance(0, 1), covariance(0, 2),
        covariance(1, 1), covariance(1, 2), covariance(2, 2)}) {
    row << ',' << value;
  }
  for (const char* word :
       {to_string(outcome.state), to_string(outcome.certainty), status_text(outcome)}) {
    row << ',' << word;
  }
  row << std::setprecision(4);
  for (const double value :
       {outcome.match.score, outcome.evidence.mean, outcome.match.rival_share}) {
    row << ',' << value;
  }
  row << (outcome.inserted ? ",1" : ",0");
  text_.end_line();
}

Trajectory key_scan_trajectory(const KeyScans& key_scans) {
  std::vector<StampedPose2> poses;
  for (const PlacedScan& key : key_scans.all()) {
    if (!key.scan->is_of_image()) {
      poses.push_back({key.scan->stamp(), key.map_from_base});
    }
  }
  std::stable_sort(poses.begin(), poses.end(),
                   [](const auto& a, const auto& b) { return a.stamp < b.stamp; });
  poses.erase(std::unique(poses.begin(), poses.end(),
                          [](const auto& a, const auto& b) { return a.stamp == b.stamp; }),
              poses.end());
  return Trajectory(std::move(poses));
}

}  // namespace matchbox_slam
