#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <optional>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/loops.hpp"
#include "slam/local_map.hpp"

namespace matchbox_slam {

/// A loop moves nothing unless it would move a key scan by more than this share of a cell: what is
/// matched lies better than that, and the map and the robot in it stay together.
constexpr double kMinMoveInCells = 0.1;

/// A map of what lies near, to be made beside the mapping.
struct LocalMapRequest {
  std::optional<LocalScans> scans;  ///< none: only when a loop moves the key scans
  LocalMap before = {};             ///< what it may go on from while nothing moves
};

/// A loop to be searched for in a map as it was when one of its key scans was the newest.
struct LoopSearch {
  PlacedScans keys;
  PoseGraph graph;
};

/// What is to be done beside the mapping: a search, a map of what lies near, or both.
struct LoopTask {
  EngineOptions options;
  LocalMapRequest near;
  std::optional<LoopSearch> search = {};
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
[[nodiscard]] LocalScans local_scans_of(const LoopSearch& search, const LoopOptions& options);

/// Searches the places where the newest key scan may have been taken, too, until one is an
/// inlier. The key scans may be the first ones of those that the graph has.
/// @param done  its loops, tries and whether the graph's poses have moved.
void close_a_loop(const EngineOptions& options, LoopSearch& search, LoopTaskDone& done);

/// Begins a task in a thread of its own.
[[nodiscard]] std::future<LoopTaskDone> begin_work(LoopTask task);

}  // namespace matchbox_slam
