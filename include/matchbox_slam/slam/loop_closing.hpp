#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/slam/graph_distance.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/near_map.hpp"

namespace matchbox_slam {

struct LoopOptions {
  double drift_xy = 0.02;
  double drift_theta = 0.01;
  double apart = 0.25;
  double search_way = 1.0;
  double max_window = 10.0;
  double least_score = 0.55;
  double most_rival = 0.95;
  double most_contradiction = 0.1;
  double least_mutual_fit = 0.55;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.drift_xy, "drift_xy", between(1e-4, 1.0), "m/sqrt(m)",
           "Standard deviation of the map's drift after one metre driven, beside what the matches "
           "say of themselves; it grows with the square root of the way. Loops tell when it is "
           "less.");
    option(self.drift_theta, "drift_theta", between(1e-5, 1.0), "rad/sqrt(m)",
           "Standard deviation of the map's drift in heading after one metre driven. Loops tell "
           "when it is less.");
    option(self.apart, "apart", between(0.01, 10.0), "m",
           "Key scans whose places are known less well than this from where the robot is, by "
           "standard deviation, are not matched against; they are searched for loops.");
    option(self.search_way, "search_way", between(0.0, 100.0), "m",
           "Way between two searches for a loop.");
    option(self.max_window, "max_window", between(0.5, 30.0), "m",
           "Half width of the search for a loop, at most.");
    option(self.least_score, "least_score", between(0.0, 1.0), "",
           "A loop fits at least this well.");
    option(self.most_rival, "most_rival", between(0.0, 1.0), "",
           "A place is no loop when another one fits more than this share as well.");
    option(self.most_contradiction, "most_contradiction", between(0.0, 1.0), "",
           "A place is no loop when more than this share of the beams cross walls there.");
    option(self.least_mutual_fit, "least_mutual_fit", between(-1.0, 1.0), "",
           "A loop fits at least this well on ground that was seen both times, less the shares of "
           "what either time saw where the other saw free ground, and of beams that cross walls.");
  }
};

/// A place that was seen again.
struct FoundLoop {
  std::size_t key = 0;  ///< the key scan that was taken there before
  Pose2 key_from_newest;
  Eigen::Matrix3d covariance;  ///< of that, over (x, y, theta) of the key's frame
  double score = 0.0;
  double rival_share = 0.0;
  double contradiction = 0.0;
};

/// A loop that was tried, for reports.
struct ClosedLoop {
  FoundLoop found;
  std::size_t newest = 0;   ///< key scan that it was found with
  bool believed = false;    ///< whether the graph can be made to agree
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

/// A map of what lies near, to be made beside the mapping.
struct NearRequest {
  std::optional<NearScans> scans;  ///< none: only when a loop moves the key scans
  MapOptions map;
  LikelihoodFieldOptions field;
};

/// A loop moves nothing unless it would move a key scan by more than this share of a cell: what is
/// matched lies better than that, and the map and the robot in it stay together.
constexpr double kLeastMoved = 0.1;

struct LoopTaskDone;
struct LoopWork;

/// Keeps the graph of the key scans of a map, and closes loops in it: a value, to be copied and
/// saved. Copies share the work under way, and are finished in one thread. Key scans are joined to
/// the one before, and to one seen earlier that they are matched with; where the way between two
/// says little of where one is from the other, a search has to find it (several scans at once,
/// against the key scans there; exact, Olson 2009).
///
/// What takes long is begun with one key scan, done in a thread of its own, and takes effect with a
/// later one that does not depend on how long it took: the same drive gives the same bits.
class LoopCloser {
 public:
  /// Work under way, as it takes to begin it again.
  struct Pending {
    std::size_t newest = 0;      ///< key scan that it was begun with
    std::size_t edges = 0;       ///< that the graph had then
    bool is_search_due = false;  ///< for a loop
    bool is_near_due = false;    ///< a map of what lies near
    bool is_abandoned = false;   ///< its result is not to be used
  };

  /// What it takes to go on.
  struct State {
    PoseGraph graph;
    std::vector<ClosedLoop> loops;
    double way = 0.0;  ///< [m] since the last search
    std::size_t tries = 0;
    std::optional<Pending> pending = {};
  };

  /// What has come of it.
  struct Result {
    std::optional<MapCorrection> correction;  ///< poses of all key scans that fit together
    std::optional<NearMap> near;              ///< of the corrected key scans
  };

  LoopCloser() = default;
  explicit LoopCloser(State state);
  [[nodiscard]] State state() const { return {graph_, loops_, way_, tries_, pending_}; }

  /// Takes the newest key scan.
  /// @param map_covariance  of its pose by its match, in the map frame.
  /// @param is_continued    whether it was matched on from the key scan before; else where it is is
  ///                        hardly known.
  void add(const KeyScans& keys, const Eigen::Matrix3d& map_covariance, bool is_continued,
           const LoopOptions& options);

  /// The key scans from this one on have moved: where they are from those before is hardly known.
  void move_since(std::size_t first, const KeyScans& keys);

  /// The key scans from this one on are no more.
  void forget_since(std::size_t first);

  /// Begins to search for a loop with the newest key scan, if it is time to, and to make a map of
  /// what lies near; nothing if there is neither to do or work is under way.
  void begin(const KeyScans& keys, NearRequest near, const LoopOptions& options);

  /// Begins work again that was under way when the state was taken.
  void begin_again(const KeyScans& keys, NearRequest near, const LoopOptions& options);

  /// Whether something was begun that has not taken effect.
  [[nodiscard]] bool is_pending() const { return pending_.has_value(); }

  /// Whether what was begun is to take effect now.
  [[nodiscard]] bool is_due(const KeyScans& keys) const;

  /// Waits for what was begun, and lets it take effect.
  [[nodiscard]] Result finish(const KeyScans& keys);

  /// What is under way will not take effect: the robot is elsewhere than it was thought to be.
  void abandon();

  /// Whether each of some key scans, by their numbers, lies apart from the newest: hardly known
  /// where, and far in the graph.
  [[nodiscard]] std::vector<bool> apart(const std::vector<std::size_t>& keys,
                                        const LoopOptions& options) const;

  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] const std::vector<ClosedLoop>& loops() const { return loops_; }
  [[nodiscard]] std::size_t closed() const;  ///< loops that were believed
  /// Places where a loop was searched for.
  [[nodiscard]] std::size_t tries() const { return tries_; }
  [[nodiscard]] bool empty() const { return graph_.poses.empty(); }

 private:
  [[nodiscard]] GraphWays ways() const { return {graph_, links_, graph_.poses.size() - 1}; }
  void join_to_before(const PlacedScans& keys, const Eigen::Matrix3d& map_covariance,
                      const LoopOptions& options);
  bool join_to_earlier(const KeyScans& keys, bool is_continued, const LoopOptions& options);
  void join_rigidly(const PlacedScans& keys);
  void allow_for_hidden_ways(const PlacedScans& keys, std::size_t since);
  void take_loops(LoopTaskDone done, const Pending& pending);

  PoseGraph graph_;
  GraphLinks links_;  ///< of the graph
  std::vector<ClosedLoop> loops_;
  double way_ = 0.0;  ///< [m] since the last search
  std::size_t tries_ = 0;
  std::optional<Pending> pending_;
  std::shared_ptr<LoopWork> work_;  ///< of what is pending; copies share it
};

}  // namespace matchbox_slam
