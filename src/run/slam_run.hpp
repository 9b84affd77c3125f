#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/thinned_path.hpp"
#include "geometry/trajectory.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "run/slam_setup.hpp"
#include "run/timed_matcher.hpp"

namespace matchbox_slam {

/// What to tell people of a scan that the map has no room for.
constexpr const char* kLeftOut =
    "a scan is left out of the map, which would have more cells than map/max_cells allows; is its "
    "pose a wild one?";

/// What a run keeps of its past: everything, or only what does not grow with time.
enum class RunRecords { kAll, kRecent };

/// The engine at work, and a record of what it did since its start or last reset. The node and
/// map_bag both run this, so that they yield the same.
class SlamRun {
 public:
  explicit SlamRun(const SlamSetup& setup, RunRecords records = RunRecords::kAll);

  /// Processes the next scan of the queue.
  ScanOutcome process(const ScanInput& input);

  /// Tells where the base is in the map, for the next scan; as SlamEngine::set_pose.
  void set_pose(const Pose2& map_from_base, const Eigen::Matrix3d& covariance) {
    engine_->set_pose(map_from_base, covariance);
  }

  /// Forgets map, poses and records, as if just made.
  void reset();

  /// Forgets them, and goes on with another map; as SlamEngine::start_from.
  void start_from(MapStart start);

  /// Matcher and engine options of another configuration take effect from the next scan on; map and
  /// pose stay. Throws ConfigurationError as SlamEngine::set_options; then nothing has changed.
  void reconfigure(const SlamSetup& setup);

  /// As SlamEngine::snapshot.
  [[nodiscard]] MapStart snapshot() const { return engine_->snapshot(); }

  /// Time of the newest scan's match [s]; 0 when it was not matched.
  [[nodiscard]] double last_match_seconds() const { return last_match_seconds_; }

  [[nodiscard]] const SlamMap& map() const { return engine_->map(); }
  [[nodiscard]] const KeyScans& key_scans() const { return engine_->key_scans(); }

  /// Scans that were processed.
  [[nodiscard]] std::size_t scans() const { return scans_; }

  /// Of the base in the map, and raw in the odometry frame; for drawing.
  [[nodiscard]] const ThinnedPath& path() const { return path_; }
  [[nodiscard]] const ThinnedPath& odometry_path() const { return odometry_path_; }

  /// Poses of the base in the map, one a stamp; empty where only recent things are kept.
  [[nodiscard]] const std::vector<StampedPose2>& trajectory() const { return trajectory_; }
  /// Raw odometry at the same stamps; empty when there is none.
  [[nodiscard]] const std::vector<StampedPose2>& odometry() const { return odometry_; }

  /// Seconds that each match took, or the latest ones; scans that were not matched have no entry.
  [[nodiscard]] const std::vector<float>& match_seconds() const { return match_seconds_; }
  /// Seconds that each scan took from projection to insertion, or the latest ones.
  [[nodiscard]] const std::vector<float>& scan_seconds() const { return scan_seconds_; }

  [[nodiscard]] const std::map<MatchStatus, std::size_t>& statuses() const { return statuses_; }
  [[nodiscard]] std::size_t inserted() const { return inserted_; }

 private:
  void record(const ScanOutcome& outcome);

  RunRecords records_;
  EngineOptions options_;
  std::shared_ptr<TimedMatcher> matcher_;
  std::uint64_t seed_;
  Pose2 start_;
  std::unique_ptr<SlamEngine> engine_;
  std::size_t scans_ = 0;
  ThinnedPath path_;
  ThinnedPath odometry_path_;
  std::vector<StampedPose2> trajectory_;
  std::vector<StampedPose2> odometry_;
  std::vector<float> match_seconds_;
  std::vector<float> scan_seconds_;
  std::map<MatchStatus, std::size_t> statuses_;
  std::size_t inserted_ = 0;
  double last_match_seconds_ = 0.0;
};

}  // namespace matchbox_slam
