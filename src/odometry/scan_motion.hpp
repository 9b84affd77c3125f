#pragma once

#include <optional>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/odometry/laser_odometry.hpp"

namespace matchbox_slam {

/// How the base moves by the scans of one laser, where no odometry tells its way: well enough to
/// see how long the laser's sweeps take.
class ScanMotion {
 public:
  explicit ScanMotion(const ProjectionOptions& options);

  /// The next scan. Returns odom_from_base at its stamp; none: it is not later than the one before,
  /// so much later that nothing can be told between them, or does not match. Throws as
  /// LaserOdometry::process.
  std::optional<Pose2> add(const ScanInput& input);

  /// odom_from_base at a stamp [s] between those of the last two scans, as if the base had moved
  /// steadily; none where one of them told nothing, or the stamp is not between them.
  [[nodiscard]] std::optional<Pose2> odom_from_base_at(double stamp) const;

 private:
  struct Stamped {
    double stamp;
    Pose2 odom_from_base;
  };

  LaserOdometry odometry_;
  std::optional<double> last_stamp_;  ///< [s], of a scan that told or not
  std::optional<Stamped> before_;
  std::optional<Stamped> newest_;
};

}  // namespace matchbox_slam
