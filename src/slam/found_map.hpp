#pragma once

#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/loops.hpp"

namespace matchbox_slam {

/// Another robot's map that was found to meet this one's, to be taken in while this one goes on.
struct FoundMap {
  /// What became of it.
  enum class Fate { kWaiting, kTaken, kOutdated };

  /// @param own_loops  of this robot's map as it was then.
  /// @param as_one     of both maps, this robot's first.
  FoundMap(PlacedScans own_then, const LoopState& own_loops, KeyScans as_one,
           LoopState loops_as_one)
      : own(std::move(own_then)),
        loops(own_loops.loops.size()),
        tries(own_loops.tries),
        both(std::move(as_one)),
        both_loops(std::move(loops_as_one)) {}

  PlacedScans own;        ///< this robot's, as they were when both were joined; the first ones
  std::size_t loops = 0;  ///< that this robot's map had then
  std::size_t tries = 0;  ///< likewise
  KeyScans both;          ///< this robot's first
  LoopState both_loops;   ///< of these
  mutable std::atomic<Fate> fate{Fate::kWaiting};

  /// Key scans that the other one has.
  [[nodiscard]] std::size_t others() const { return both.size() - own.size(); }

  /// Where this robot's key scans are with the other's map.
  [[nodiscard]] std::vector<Pose2> own_moved() const { return both.poses(own.size()); }

  /// The number that a key scan has when the other robot's have come in, right behind the first:
  /// so the newest one is this robot's, and follows the one that it came from.
  [[nodiscard]] std::size_t number_of(std::size_t own_number) const {
    return own_number == 0 ? 0 : own_number + others();
  }
};

/// The edges of both graphs, of this robot's as it is now.
[[nodiscard]] std::vector<PoseEdge> edges_with(const FoundMap& found,
                                               const std::vector<PoseEdge>& own);

/// The loops of both likewise.
[[nodiscard]] std::vector<ClosedLoop> loops_with(const FoundMap& found,
                                                 std::vector<ClosedLoop> own);

/// The other robot's key scans.
[[nodiscard]] PlacedScans others_of(const FoundMap& found);

}  // namespace matchbox_slam
