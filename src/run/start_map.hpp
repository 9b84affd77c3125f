#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/scan_input.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "run/run_event.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {

/// A saved map and where the robot is in it, as well as one puts a robot on a mark: where it was
/// when the map was saved, or at the configured start in one that does not say. Throws as
/// read_engine_state.
[[nodiscard]] EngineState read_start_map(const std::string& path, const SlamSetup& setup);

/// How well it is known where a robot is that somebody puts on a mark: over (x, y, theta).
[[nodiscard]] Eigen::Matrix3d initial_pose_covariance();

/// The configured start, as well as one puts a robot on a mark.
[[nodiscard]] SetPose configured_start(const RunOptions& options);

/// The same of a map that was read.
void set_initial_pose(const RunOptions& options, EngineState& start);

/// A scan that comes so long [s] after one of another recording is of the same drive.
constexpr double kLongestPause = 10.0;

/// Whether a scan of this stamp [s] comes soon after one of another recording, so that both are of
/// the same drive: odometry goes on, too.
[[nodiscard]] bool is_same_drive(double stamp, std::optional<double> before,
                                 double longest_pause = kLongestPause);

/// Where the odometry has the base at a scan; none where it tells the heading alone.
[[nodiscard]] std::optional<Pose2> odometry_of(const ScanInput& input);

/// Whether odometry went on while nobody used it, so that it tells where the robot is now: a robot
/// may have driven there, and it has not begun anew, as when a robot is switched on. What it tells
/// the next scans have to confirm.
/// @param saved, now  of the base in the odometry frame.
/// @param seconds     between the two.
[[nodiscard]] bool does_odometry_go_on(const std::optional<Pose2>& saved,
                                       const std::optional<Pose2>& now, double seconds);

}  // namespace matchbox_slam
