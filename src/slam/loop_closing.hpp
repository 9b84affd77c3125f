#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <future>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/loops.hpp"
#include "slam/local_map.hpp"
#include "slam/loop_work.hpp"
#include "slam/path_uncertainty.hpp"

namespace matchbox_slam {

/// [m] of way between two searches for a loop.
constexpr double kLoopSearchSpacing = 1.0;

/// How well a place is known that was found anew, over (x, y, theta).
[[nodiscard]] Eigen::Matrix3d covariance_where_found();

/// The newest key scan matched with the nearest ones that are known to lie near by, one of each of
/// at most four visits, of those before a number.
/// @param ways         from the newest.
/// @param may_be_apart  also with one that is hardly known to.
[[nodiscard]] std::vector<FoundLoop> match_with_earlier(const PlacedScans& keys, std::size_t before,
                                                        const PathUncertainty& ways,
                                                        bool may_be_apart,
                                                        const LoopOptions& options);

/// Where key scans are when the first ones have moved: what has come since moves with the one that
/// it came after.
/// @param first  where the first ones are now.
[[nodiscard]] std::vector<Pose2> moved_with(std::vector<Pose2> first, const PlacedScans& keys);

struct FoundMap;

/// Keeps the edges of the graph whose nodes are the key scans of a map, and closes loops in it.
/// What it takes to go on is a value, to be copied and saved: its state, with which work under way
/// is begun again. Key scans are joined to the one before, and to some seen earlier that they are
/// matched with; where the way between two says little of where one is from the other, a search has
/// to find it (several scans at once, against the key scans there; exact, Olson 2009).
///
/// What takes long is begun with one key scan, done in a thread of its own, and takes effect with a
/// later one that does not depend on how long it took: the same drive gives the same bits. Whoever
/// destroys one, or assigns to it, waits for what it does.
class LoopCloser {
 public:
  /// What has come of it.
  struct Result {
    std::optional<MapCorrection> correction;  ///< poses of all key scans that fit together
    std::optional<LocalMap> near;             ///< of the corrected key scans
    std::vector<std::uint64_t> superfluous;   ///< ids of key scans that `near` does without
  };

  LoopCloser() = default;
  explicit LoopCloser(LoopState state);
  [[nodiscard]] const LoopState& state() const { return state_; }

  /// Takes the newest key scan.
  /// @param map_covariance  of its pose by its match, in the map frame.
  /// @param is_continued    whether it was matched on from the key scan before; else where it is is
  ///                        hardly known.
  void add(const KeyScans& keys, const Eigen::Matrix3d& map_covariance, bool is_continued,
           const LoopOptions& options);

  /// The key scans from this one on were moved: where they are from those before is hardly known.
  void move_since(std::size_t first, const KeyScans& keys);

  /// The key scans from this one on are no more.
  void forget_since(std::size_t first);

  /// Begins to search for a loop with the newest key scan, if it is time to, and to make a map of
  /// what lies near; nothing if there is neither to do or work is under way.
  void begin(const KeyScans& keys, LocalMapRequest near, const EngineOptions& options);

  /// Begins work again that was under way when the state was taken.
  /// @param local_map  as it is now.
  void begin_again(const KeyScans& keys, const LocalMap& local_map, const EngineOptions& options);

  /// Whether something was begun that has not taken effect.
  [[nodiscard]] bool is_pending() const { return state_.pending.has_value(); }

  /// Whether what was begun is to take effect now.
  [[nodiscard]] bool is_due(const KeyScans& keys) const;

  /// Waits for what was begun, and lets it take effect: a loop moves the key scans.
  [[nodiscard]] Result finish(KeyScans& keys);

  /// Key scans are no more; the graph keeps what they said of others. Nothing is pending.
  /// @param is_taken  by number; not the first and not the newest.
  /// @return          by number: what it is now; of those that are no more, that of the one that
  ///                  stands for it.
  std::vector<std::size_t> take_out(const std::vector<bool>& is_taken, KeyScans& keys);

  /// Key scans of another robot come in behind the first one; see `slam/found_map.hpp`. Nothing is
  /// pending. Returns how those of this robot have moved.
  MapCorrection take_in(const FoundMap& found, KeyScans& keys);

  /// What is under way will not take effect: the robot is elsewhere than it was thought to be.
  void abandon();

  /// From the newest key scan of the graph.
  [[nodiscard]] PathUncertainty ways(const KeyScans& keys) const {
    return {keys.poses(state_.nodes), state_.edges, links_, state_.nodes - 1};
  }

 private:
  void join_to_before(const PlacedScans& keys, const Eigen::Matrix3d& map_covariance,
                      const LoopOptions& options);
  bool join_to_earlier(const KeyScans& keys, bool is_continued, const LoopOptions& options);
  void join_rigidly(const PlacedScans& keys);
  void inflate_for_slips(const PlacedScans& keys, std::size_t since);
  void take_loops(LoopTaskDone done, const PendingLoopWork& pending);
  [[nodiscard]] MapCorrection correction_of(const PlacedScans& keys,
                                            const std::vector<Pose2>& new_map_from_base) const;
  void index_edges() { links_ = AdjacencyList(state_.nodes, state_.edges); }

  LoopState state_;
  AdjacencyList links_;             ///< of the edges
  std::future<LoopTaskDone> work_;  ///< of what is pending
};

}  // namespace matchbox_slam
