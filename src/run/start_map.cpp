#include "run/start_map.hpp"

#include <cstddef>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/io/saved_map.hpp"

namespace matchbox_slam {
namespace {

/// Whether somebody drove where the map was made: an image says nothing of a robot.
bool is_known_where(const EngineState& map) {
  const PlacedScans& keys = map.key_scans.all();
  return !keys.empty() && (map.motion.stamp || !keys.back().scan->is_of_image());
}

}  // namespace

EngineState read_start_map(const std::string& path, const SlamSetup& setup) {
  EngineState start = read_engine_state(path, setup.engine);
  set_initial_pose(setup.run, start);
  return start;
}

Eigen::Matrix3d initial_pose_covariance() {
  // As well as somebody puts a robot on a mark: guesses, half and double were not tried.
  constexpr double kPosition = 0.3;  // [m]
  constexpr double kHeading = 0.2;   // [rad]
  return covariance_of(kPosition, kHeading);
}

SetPose configured_start(const RunOptions& options) {
  return {{options.start_x, options.start_y, wrap_angle(options.start_theta)},
          initial_pose_covariance()};
}

void set_initial_pose(const RunOptions& options, EngineState& start) {
  const Pose2 configured = configured_start(options).map_from_base;
  // A map that was saved by a lost robot: its pose is of the component that it is in, and lost it
  // stays.
  const std::size_t active = start.localization.active;
  start.begin_anew(is_known_where(start) || active > 0 ? start.motion.fixed_from_base : configured,
                   start.motion.covariance + initial_pose_covariance());
  start.localization.active = active;
  if (active > 0) {
    start.localization.components[active - 1].last_inserted.clear();
  }
}

std::optional<Pose2> odometry_of(const ScanInput& input) {
  return input.odometry && !input.odometry->is_heading_only
             ? std::optional<Pose2>(input.odometry->odom_from_base)
             : std::nullopt;
}

bool does_odometry_go_on(const std::optional<Pose2>& saved, const std::optional<Pose2>& now,
                         double seconds) {
  // Guesses: half and double were not tried.
  constexpr double kNearOrigin = 1.0;  // [m], where it may have begun anew
  constexpr double kMaxSpeed = 1.5;    // [m/s]
  constexpr double kMaxPause = 600.0;  // [s], after which it may have been carried
  if (!saved || !now || !(seconds > 0.0 && seconds <= kMaxPause)) {
    return false;
  }
  const double moved = (now->translation() - saved->translation()).norm();
  const double from_origin = now->translation().norm();
  const bool may_have_begun = from_origin < kNearOrigin && from_origin < moved;
  return moved <= kMaxSpeed * seconds && !may_have_begun;
}

bool is_same_drive(double stamp, std::optional<double> before, double longest_pause) {
  return before && stamp > *before && stamp <= *before + longest_pause;
}

}  // namespace matchbox_slam
