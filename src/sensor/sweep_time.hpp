#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/laser_scan.hpp"

namespace matchbox_slam {

/// A scan, and how the robot moved while it was taken.
struct MovingScan {
  LaserScan scan;  ///< what it says of times between beams is not looked at
  Eigen::Isometry3d base_from_laser = Eigen::Isometry3d::Identity();
  Pose2 odom_from_base;                                ///< at the first beam
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();  ///< [m/s] of the base, in its own frame
  double turn_rate = 0.0;                              ///< [rad/s]
};

/// What one scan tells of the sweep time.
struct ToldSweepTime {
  double seconds = 0.0;     ///< from the first beam to the last
  double deviation = 0.0;   ///< [s], by the noise of its readings alone
  bool is_turning = false;  ///< it was taken at another turn rate than the scan it was laid on
};

/// Tells from the scans of a moving robot how long a laser's sweep takes, whatever its messages
/// say. A wrong time bends a scan by how fast the robot turns, and shifts its parts by how fast it
/// drives, so that scans taken at other speeds do not lie on each other: each is laid on one of a
/// little before, point to line, with its pose and the sweep time both unknown. Walls may have any
/// shape.
///
/// Driving straight on tells less than turning: between walls that look the same all along, scans
/// lie on each other however they are shifted, which looks like no sweep at all.
class SweepTimeEstimator {
 public:
  /// Scans of one laser in the order of their stamps. Cost: a few passes over the beams where the
  /// robot's speed changes, next to nothing where it does not.
  /// Returns what the scan tells; none: nothing.
  std::optional<ToldSweepTime> add(const MovingScan& scan);

  /// How many scans of the turning robot have told.
  [[nodiscard]] std::size_t turning_scans() const { return turning_; }

 private:
  /// A point as it was hit, were the sweep to take the time that all is linearised about.
  struct Hit {
    Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< [m] in the base at the first beam
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< [m/s] of the position by the sweep time
    Eigen::Vector2d normal =
        Eigen::Vector2d::Zero();  ///< of the surface; zero where there is no line
    double bearing = 0.0;         ///< [rad] of the position, as seen from the base
  };
  /// Hits in the order of their bearings.
  struct Hits {
    Pose2 odom_from_base;
    double stamp = 0.0;
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
    double turn_rate = 0.0;
    double spacing = 0.0;  ///< [rad] between beams
    std::vector<Hit> hits;
  };
  struct Fit;

  [[nodiscard]] static Hits hits_of(const MovingScan& scan);
  [[nodiscard]] const Hits* reference_for(const Hits& scan) const;
  [[nodiscard]] static std::optional<ToldSweepTime> fit(const Hits& scan, const Hits& reference);

  std::deque<Hits> recent_;
  std::size_t turning_ = 0;   ///< scans that have told
  std::size_t straight_ = 0;  ///< of the robot that did not turn, likewise
};

}  // namespace matchbox_slam
