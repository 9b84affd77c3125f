#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/slam/key_scans.hpp"

namespace matchbox_slam {

struct LoopOptions {
  double drift_xy = 0.02;
  double drift_theta = 0.01;
  double max_relative_sigma = 0.25;
  double max_window = 10.0;
  double least_score = 0.55;
  double most_rival = 0.9;
  double decisive = 3.5;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.drift_xy, "drift_xy", between(1e-4, 1.0), "m/sqrt(m)",
           "Standard deviation of the map's drift after one metre driven, beside what the matches "
           "say of themselves; it grows with the square root of the way. Loops tell when it is "
           "less.");
    option(self.drift_theta, "drift_theta", between(1e-5, 1.0), "rad/sqrt(m)",
           "Standard deviation of the map's drift in heading after one metre driven. Loops tell "
           "when it is less.");
    option(self.max_relative_sigma, "max_relative_sigma", between(0.01, 10.0), "m",
           "Key scans whose places are known less well than this from where the robot is, by "
           "standard deviation, are not matched against; they are searched for loops.");
    option(self.max_window, "max_window", between(0.5, 30.0), "m",
           "Half width of the search for a loop, at most.");
    option(self.least_score, "least_score", between(0.0, 1.0), "",
           "A loop fits at least this well.");
    option(self.most_rival, "most_rival", between(0.0, 1.0), "",
           "A place is no loop when another one fits more than this share as well.");
    option(
        self.decisive, "decisive", between(-100.0, 100.0), "",
        "Log odds from which on a place is a loop. Each of the newest eight key scans that agrees "
        "with the map there adds up to 0.8, one that does not takes up to 5 away, and so does a "
        "place that is far from where the graph has it.");
  }
};

/// A place that was seen again.
struct FoundLoop {
  std::size_t key = 0;  ///< the key scan that was taken there before
  Pose2 key_from_newest;
  Eigen::Matrix3d covariance;  ///< of that, over (x, y, theta) of the key's frame
  double score = 0.0;
  double rival_share = 0.0;
  double log_odds = 0.0;  ///< against its being none, by the newest key scans
};

/// A loop that was tried, for reports.
struct ClosedLoop {
  FoundLoop found;
  std::size_t newest = 0;   ///< key scan that it was found with
  bool is_inlier = false;   ///< whether the graph can be made to agree
  double chi_square = 0.0;  ///< of the loop in the graph, of 3 degrees of freedom
  double moved = 0.0;       ///< [m] by which it moved the key scan that moved most
};

/// How the key scans of a map have moved, and with them what was seen in between.
struct MapCorrection {
  struct Step {
    double since;        ///< [s] stamp of a key scan; holds until the next one
    Pose2 new_from_old;  ///< map frame, there
  };
  std::vector<Step> steps;  ///< by their stamps
  Pose2 newest;             ///< new_from_old of the newest key scan
};

/// Work under way, as it takes to begin it again.
struct PendingLoopWork {
  std::size_t newest = 0;      ///< key scan that it was begun with
  std::size_t edges = 0;       ///< that the graph had then
  bool is_search_due = false;  ///< for a loop
  bool is_near_due = false;    ///< a map of what lies near
  bool is_abandoned = false;   ///< its result is not to be used
};

/// What it takes to go on closing loops: a value, to be copied and saved. With the key scans, which
/// are its nodes, this is the map's graph.
struct LoopState {
  std::vector<PoseEdge> edges;    ///< of the graph
  std::size_t nodes = 0;          ///< key scans that it has: the first ones
  std::vector<ClosedLoop> loops;  ///< that were tried, inliers and outliers
  double way = 0.0;               ///< [m] since the last search
  std::size_t tries = 0;          ///< places where a loop was searched for
  std::optional<PendingLoopWork> pending = {};
  /// Of each key scan whether it is another robot's, whose stamps say nothing of this one's way; of
  /// those behind the last none is.
  std::vector<bool> are_others = {};
};

/// The graph as it is now.
[[nodiscard]] PoseGraph graph_of(const KeyScans& keys, const LoopState& state);

/// The graph as it was when the work was begun, but for poses that have moved since.
[[nodiscard]] PoseGraph graph_as_of(const PendingLoopWork& begun, const KeyScans& keys,
                                    const LoopState& state);

/// Of loops that were tried, how many are inliers.
[[nodiscard]] std::size_t count_closed(const std::vector<ClosedLoop>& loops);

}  // namespace matchbox_slam
