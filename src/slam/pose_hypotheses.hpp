#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/slam/hypotheses.hpp"
#include "matchbox_slam/slam/scan_outcome.hpp"
#include "motion/motion_tracker.hpp"

namespace matchbox_slam {

/// Log odds, before any scan, against the robot being somewhere unknown, as when it was carried.
constexpr double kPriorAgainstCarried = 9.2;

/// Where the robot may be other than where it is thought to be: on by another motion than odometry
/// tells, at other maxima of the search, or somewhere unknown. The hypotheses compete by what the
/// scans say for each, added up from scan to scan (a sequential test; Wald 1945). The one that
/// leads is where the robot is told to be. Nearly always it is the only one.
///
/// They are compared in the map as it was when the first of them came up, the fork: what is drawn
/// since is drawn where the leading one has it, and would speak for that. A value.
class PoseHypotheses {
 public:
  /// A scan, and what it is compared in.
  struct Step {
    const PointScan& scan;
    const SlamMap& map;      ///< of the fork, if there is one
    const SlamMap& matched;  ///< that the match of the leading hypothesis was made in
    const PlacedScans& key_scans;
    const PlacedScans& recent;  ///< of these, for the matchers
    double seconds;             ///< since the scan before
    const MotionPrediction& predicted;
    /// As the last motion goes on, where odometry tells of an improbable step.
    const std::optional<MotionPrediction>& steady;
  };

  enum class Verdict {
    kLeads,      ///< the leading hypothesis stands, alone or not
    kOvertaken,  ///< another one leads now
    kUnknown,    ///< the robot is somewhere unknown
  };
  struct Outcome {
    Verdict verdict = Verdict::kLeads;
    MatchResult match;      ///< of the hypothesis that leads now
    Pose2 before;           ///< where the one has the robot that led before, of kOvertaken
    ScanEvidence evidence;  ///< for the one that led before
    bool is_jump = false;   ///< the match is where no motion leads to
    /// Where the hypothesis that overtook has the key scans since the fork.
    std::vector<std::optional<Pose2>> key_scans;
  };

  PoseHypotheses() = default;
  explicit PoseHypotheses(HypothesesState state) : state_(std::move(state)) {}
  [[nodiscard]] const HypothesesState& state() const { return state_; }

  /// Whether a match is where no motion leads to.
  [[nodiscard]] static bool is_jump(const MatchResult& match, const MotionPrediction& predicted);

  /// Weighs a scan.
  /// @param match  of the leading hypothesis; a rejected one has its prediction. Where an accepted
  ///               one is unexpected, evidence and prior have to speak for it.
  [[nodiscard]] Outcome follow(const Step& step, MatchResult match,
                               const HypothesisOptions& options);

  /// Whether there are others, possible or not.
  [[nodiscard]] bool is_forked() const { return state_.fork.has_value(); }
  /// Whether another one may be right: its odds are not decided.
  [[nodiscard]] bool is_in_doubt(const HypothesisOptions& options) const;

  /// Of where the robot may be, beside the leading pose: over (x, y, theta) in the map frame.
  [[nodiscard]] Eigen::Matrix3d spread_around(const Pose2& leading) const;

  /// The newest scan was inserted, and maybe those of other lasers.
  /// @param leading  pose of the base at that scan.
  void note_key_scans(const PlacedScans& all, const Pose2& leading);
  /// Those since the fork are no more.
  void forget_key_scans();
  /// A scan is not weighed: all others go on by its motion, and what the next one sees is not
  /// compared with the one before.
  void leave_out(const MotionEstimate& motion);
  /// Nothing is known but that the robot was carried, and may be carried on.
  void begin_lost();
  /// The leading hypothesis is right.
  void believe();

 private:
  double note_change(const Step& step);
  [[nodiscard]] static std::optional<PoseHypothesis> refuse_unexpected(
      const Step& step, const HypothesisOptions& options, Outcome& outcome);
  void weigh_elsewhere(const Step& step, double odds, const Outcome& outcome);
  void move_others(const Pose2& previous_from_current);
  void weigh_others(const Step& step, double leading, double share);
  void note_motion(const Step& step, double leading);
  [[nodiscard]] bool is_search_due(const Outcome& outcome, bool is_odometry_improbable) const;
  void consider_steady(const Step& step, const Pose2& leading, double share);
  void search(const Step& step, const Outcome& outcome, double share);
  void begin_fork(const Step& step);
  /// The other one at a pose, or the end of all.
  [[nodiscard]] std::vector<PoseHypothesis>::iterator same_as(const Pose2& map_from_base);
  void add(const Pose2& map_from_base, double log_odds);
  void keep_likeliest();
  void drop_refuted(const Pose2& leading, const HypothesisOptions& options);
  void decide(const Step& step, const HypothesisOptions& options, Outcome& outcome);
  void lead(std::vector<PoseHypothesis>::iterator overtaking, const Step& step, Outcome& outcome);

  HypothesesState state_;
};

}  // namespace matchbox_slam
