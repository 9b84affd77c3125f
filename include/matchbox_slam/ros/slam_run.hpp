#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "matchbox_slam/evaluation/trajectory.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/ros/scan_queue.hpp"
#include "matchbox_slam/ros/slam_setup.hpp"
#include "matchbox_slam/ros/timed_matcher.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"

namespace matchbox_slam {

/// What to tell people of a scan that the map has no room for.
constexpr const char* kLeftOut =
    "a scan is left out of the map, which would have more cells than map/max_cells allows; is its "
    "pose a wild one?";

/// How the queue is to be set up for a configuration.
/// @param scan_time_offset  [s], what 'auto' has come to.
[[nodiscard]] ScanQueueSettings queue_settings(const RunOptions& options, double scan_time_offset);

/// The engine at work, and a record of what it did since its start or last reset. The node and
/// map_bag both run this, so that they yield the same.
class SlamRun {
 public:
  explicit SlamRun(const SlamSetup& setup);

  /// Processes the next scan of the queue.
  ScanOutcome process(const ScanInput& input);

  /// Tells where the base is in the map, for the next scan; as SlamEngine::set_pose.
  void set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
    engine_->set_pose(map_from_base, covariance);
  }

  /// Forgets map, poses and records, as if just made.
  void reset();

  [[nodiscard]] const SlamMap& map() const { return engine_->map(); }
  [[nodiscard]] const KeyScans& key_scans() const { return engine_->key_scans(); }

  /// Poses of the base in the map, one a scan.
  [[nodiscard]] const std::vector<StampedPose2>& trajectory() const { return trajectory_; }
  /// Raw odometry at the same stamps; empty when there is none.
  [[nodiscard]] const std::vector<StampedPose2>& odometry() const { return odometry_; }

  /// Seconds that each match took; scans that were not matched have no entry.
  [[nodiscard]] const std::vector<float>& match_seconds() const { return match_seconds_; }
  /// Seconds that each scan took from projection to insertion.
  [[nodiscard]] const std::vector<float>& scan_seconds() const { return scan_seconds_; }

  [[nodiscard]] const std::map<MatchStatus, std::size_t>& statuses() const { return statuses_; }
  [[nodiscard]] std::size_t inserted() const { return inserted_; }

 private:
  EngineOptions options_;
  std::shared_ptr<TimedMatcher> matcher_;
  std::uint64_t seed_;
  Pose2 start_;
  std::unique_ptr<SlamEngine> engine_;
  std::vector<StampedPose2> trajectory_;
  std::vector<StampedPose2> odometry_;
  std::vector<float> match_seconds_;
  std::vector<float> scan_seconds_;
  std::map<MatchStatus, std::size_t> statuses_;
  std::size_t inserted_ = 0;
};

}  // namespace matchbox_slam
