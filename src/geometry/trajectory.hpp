#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// Thrown when trajectories cannot be evaluated; the text says why and what to look at.
class EvaluationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Truth is not interpolated across more than this, unless options say otherwise [s].
constexpr double kDefaultMaxGap = 0.5;

struct StampedPose2 {
  double stamp = 0.0;  ///< [s]
  Pose2 pose;
};

/// Puts the poses from a stamp [s] on, which are in another frame, into the frame of those before.
void change_frame_since(double stamp, const Pose2& frame_from_other,
                        std::vector<StampedPose2>& poses);

/// Poses of one frame in another over time, in the order of their stamps.
class Trajectory {
 public:
  Trajectory() = default;

  /// Takes poses in any order and sorts them.
  /// Throws EvaluationError for a stamp or pose that is not finite and for two poses of one stamp.
  explicit Trajectory(std::vector<StampedPose2> poses);

  [[nodiscard]] const std::vector<StampedPose2>& poses() const { return poses_; }
  [[nodiscard]] bool empty() const { return poses_.empty(); }
  [[nodiscard]] std::size_t size() const { return poses_.size(); }

  /// The pose at `stamp` [s]: a given one where the stamps are equal to two microseconds, else
  /// interpolated between the two around it, on the straight line and along the shorter arc. None
  /// before the first pose, after the last, and between two that are more than `max_gap` [s] apart.
  [[nodiscard]] std::optional<Pose2> at(double stamp, double max_gap) const;

 private:
  std::vector<StampedPose2> poses_;
};

/// What was estimated and what is true at one stamp.
struct PosePair {
  double stamp = 0.0;  ///< [s]
  Pose2 estimate;
  Pose2 truth;
  std::size_t index = 0;  ///< of the estimate's pose in its trajectory
};

/// The estimate's poses, each with the truth interpolated at its stamp; those without truth are
/// left out. The estimate is never interpolated, which would smooth its error.
/// @param max_gap  longest time between two poses of the truth to interpolate across [s].
[[nodiscard]] std::vector<PosePair> associate(const Trajectory& estimate, const Trajectory& truth,
                                              double max_gap);

/// The same, but throws EvaluationError when one of the two is empty or no pose has truth; the text
/// then names the time ranges of both.
[[nodiscard]] std::vector<PosePair> associate_some(const Trajectory& estimate,
                                                   const Trajectory& truth, double max_gap);

/// Throws EvaluationError when one of the two is empty, and says which.
void require_poses(const Trajectory& estimate, const Trajectory& truth);

/// The first and the last stamp, for messages. The trajectory must not be empty.
[[nodiscard]] std::string time_range_text(const Trajectory& trajectory);

}  // namespace matchbox_slam
