#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <tuple>
#include <variant>

#include "matchbox_slam/common/parameters.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"

namespace matchbox_slam {

/// Somebody says where the base was at the newest scan, or will be at the first one.
struct SetPose {
  Pose2 map_from_base;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< over (x, y, theta) in the map frame
};

/// The base was found at a pose for an earlier scan; since then it has moved as it was seen to, and
/// nobody has said where it was.
struct CorrectPose {
  double stamp = 0.0;  ///< of that scan [s], which was used since the map was begun
  Pose2 map_from_base;
};

/// Nobody knows where the robot is: it may be anywhere, and is searched for in the map.
struct BeAnywhere {};

/// Map and poses are forgotten.
struct Reset {};

/// They are forgotten, and it goes on with a saved map.
struct LoadMapFile {
  std::string path;
  std::shared_ptr<const EngineState> map;  ///< what the file holds
};

/// Scans are skipped, or used again.
struct Pause {
  bool paused = true;
};

/// Options take other values; see LiveConfiguration for which ones may.
struct Reconfigure {
  Parameters changes;
};

/// The scan that comes next, of just that moment, is left out: a node had no time for it.
struct LeaveOut {};

/// What happens to a run between two scans, but for time jumps.
using RunEvent = std::variant<SetPose, CorrectPose, Reset, LoadMapFile, Pause, Reconfigure,
                              LeaveOut, BeAnywhere>;

/// Whether scans that were to come before the event are wasted on a map that it gives up.
[[nodiscard]] inline bool gives_up_map(const RunEvent& event) {
  return std::holds_alternative<Reset>(event) || std::holds_alternative<LoadMapFile>(event);
}

/// The place of a scan in its run.
struct ScanMoment {
  int time_jumps = 0;  ///< that came before
  double stamp = 0.0;  ///< [s]
  int laser = 0;

  [[nodiscard]] bool operator<(const ScanMoment& other) const {
    return std::tie(time_jumps, stamp, other.laser) <
           std::tie(other.time_jumps, other.stamp, laser);
  }
};

struct TimedEvent {
  ScanMoment scan;  ///< before which it takes effect
  RunEvent event;
};

}  // namespace matchbox_slam
