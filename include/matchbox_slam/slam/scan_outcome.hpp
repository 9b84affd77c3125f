#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/slam/loops.hpp"

namespace matchbox_slam {

/// What a scan says for a pose, against its having been taken where nothing is known.
struct ScanEvidence {
  double log_odds = 0.0;  ///< natural logarithm
  double mean = 0.0;      ///< of a beam, -3 to 3
  double known = 0.0;     ///< share of the beams that end where something is known, 0...1
  /// Share of the beams that tell of walls: that end on a known one, or would have gone through
  /// one. Those that end on free ground, where something new stands in the way, do not.
  double telling = 0.0;
  double telling_witnesses = 0.0;  ///< half metres of wall that these see
  double telling_mean = 0.0;       ///< of a beam, by these, -3 to 3
};

/// What a scan's pose rests on.
enum class Certainty {
  kSure,       ///< the match, or the matcher was not asked for one
  kOvertaken,  ///< the match of another hypothesis than led before
  kNewGround,  ///< the prediction: what the scan sees is hardly mapped yet
  kUnmatched,  ///< the prediction: no match near is likelier, though what the scan sees is mapped
};

/// A word for logs and reports, such as "new_ground".
[[nodiscard]] const char* to_string(Certainty certainty);

/// How sure it is where the robot is in the map: a reading of the odds, see PoseHypotheses.
enum class TrackingState {
  kTracking,   ///< one hypothesis is far ahead
  kDoubt,      ///< another one may be right; what is seen goes on being mapped
  kLost,       ///< the robot may be anywhere: it maps a component, and searches for the map
  kRecovered,  ///< it was found; its component is being joined to the map
};

/// A word for logs and reports, such as "tracking".
[[nodiscard]] const char* to_string(TrackingState state);

/// What became of one scan.
struct ScanOutcome {
  double stamp = 0.0;
  Pose2 map_from_base;  ///< at the scan's stamp; see without_overshoot for why it may
                        ///< differ from the match's
  /// Over (x, y, theta) in the map frame; while mapping the match's, and that of the map where it
  /// is.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Pose2 predicted_map_from_base;
  std::optional<Pose2> odom_from_base;
  MatchResult match;  ///< status kRejectedNoReference for the scan that starts a map
  bool is_of_secondary_laser = false;  ///< then it was not matched for itself; see SecondaryLasers
  Certainty certainty = Certainty::kSure;
  ScanEvidence evidence;                           ///< where the hypothesis that led before has it
  TrackingState state = TrackingState::kTracking;  ///< after this scan
  /// Set by the scan that finds a lost robot: poses since `begin` were of a component of its own.
  struct Joined {
    double begin;  ///< [s]
    Pose2 map_from_component;
  };
  std::optional<Joined> joined;
  /// Set by the scan that closes a loop: key scans have moved, and what was seen between them.
  std::optional<MapCorrection> corrected;
  bool inserted = false;
  bool gave_up_component = false;  ///< see kMostDisconnectedComponents
  /// Scans that the map has no room for: this one, or what waited.
  std::size_t left_out = 0;
};

/// What became of the scan, a word for logs, tables and reports: that of its match's status, or
/// "of_further_laser".
[[nodiscard]] const char* status_text(const ScanOutcome& outcome);

}  // namespace matchbox_slam
