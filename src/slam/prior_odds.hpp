#pragma once

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"

namespace matchbox_slam {

/// Log odds, before any scan, against a pose that the motion does not lead to: a guess.
constexpr double kPriorAgainstJump = 7.0;

/// Log density at a pose, against that where the motion leads to, of two priors: mostly odometry
/// errs as earlier matches showed, and seldom by anything that the search looks through. The wider
/// prior is less dense at each place: the better odometry has shown to be, the less likely is a
/// pose elsewhere.
[[nodiscard]] double prior_log_odds(const MatchProblem& problem, const Pose2& pose);

/// Whether a pose is where the motion hardly leads to, by what earlier matches showed of it.
[[nodiscard]] bool is_unexpected(const MatchProblem& problem, const Pose2& pose);

}  // namespace matchbox_slam
