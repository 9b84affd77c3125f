#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "geometry/trajectory.hpp"
#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/engine_options.hpp"

namespace matchbox_slam {

/// A scan and where it was truly measured.
struct LocatedScan {
  LaserScan scan;
  Eigen::Isometry3d base_from_laser = Eigen::Isometry3d::Identity();
  Pose2 motion;  ///< pose of the base at the last beam in the base at the first
  Pose2 world_from_base;
  std::size_t number = 0;  ///< of the scan in the recording, which holds others without truth
  Eigen::Isometry3d laser_motion = Eigen::Isometry3d::Identity();  ///< as of ScanInput
};

/// Which pairs of scans to match, and how wrong the guess is.
struct PairOptions {
  int pairs = 1000;
  int gap = 10;
  double error_xy = 0.2;
  double error_theta = 0.2;
  std::string error_draw = "box";
  double told_xy = 0.0;
  double told_theta = 0.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.pairs, "pairs", between(1, 1e6), "", "Pairs of scans to match.");
    option(self.gap, "gap", between(1, 1e6), "", "How many scans the two of a pair are apart.");
    option(self.error_xy, "error_xy", between(0.0, 10.0), "m",
           "The guess is off by up to this along x, and along y.");
    option(self.error_theta, "error_theta", between(0.0, kPi), "rad",
           "The guess is off by up to this in its heading.");
    option(
        self.error_draw, "error_draw", one_of({"box", "size"}), "",
        "box: x, y and heading are each off by anything up to their limits; size: by one share "
        "of both limits, which is anything up to 1, in any direction and to either side, so that "
        "errors of every size are as frequent.");
    option(self.told_xy, "told_xy", between(0.0, 10.0), "m",
           "What the matchers are told that the guess is off by at most, along x, and along y; 0: "
           "error_xy.");
    option(self.told_theta, "told_theta", between(0.0, kPi), "rad",
           "The same of its heading; 0: error_theta.");
  }
};

/// Two scans and a guess of the motion between them.
struct ScanPair {
  std::size_t reference = 0;  ///< index of the scan to match against
  std::size_t scan = 0;       ///< index of the scan to match
  Pose2 reference_from_base;  ///< truth: the base at the scan in the base at the reference
  Pose2 guess;                ///< of the same
  Eigen::Matrix3d guess_covariance = Eigen::Matrix3d::Zero();
  std::uint64_t seed = 0;  ///< for the matcher
};

/// Draws pairs of scans whose numbers are `gap` apart, each as likely as any other, and one more
/// than once where there are fewer than asked for. To the true motion an error is added. The
/// guess's covariance is that of errors uniform within what is told, which need not be true, but
/// not below what the motion prior says of a robot at rest: who is certain of the guess need not
/// match. All this depends on the seed alone, not on who matches.
/// @param scans  in the order of their numbers.
/// Throws EvaluationError when no two scans are `gap` apart.
[[nodiscard]] std::vector<ScanPair> draw_pairs(const std::vector<LocatedScan>& scans,
                                               const PairOptions& options,
                                               const MotionPriorOptions& least_uncertainty,
                                               std::uint64_t seed);

/// What a matcher made of a pair.
struct PairMatch {
  MatchResult result;    ///< in the frame of the base at the reference
  double seconds = 0.0;  ///< that the match took, of its thread's time on a processor
};

/// Told how many pairs are done; returns whether to go on. Called from the calling thread only.
using PairProgress = std::function<bool(std::size_t done)>;

/// Lets each matcher match all pairs: scan to a map made of the reference alone, which is the only
/// key scan too. All but the seconds is the same for any number of threads.
/// @param threads  >= 1; fewer where the system gives no more.
/// @return one row a matcher, each with one entry a pair; of the first pairs alone when told not to
/// go on.
/// Throws what a matcher throws.
[[nodiscard]] std::vector<std::vector<PairMatch>> match_pairs(
    const std::vector<LocatedScan>& scans, const std::vector<ScanPair>& pairs,
    const std::vector<std::shared_ptr<const ScanMatcher>>& matchers, const EngineOptions& options,
    int threads, const PairProgress& progress);

}  // namespace matchbox_slam
