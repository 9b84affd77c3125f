#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"
#include "slam/local_map.hpp"
#include "slam/loop_closing.hpp"

namespace matchbox_slam {

/// A loop to be searched for in a map as it was when one of its key scans was the newest.
struct LoopSearch {
  PlacedScans keys;
  PoseGraph graph;
  LoopOptions options;
};

/// What is to be done beside the mapping: a search, a map of what lies near, or both.
struct LoopTask {
  std::optional<LoopSearch> search;
  LocalMapRequest near;
};

struct LoopTaskDone {
  PoseGraph graph;                ///< of a search: with the loops that were found
  bool has_moved = false;         ///< the poses are where they put them
  std::vector<ClosedLoop> loops;  ///< that were found; only the last one may be an inlier
  std::size_t tries = 0;
  std::optional<LocalMap> near;  ///< when it was asked for, or the key scans have moved
  /// Ids of key scans that it does without, in their order.
  std::vector<std::uint64_t> superfluous;
};

/// Of the search's key scans where its graph has them, in which it is known how they lie.
[[nodiscard]] LocalScans local_scans_of(const LoopSearch& search);

/// Searches the places where the newest key scan may have been taken, too, until one is an
/// inlier. The key scans may be the first ones of those that the graph has.
/// @param least_moved  [m]; see kMinMoveInCells
/// @param done         its loops, tries and whether the graph's poses have moved.
void close_a_loop(LoopSearch& search, double least_moved, LoopTaskDone& done);

/// A task under way, in a thread of its own.
struct LoopWork {
  std::shared_future<std::shared_ptr<LoopTaskDone>> done;
};

[[nodiscard]] std::shared_ptr<LoopWork> begin_work(LoopTask task);

/// Waits for it. What came of it is copied only where others still want it; else it is gone.
[[nodiscard]] LoopTaskDone result_of(const std::shared_ptr<LoopWork>& work);

}  // namespace matchbox_slam
