#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "evaluation/error_statistics.hpp"
#include "geometry/trajectory.hpp"

namespace matchbox_slam {

/// Which two poses of an estimate make a pair.
struct PairRule {
  enum class Unit {
    kScan,    ///< each pose and the next of the estimate
    kSecond,  ///< each pose and the one nearest to `step` [s] later
    kMetre,   ///< each pose and the one after it nearest to `step` [m] of the truth's path
    kRadian,  ///< ... nearest to `step` [rad] of the truth's turning, left and right alike
  };
  Unit unit = Unit::kScan;
  double step = 1.0;  ///< of its unit; not used for scans
};

struct RelativePoseErrorOptions {
  std::vector<PairRule> rules = {{PairRule::Unit::kScan, 1.0},   {PairRule::Unit::kSecond, 1.0},
                                 {PairRule::Unit::kMetre, 1.0},  {PairRule::Unit::kMetre, 5.0},
                                 {PairRule::Unit::kMetre, 10.0}, {PairRule::Unit::kRadian, 1.0}};
  double max_gap = kDefaultMaxGap;  ///< [s], truth is not interpolated across more than this
  double tolerance = 0.1;           ///< >= 0, how far a pair may be from the step, as a share of it
};

struct RelativeDifference {
  double stamp = 0.0;        ///< [s], of the first pose of the pair
  double translation = 0.0;  ///< [m]
  double rotation = 0.0;     ///< [rad], >= 0
};

/// The errors of all pairs of one rule.
struct RelativePoseErrorMeasure {
  PairRule rule;
  std::vector<RelativeDifference> differences;  ///< by stamp; may be empty
  std::optional<ErrorStatistics> translation;   ///< [m]; none without pairs
  std::optional<ErrorStatistics> rotation;      ///< [rad]; none without pairs
};

struct RelativePoseError {
  std::vector<RelativePoseErrorMeasure> measures;  ///< one for each rule, in their order
  std::size_t without_truth = 0;  ///< poses of the estimate that could not be compared
};

/// How much an estimate drifts (RPE; Sturm et al. 2012; over distances as Geiger et al. 2012): for
/// poses i and j of the estimate P, with truth T interpolated at their stamps, the error is
/// `(T_i^-1 T_j)^-1 (P_i^-1 P_j)`. A rigid motion of either trajectory changes nothing.
///
/// Path and turning are those of the truth's own poses, with straight lines between them; nothing
/// is known of them across gaps of more than `max_gap`, so no pair of kMetre or kRadian spans one.
/// Noise of the truth counts as path and turning, too.
///
/// Throws EvaluationError when one of the two is empty, no pose has truth (the text then names the
/// time ranges of both), or no rule finds a pair; std::invalid_argument for options that are not
/// allowed.
[[nodiscard]] RelativePoseError relative_pose_error(const Trajectory& estimate,
                                                    const Trajectory& truth,
                                                    const RelativePoseErrorOptions& options = {});

}  // namespace matchbox_slam
