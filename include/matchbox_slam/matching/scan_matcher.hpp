#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/matching/key_scan.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// One question to a matcher. All of it outlives the call to `match`.
struct MatchProblem {
  const PointScan& scan;             ///< in the base frame
  Pose2 predicted_map_from_base;     ///< where motion alone puts the base
  Eigen::Matrix3d prior_covariance;  ///< of the prediction, over (x, y, theta) in the map frame
  const LikelihoodField& field;      ///< the map so far, for matchers of scan to map
  const PlacedScans& recent_scans;   ///< the map's last ones, for matchers of scan to scan
  std::uint64_t seed;                ///< the only source of randomness
  /// How far off the prediction may be, where that is more than the prior says: what earlier
  /// matches taught may weigh what a search finds, and not narrow the search to what confirms it.
  std::optional<Eigen::Matrix3d> search_covariance = {};

  /// The prior to search with; what is found is refined with `prior_covariance`.
  [[nodiscard]] const Eigen::Matrix3d& searched_covariance() const {
    return search_covariance ? *search_covariance : prior_covariance;
  }
};

enum class MatchStatus {
  kAccepted,
  kRejectedNoReference,   ///< nothing to match against yet
  kRejectedTooFewPoints,  ///< the scan says too little
  kRejectedLowScore,      ///< even the best pose explains too little of the scan
  kRejectedUnexpected,    ///< by the engine: it is likelier where its motion leads to
  kRejectedInvalidPrior,  ///< the prediction or its covariance is not a number
};

/// A word for logs, tables and reports, such as "accepted" or "rejected_low_score".
[[nodiscard]] const char* to_string(MatchStatus status);

/// What is known about the optimality of an exhaustive search's answer: it speaks of the poses of
/// the search lattice, not of the pose that refinement makes of the best of them.
struct OptimalityProof {
  double best_score = 0.0;       ///< of the best pose of the lattice
  double remaining_bound = 0.0;  ///< no pose of the window that was not looked at scores higher
  Pose2 map_from_base;           ///< the best pose of the lattice
  /// The window is narrower than the prior, or the configuration, asks for: nobody looked beyond.
  bool clipped = false;
  /// The best pose lies on the edge of the window: a better one may lie beyond.
  bool on_edge = false;

  /// By how much a pose of the window might score more at most.
  [[nodiscard]] double gap() const {
    return remaining_bound > best_score ? remaining_bound - best_score : 0.0;
  }
  /// No pose of the lattice scores higher in all of the window that was asked for.
  [[nodiscard]] bool is_proven() const { return gap() == 0.0 && !clipped; }
};

/// A matcher's answer. When rejected, pose and covariance are the prior's.
struct MatchResult {
  Pose2 map_from_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< over (x, y, theta) in the map frame
  double score = 0.0;                                    ///< how well the scan fits, 0...1
  MatchStatus status = MatchStatus::kRejectedNoReference;
  /// Unit directions of the map frame in which the surroundings do not hold the scan, such as along
  /// a corridor. There the prior alone decides the pose and its variance.
  std::vector<Eigen::Vector2d> unconstrained_directions;
  std::size_t candidates = 0;  ///< poses evaluated
  std::optional<OptimalityProof> proof;
  /// Score of the best pose far from the answer, as a share of the answer's: near 1 the scan fits
  /// two places alike. 0: none was found, or the matcher does not look for one.
  double rival_share = 0.0;
  /// How far refinement moved the answer from where the search ended: (x [m], y [m], theta [rad])
  /// in the map frame. Zero for a rejected match, and of a matcher that does not refine.
  Eigen::Vector3d refined_by = Eigen::Vector3d::Zero();

  [[nodiscard]] bool accepted() const { return status == MatchStatus::kAccepted; }
  /// The search's own answer: where it ended, before anything refined it.
  [[nodiscard]] Pose2 searched_map_from_base() const {
    return displaced(map_from_base, -refined_by);
  }
};

/// A scan matcher. Pure: the same problem yields the same bits, whatever was asked before, from one
/// thread or from many at once. All state is the configuration.
///
/// Life of a plugin: default-constructed, `configure` once from one thread, then `match` any number
/// of times from any thread.
class ScanMatcher {
 public:
  ScanMatcher() = default;
  ScanMatcher(const ScanMatcher&) = delete;
  ScanMatcher& operator=(const ScanMatcher&) = delete;
  virtual ~ScanMatcher() = default;

  /// Takes the matcher's own parameters, without the matcher's name in front of the keys.
  /// Throws ConfigurationError for an unknown key or a bad value; then nothing has changed.
  virtual void configure(const Parameters& parameters) = 0;

  /// The options in effect, one row each.
  [[nodiscard]] virtual std::vector<OptionDescription> options() const = 0;

  /// Finds the pose of the scan. Never throws for any content of the scan or the prior: what cannot
  /// be matched is rejected, with the reason as status and the prior as pose.
  [[nodiscard]] virtual MatchResult match(const MatchProblem& problem) const = 0;
};

/// Whether a matrix is symmetric and positive semidefinite, zero included.
[[nodiscard]] bool is_covariance(const Eigen::Matrix3d& covariance);

/// Whether the prediction is a pose and its covariance one.
[[nodiscard]] bool is_valid_prior(const MatchProblem& problem);

/// The answer when there is no match: the prior, and why.
[[nodiscard]] MatchResult rejected(const MatchProblem& problem, MatchStatus why);

/// The rejection of a problem that no matcher of scan to map can solve: an invalid prior, a scan
/// without points, an empty map. None: there is something to match.
[[nodiscard]] std::optional<MatchResult> reject_unmatchable(const MatchProblem& problem);

/// The same for matchers of scan to scan, which need a key scan and no map.
[[nodiscard]] std::optional<MatchResult> reject_unmatchable_to_scans(const MatchProblem& problem);

}  // namespace matchbox_slam
