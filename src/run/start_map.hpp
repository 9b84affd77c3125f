#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {

/// A saved map and where the robot is in it, as well as one puts a robot on a mark: where it was
/// when the map was saved, or at the configured start in one that does not say. Throws as
/// read_engine_state.
[[nodiscard]] EngineState read_start_map(const std::string& path, const SlamSetup& setup);

/// How well it is known where a robot is that somebody puts on a mark: over (x, y, theta).
[[nodiscard]] Eigen::Matrix3d covariance_on_mark();

/// The same of a map that was read.
void put_on_mark(const RunOptions& options, EngineState& start);

/// A scan that comes so long [s] after one of another recording is of the same drive.
constexpr double kLongestPause = 10.0;

/// Whether a scan of this stamp [s] comes soon after one of another recording, so that both are of
/// the same drive: odometry goes on, too.
[[nodiscard]] bool is_same_drive(double stamp, std::optional<double> before,
                                 double longest_pause = kLongestPause);

/// Whether odometry went on after a map was saved, while whoever mapped was away, so that it tells
/// where the robot is now: it is nearer to where it was then than to its origin, where it begins
/// when a robot is switched on. Near the origin nobody can tell the two apart, and the answer is
/// no.
/// @param saved, now  of the base in the odometry frame.
/// @param seconds     between the two.
[[nodiscard]] bool does_odometry_go_on(const std::optional<Pose2>& saved,
                                       const std::optional<Pose2>& now, double seconds);

}  // namespace matchbox_slam
