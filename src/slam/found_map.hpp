#pragma once

#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/slam/loops.hpp"
#include "slam/map_joining.hpp"

namespace matchbox_slam {

/// Another robot's map that was found to meet this one's, to be taken in while this one goes on.
struct FoundMap {
  /// What became of it.
  enum class Fate { kWaiting, kTaken, kOutdated };

  /// @param own_loops  of this robot's map as it was then.
  FoundMap(PlacedScans own_then, const LoopState& own_loops, MergedMap as_one)
      : own(std::move(own_then)),
        loops(own_loops.loops.size()),
        tries(own_loops.tries),
        both(std::move(as_one)) {}

  PlacedScans own;        ///< this robot's, as they were when both were joined; the first ones
  std::size_t loops = 0;  ///< that this robot's map had then
  std::size_t tries = 0;  ///< likewise
  MergedMap both;         ///< this robot's key scans first
  mutable std::atomic<Fate> fate{Fate::kWaiting};

  /// Key scans that the other one has.
  [[nodiscard]] std::size_t others() const { return both.part.key_scans.size() - own.size(); }

  /// The number that a key scan has when the other robot's have come in, right behind the first:
  /// so the newest one is this robot's, and follows the one that it came from.
  [[nodiscard]] std::size_t number_of(std::size_t own_number) const {
    return own_number == 0 ? 0 : own_number + others();
  }
};

/// Whether this robot's key scans still are where they were when both were joined.
[[nodiscard]] bool is_up_to_date(const FoundMap& found, const PlacedScans& keys);

/// Where this robot's key scans are with the other's map. What has come since moves with the key
/// scan that it came after.
[[nodiscard]] std::vector<Pose2> poses_with(const FoundMap& found, const PlacedScans& keys);

/// The graph of both, of this robot's as it is now.
/// @param own_poses  as of `poses_with`.
[[nodiscard]] PoseGraph graph_with(const FoundMap& found, const PoseGraph& own,
                                   const std::vector<Pose2>& own_poses);

/// The loops of both likewise.
[[nodiscard]] std::vector<ClosedLoop> loops_with(const FoundMap& found,
                                                 std::vector<ClosedLoop> own);

/// The other robot's key scans.
[[nodiscard]] PlacedScans others_of(const FoundMap& found);

}  // namespace matchbox_slam
