#pragma once

#include <cstddef>
#include <future>
#include <optional>
#include <vector>

#include "matchbox_slam/graph/pose_graph.hpp"
#include "matchbox_slam/slam/loop_closing.hpp"
#include "matchbox_slam/slam/near_map.hpp"

namespace matchbox_slam {

/// What is to be done for a map as it was when one of its key scans was the newest.
struct LoopTask {
  PlacedScans keys;
  PoseGraph graph;
  bool is_search_due = false;
  NearRequest near;
  LoopOptions options;
};

struct LoopTaskDone {
  PoseGraph graph;                ///< with the loops that were found
  bool has_moved = false;         ///< the poses are where they put them
  std::vector<ClosedLoop> loops;  ///< that were found; only the last one may be believed
  std::size_t tries = 0;
  std::optional<NearMap> near;  ///< when it was asked for, or the key scans have moved
};

[[nodiscard]] LoopTaskDone do_loop_task(const LoopTask& task);

/// A task under way, in a thread of its own.
struct LoopWork {
  std::shared_future<LoopTaskDone> done;
};

}  // namespace matchbox_slam
