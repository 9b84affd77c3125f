#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// Thrown where a line of a log of CARMEN is none. The text says why.
class CarmenLineError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What a laser's message tells: FLASER, RLASER, or RAWLASER and ROBOTLASER with a number.
struct CarmenScan {
  std::string message;        ///< such as "FLASER"
  std::vector<float> ranges;  ///< [m]
  std::vector<float> remissions;
  bool tells_angles = false;   ///< else they are those that CARMEN takes for so many beams
  double start_angle = 0.0;    ///< [rad]
  double increment = 0.0;      ///< [rad]
  double maximum_range = 0.0;  ///< [m]
  // In the frame of the odometry:
  std::optional<Pose2> laser;
  std::optional<Pose2> robot;
};

/// Of an ODOM: the robot in the frame of the odometry.
struct CarmenOdometry {
  Pose2 robot;
};

struct CarmenParameter {
  std::string name;
  double value = 0.0;
};

/// A line of a log of CARMEN: `message fields... ipc_timestamp hostname logger_timestamp`
/// (carmen.sourceforge.net/logger_playback.html).
struct CarmenLine {
  /// Nothing: a comment, or a message that is not read.
  std::variant<std::monostate, CarmenScan, CarmenOdometry, CarmenParameter> content;
  std::optional<double> ipc_stamp;     ///< when it was sent [s]
  std::optional<double> logger_stamp;  ///< when it was written, from the log's beginning [s]
};

/// Throws CarmenLineError.
[[nodiscard]] CarmenLine parse_carmen_line(const std::string& line);

/// Whether a line is a comment of CARMEN's logger or begins with the name of a message.
[[nodiscard]] bool is_carmen_line(const std::string& line);

}  // namespace matchbox_slam
