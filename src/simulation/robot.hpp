#pragma once

#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "simulation/world.hpp"

namespace matchbox_slam {

/// How the robot drives.
struct DriveOptions {
  double speed = 0.5;
  double turn_rate = 0.6;
  double acceleration = 0.5;
  double turn_acceleration = 2.0;
  double rest = 2.0;
  int laps = 1;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.speed, "speed", between(0.01, 1.5), "m/s", "Speed on straight ways.");
    option(self.turn_rate, "turn_rate", between(0.05, 5.0), "rad/s", "Largest turn rate.");
    option(self.acceleration, "acceleration", between(0.05, 10.0), "m/s^2",
           "Largest change of the speed.");
    option(self.turn_acceleration, "turn_acceleration", between(1.0, 100.0), "rad/s^2",
           "Largest change of the turn rate.");
    option(self.rest, "rest", between(0.0, 1e4), "s", "Time at rest before the robot sets off.");
    option(self.laps, "laps", between(1.0, 1000.0), "",
           "How often the robot drives the way, which has to end where it begins if that is more "
           "than once.");
  }
};

/// The true motion of the base: its pose as a function of the time since the start. Piecewise of
/// constant speed and turn rate, so that every pose is exact.
class RobotMotion {
 public:
  /// Speed and turn rate kept for one step from a pose on.
  struct Step {
    Pose2 world_from_base;
    double speed = 0.0;      ///< [m/s]
    double turn_rate = 0.0;  ///< [rad/s]
  };

  /// Throws std::invalid_argument when there is no step or their duration [s] is not positive.
  RobotMotion(std::vector<Step> steps, double step_duration);

  /// Pose of the base in the world; the robot rests before the start and after the end.
  [[nodiscard]] Pose2 pose(double time) const;

  [[nodiscard]] const std::vector<Step>& steps() const { return steps_; }
  [[nodiscard]] double duration() const;  ///< [s]

 private:
  std::vector<Step> steps_;
  double step_duration_;
};

/// Drives the route: turns on the spot where it has to, cuts the corners a little elsewhere, as a
/// pursuit of a point ahead on the route does (Coulter, "Implementation of the Pure Pursuit Path
/// Tracking Algorithm", CMU-RI-TR-92-01). Ends at rest on the last way-point.
/// Throws std::invalid_argument for a route of less than two way-points or of no length, and
/// ConfigurationError for several laps of one that does not end where it begins.
[[nodiscard]] RobotMotion drive(const Route& route, const DriveOptions& options);

}  // namespace matchbox_slam
