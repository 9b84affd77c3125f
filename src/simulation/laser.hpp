#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/laser_scan.hpp"
#include "simulation/world.hpp"

namespace matchbox_slam {

// [m], of base_link, which carries the laser, above the ground; the PR2's.
constexpr double kBaseHeight = 0.051;

/// A planar laser on the robot. The defaults are the base laser of the PR2 that drove through the
/// MIT Stata Center: a Hokuyo UTM-30LX at 20 Hz.
struct LaserOptions {
  int beams = 1040;
  double field_of_view = degrees_to_radians(260.0);
  bool clockwise = false;
  double range_min = 0.023;
  double range_max = 30.0;
  double range_noise = 0.01;
  double range_noise_square = 0.0;
  double dropout = 0.002;
  double outliers = 0.0;
  std::string no_return = "infinite";
  double scan_rate = 20.0;
  double time_increment = 0.0;
  int parts = 1;
  double sent_time_increment = -1.0;
  double sent_scan_time = -1.0;
  double mount_x = 0.275;
  double mount_y = 0.0;
  double mount_z = 0.252;
  double mount_roll = 0.0;
  double mount_pitch = 0.0;
  double mount_yaw = 0.0;
  double rock = 0.0;
  double nod = 0.0;
  bool floor = false;
  double table_height = 100.0;

  template <typename Self, typename Visitor>
  static void visit(Self& self, Visitor&& option) {
    option(self.beams, "beams", between(1, 1000000), "", "Readings of one scan.");
    option(self.field_of_view, "field_of_view", between(1e-3, 2.0 * kPi), "rad",
           "Angle that the beams share; the first is half of it off the laser's x axis.");
    option(self.clockwise, "clockwise", any(), "",
           "Whether the laser sweeps clockwise, with a negative angle_increment.");
    option(self.range_min, "range_min", between(0.0, 1e3), "m", "Shorter distances read -inf.");
    option(self.range_max, "range_max", between(1e-2, 1e3), "m", "Reach of the laser.");
    option(self.range_noise, "range_noise", between(0.0, 1.0), "m",
           "Standard deviation of a range, Gaussian.");
    option(self.range_noise_square, "range_noise_square", between(0.0, 1.0), "1/m",
           "What the square of the range adds to that, times this, as for a depth camera.");
    option(self.dropout, "dropout", between(0.0, 1.0), "",
           "Probability that a reading is lost and reads NaN.");
    option(
        self.outliers, "outliers", between(0.0, 1.0), "",
        "Probability that something small is before the wall, such as a leg or dust: the reading "
        "is anything from range_min to what the beam met.");
    option(self.no_return, "no_return", one_of({"infinite", "over_range", "zero", "nan"}), "",
           "What a beam reads that meets nothing: +inf, or 1 m more than range_max, or 0 or NaN, "
           "which it then reads too where it is lost or the distance too short.");
    option(self.scan_rate, "scan_rate", between(0.1, 1e3), "Hz",
           "Scans a second; turns a second where they come in parts.");
    option(self.time_increment, "time_increment", between(0.0, 1.0), "s",
           "Time from beam to beam; the robot moves meanwhile. 0: all beams at once.");
    option(self.parts, "parts", between(1, 1000), "",
           "A scan is sent as so many scans of equally many beams, each with its own stamp.");
    option(self.sent_time_increment, "sent_time_increment", between(-1.0, 1.0), "s",
           "What messages say that time_increment is, whatever it is. -1: the truth.");
    option(self.sent_scan_time, "sent_scan_time", between(-1.0, 1e3), "s",
           "What messages say that the time from scan to scan is. -1: the truth.");
    option(self.mount_x, "mount_x", between(-10.0, 10.0), "m", "Laser ahead of the base.");
    option(self.mount_y, "mount_y", between(-10.0, 10.0), "m", "Laser to the left of the base.");
    option(self.mount_z, "mount_z", between(-10.0, 10.0), "m", "Laser above the base.");
    option(self.mount_roll, "mount_roll", between(-kPi, kPi), "rad",
           "Turn of the laser about its x axis; pi is upside down.");
    option(self.mount_pitch, "mount_pitch", between(-1.5, 1.5), "rad",
           "Turn of the laser about its y axis, positive looks down.");
    option(self.mount_yaw, "mount_yaw", between(-kPi, kPi), "rad",
           "Turn of the laser about its z axis, positive to the left.");
    option(self.rock, "rock", between(0.0, 0.5), "rad",
           "The robot rocks, by up to this in roll and in pitch; its odometry tells, or its IMU.");
    option(self.nod, "nod", between(0.0, 1.5), "rad",
           "The laser nods, by up to this down and up about its y axis; tf tells.");
    option(self.floor, "floor", any(), "",
           "There is a floor, on which beams end that look down; else they go on for ever.");
    option(self.table_height, "table_height", between(0.0, 100.0), "m",
           "Of the tables and boxes in the rooms above the floor; all else is without end.");
  }

  /// Standard deviation of a range [m].
  [[nodiscard]] double noise_at(double range) const {
    return range_noise + range_noise_square * range * range;
  }

  /// Pose of the laser in the base: turned by roll, pitch, yaw about the fixed axes x, y, z. Where
  /// it nods, that of its middle.
  [[nodiscard]] Eigen::Isometry3d base_from_laser() const;

  /// What nodding adds to that, on the right, and rocking, on the left, at a time [s].
  [[nodiscard]] Eigen::Isometry3d nodded(double stamp) const;
  [[nodiscard]] Eigen::Isometry3d rocked(double stamp) const;
};

/// What one beam met, before noise.
struct BeamTruth {
  double range = std::numeric_limits<double>::infinity();  ///< [m] along the beam, inf: nothing met
  std::optional<std::size_t> segment;                      ///< index into World::segments()
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< unit, in the world, towards the laser
  double cos_incidence = 0.0;  ///< cosine of the angle between beam and normal, 1 when head-on
  Eigen::Vector2d end = Eigen::Vector2d::Zero();  ///< [m], in the world, where the surface was met
};

/// A scan with the truth behind each of its beams.
struct SimulatedScan {
  LaserScan scan;
  std::vector<BeamTruth> truth;  ///< as many as ranges
};

/// Pose of the base in the world at a time [s].
using PoseAtTime = std::function<Pose2(double)>;

/// Throws ConfigurationError when options that are allowed one by one do not fit together: no range
/// between range_min and range_max, a sweep longer than the time from scan to scan, or parts that
/// are not of equally many beams.
void check_laser_options(const LaserOptions& options);

/// What each beam of a scan at `stamp` meets. Walls are upright and without end, so a tilted laser
/// sees them farther away. A beam that ends on the floor meets no segment. The base moves while the
/// beams are swept. What surfaces leave to chance is drawn by the world's seed and the stamp.
/// Throws ConfigurationError as check_laser_options does.
[[nodiscard]] std::vector<BeamTruth> trace_beams(const World& world, const LaserOptions& options,
                                                 const PoseAtTime& world_from_base, double stamp);

/// One scan as the laser measures it, and its truth. The same seed gives the same bits, and beam k
/// gets the same noise whatever the world is.
/// @param stamp  [s], time of the first beam.
[[nodiscard]] SimulatedScan simulate_scan(const World& world, const LaserOptions& options,
                                          const PoseAtTime& world_from_base, double stamp,
                                          std::uint64_t seed);

/// The messages that a scan is sent as: itself, or its parts.
[[nodiscard]] std::vector<LaserScan> in_parts(const LaserScan& scan, const LaserOptions& options);

}  // namespace matchbox_slam
