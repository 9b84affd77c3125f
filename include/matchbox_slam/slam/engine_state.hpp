#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/lasers/secondary_lasers.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/motion/motion_state.hpp"
#include "matchbox_slam/slam/engine_options.hpp"
#include "matchbox_slam/slam/hypotheses.hpp"
#include "matchbox_slam/slam/key_scans.hpp"
#include "matchbox_slam/slam/loops.hpp"
#include "matchbox_slam/slam/map_component.hpp"
#include "matchbox_slam/slam/place_search.hpp"

namespace matchbox_slam {

/// Where the robot is, where else it may be, and what waits to be inserted.
struct LocalizationState {
  HypothesesState hypotheses;
  std::map<int, Pose2> inserted_before_fork;  ///< map_from_base by laser, where there is a fork
  std::vector<WaitingScan> pending;           ///< inserted a few with each scan, oldest first
  std::vector<MapComponent> components;  ///< that the robot made while it was lost, not yet joined
  std::size_t active = 0;  ///< the component that it is in: 0 the map, n components[n - 1]
  PlaceSearch search;
};

/// What a local map shows: it is drawn anew from its key scans.
struct LocalMapContents {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  std::vector<std::uint64_t> drawn;  ///< key scans, by id, in the order in which they were drawn
};

/// All that an engine knows: what it takes to go on from there as if nothing had been between.
struct EngineState {
  SlamMap map;  ///< its field is rendered if it is matched against
  KeyScans key_scans;
  MotionState motion;                  ///< in the map frame
  std::map<int, Pose2> last_inserted;  ///< map_from_base, by laser
  std::uint64_t scan_count = 0;
  LocalizationState localization = {};
  LoopState loops = {};
  std::optional<LocalMapContents> local_map = {};  ///< none: the whole map is matched against
  bool is_moved = false;      ///< by loops, and matched against local_map alone since
  bool is_continued = false;  ///< the newest key scan is from where the base is
  /// Made of its key scans alone. Loops are not closed in one that holds walls that came without:
  /// nobody knows how they would move.
  bool is_of_key_scans = true;
  SecondaryLasers secondary_lasers = {};

  /// Keeps the map alone: the base may be here, and how it moves is not known.
  /// @param covariance  over (x, y, theta) in the map frame.
  void begin_anew(const Pose2& map_from_base, const Eigen::Matrix3d& covariance);

  /// The clock by which it goes on is so far [s] ahead of the one by which it was made: stamps that
  /// are compared with those of the next scans are moved, those of key scans stay.
  void shift_clock(double seconds);
};

/// Throws ConfigurationError when the map was made with another resolution or likelihood field.
void check_map(const SlamMap& map, const EngineOptions& options);

}  // namespace matchbox_slam
