#pragma once

#include <cstddef>
#include <vector>

#include "evaluation/error_statistics.hpp"
#include "geometry/trajectory.hpp"

namespace matchbox_slam {

/// How an estimate is moved onto the truth before they are compared. A map frame starts where the
/// robot started, so its place in the truth's frame is no error of the mapping.
enum class Alignment {
  kNone,  ///< not at all
  kSe2,   ///< by the shift and rotation of least squared distance between positions
};

/// The motion of the estimate that brings its positions nearest to the true ones, in the sense of
/// least squares; without scale (Umeyama 1991; in the plane it has a closed form). Headings play no
/// part, unless the true positions lie within 5 cm (root mean square) and leave the rotation open:
/// then their mean difference is it.
/// @param pairs  at least one. Throws EvaluationError when there is none.
[[nodiscard]] Pose2 align_se2(const std::vector<PosePair>& pairs);

struct AbsoluteTrajectoryErrorOptions {
  Alignment alignment = Alignment::kSe2;
  double max_gap = kDefaultMaxGap;  ///< [s], truth is not interpolated across more than this
};

/// How far an estimate is from the truth over all (ATE; Sturm et al. 2012).
struct AbsoluteTrajectoryError {
  ErrorStatistics translation;    ///< [m], over the poses that have truth
  double heading_rmse = 0.0;      ///< [rad], after alignment
  std::size_t without_truth = 0;  ///< poses of the estimate that could not be compared
  Alignment alignment = Alignment::kSe2;
  Pose2 truth_from_estimate;            ///< what the alignment moved the estimate by
  std::vector<PosePair> aligned_pairs;  ///< what was compared: by stamp, the estimate aligned
};

/// Compares every pose of the estimate with the truth interpolated at its stamp.
/// Throws EvaluationError when one of the two is empty or fewer than two poses have truth; the text
/// then names the time ranges of both.
[[nodiscard]] AbsoluteTrajectoryError absolute_trajectory_error(
    const Trajectory& estimate, const Trajectory& truth,
    const AbsoluteTrajectoryErrorOptions& options = {});

}  // namespace matchbox_slam
