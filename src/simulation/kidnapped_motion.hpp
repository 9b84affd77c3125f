#pragma once

#include <cstdint>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "simulation/fault.hpp"
#include "simulation/robot.hpp"

namespace matchbox_slam {

/// A drive on which the robot is carried away at times, and each time goes on from another place of
/// its route. Without such a fault it is the drive as it was.
class KidnappedMotion {
 public:
  /// @param faults  of which those of kKidnap count; their times are drawn.
  /// @param motion  outlives this object.
  /// Throws ConfigurationError when no place of the route is as far away as is asked for.
  KidnappedMotion(const RobotMotion& motion, const std::vector<Fault>& faults, std::uint64_t seed);

  /// Pose of the base in the world. While it is carried, the robot goes straight from the one place
  /// to the other.
  /// @param since_start  [s]
  [[nodiscard]] Pose2 pose(double since_start) const;

  /// The pose as wheels on the ground feel it: it stands still while the robot is carried, and goes
  /// on from there. By differences of these poses an odometry would go.
  [[nodiscard]] Pose2 pose_on_wheels(double since_start) const;

 private:
  struct Carried {
    double begin;             ///< [s] since the start
    double end;               ///< likewise
    double route_from;        ///< [s] of the drive where it was taken up
    double route_to;          ///< and where it was put down
    Pose2 wheels_from_world;  ///< afterwards
  };

  /// The carrying that begins last before a time; null: none has begun.
  [[nodiscard]] const Carried* last_before(double since_start) const;

  const RobotMotion& motion_;
  std::vector<Carried> carried_;  ///< by their beginnings
};

}  // namespace matchbox_slam
