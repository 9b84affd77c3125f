#pragma once

#include <optional>
#include <string>

#include "bag/bag_reader.hpp"
#include "bag/bag_survey.hpp"
#include "run/run_options.hpp"

namespace matchbox_slam {

/// What was asked for, or is known, of a robot's frames.
struct AskedFrames {
  std::optional<std::string> base;
  std::optional<std::string> odom;
  bool is_laser_placed = false;  ///< tf need not tell where the laser is
};

/// What tells how the robot moves from scan to scan.
struct BagMotion {
  BagFrames frames;
  std::string odom_topic;  ///< empty: tf, where there is odometry
  std::string imu_topic;   ///< empty: none
  std::string told;        ///< what was chosen, for people
};

/// Finds the odometry: on the topic asked for; else in tf; else on the only topic of
/// nav_msgs/Odometry whose pose moves. Where there is none at all, the turn from scan to scan is by
/// the IMU, where there is one whose place tf tells. Throws ConfigurationError naming the topics
/// when there are several to choose from, and as `choose_frames`. Looks no farther than to damage.
/// @param options  of which use_odometry, odom_topic and imu_topic are what was asked for.
[[nodiscard]] BagMotion choose_motion(const BagReader& reader, const BagSurvey& survey,
                                      const AskedFrames& asked, const BagPeriod& period,
                                      const RunOptions& options);

}  // namespace matchbox_slam
