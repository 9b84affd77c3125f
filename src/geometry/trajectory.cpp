#include "geometry/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iterator>
#include <locale>
#include <sstream>
#include <string>
#include <utility>

namespace matchbox_slam {
namespace {

// [s]; files round stamps to the microsecond, and a difference of two stamps is no more exact.
constexpr double kSameStamp = 2e-6;

std::string stamp_text(double stamp) {
  std::ostringstream stream;
  stream.imbue(std::locale::classic());
  stream << std::fixed << std::setprecision(6) << stamp;
  return stream.str();
}

[[noreturn]] void throw_never_meet(const Trajectory& estimate, const Trajectory& truth,
                                   double max_gap) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "no pose of the estimate has truth: the estimate is from " << time_range_text(estimate)
       << ", the truth from " << time_range_text(truth) << " (not interpolated across more than "
       << max_gap << " s); are both in the same clock?";
  throw EvaluationError(text.str());
}

}  // namespace

void change_frame_since(double stamp, const Pose2& frame_from_other,
                        std::vector<StampedPose2>& poses) {
  for (auto pose = poses.rbegin(); pose != poses.rend() && pose->stamp >= stamp; ++pose) {
    pose->pose = frame_from_other * pose->pose;
  }
}

Trajectory::Trajectory(std::vector<StampedPose2> poses) : poses_(std::move(poses)) {
  for (const StampedPose2& stamped : poses_) {
    if (!std::isfinite(stamped.stamp) || !stamped.pose.is_finite()) {
      throw EvaluationError("the pose at stamp " + stamp_text(stamped.stamp) +
                            " is not finite; every number of a trajectory has to be");
    }
  }
  std::sort(poses_.begin(), poses_.end(),
            [](const StampedPose2& a, const StampedPose2& b) { return a.stamp < b.stamp; });
  const auto twin = std::adjacent_find(
      poses_.begin(), poses_.end(),
      [](const StampedPose2& a, const StampedPose2& b) { return a.stamp == b.stamp; });
  if (twin != poses_.end()) {
    throw EvaluationError("two poses have the stamp " + stamp_text(twin->stamp) +
                          "; remove one of them");
  }
}

std::optional<Pose2> Trajectory::at(double stamp, double max_gap) const {
  const auto after = std::lower_bound(
      poses_.begin(), poses_.end(), stamp,
      [](const StampedPose2& stamped, double time) { return stamped.stamp < time; });
  if (after != poses_.end() && after->stamp - stamp <= kSameStamp) {
    return after->pose;
  }
  if (after == poses_.begin()) {
    return std::nullopt;
  }
  const auto before = std::prev(after);
  if (stamp - before->stamp <= kSameStamp) {
    return before->pose;
  }
  if (after == poses_.end() || after->stamp - before->stamp > max_gap) {
    return std::nullopt;
  }
  const double gap = after->stamp - before->stamp;
  return interpolate(before->pose, after->pose, (stamp - before->stamp) / gap);
}

std::vector<PosePair> associate(const Trajectory& estimate, const Trajectory& truth,
                                double max_gap) {
  std::vector<PosePair> pairs;
  pairs.reserve(estimate.size());
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const StampedPose2& estimated = estimate.poses()[i];
    if (const std::optional<Pose2> true_pose = truth.at(estimated.stamp, max_gap)) {
      pairs.push_back({estimated.stamp, estimated.pose, *true_pose, i});
    }
  }
  return pairs;
}

std::vector<PosePair> associate_some(const Trajectory& estimate, const Trajectory& truth,
                                     double max_gap) {
  require_poses(estimate, truth);
  std::vector<PosePair> pairs = associate(estimate, truth, max_gap);
  if (pairs.empty()) {
    throw_never_meet(estimate, truth, max_gap);
  }
  return pairs;
}

void require_poses(const Trajectory& estimate, const Trajectory& truth) {
  if (estimate.empty() || truth.empty()) {
    throw EvaluationError(std::string("the ") + (estimate.empty() ? "estimate" : "truth") +
                          " holds no poses");
  }
}

std::string time_range_text(const Trajectory& trajectory) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::fixed << std::setprecision(3) << trajectory.poses().front().stamp << " to "
       << trajectory.poses().back().stamp << " s";
  return text.str();
}

}  // namespace matchbox_slam
