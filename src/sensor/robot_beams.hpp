#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/sensor/laser_scan.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// Finds beams of a laser that end on the robot itself, such as on a mast or a wheel. The sign is a
/// short range that stays the same wherever the robot is and whichever way it looks: of a wall that
/// it follows the range changes as it turns. So nothing is found before it has looked all around,
/// and from several places.
class RobotBeams {
 public:
  /// Scans of one laser; from one with other beams on it begins anew. Readings that the options
  /// leave out anyway are no sign.
  /// @param map_from_base  where the robot was.
  void add(const LaserScan& scan, const Pose2& map_from_base, const ProjectionOptions& options);

  /// The sectors in which beams end on the robot, as of ProjectionOptions::masked_angles, by
  /// their angles. Empty: none do, or too little has been seen to tell.
  [[nodiscard]] const std::vector<double>& sectors() const { return sectors_; }

 private:
  static constexpr std::size_t kDirections = 8;
  static constexpr std::size_t kSamples = 64;  ///< of which the newest count
  static constexpr std::size_t kMinSamples = 32;

  void take(const LaserScan& scan, const ProjectionOptions& options);
  [[nodiscard]] std::vector<double> find() const;
  [[nodiscard]] bool has_looked_around() const;
  [[nodiscard]] bool is_on_robot(std::size_t beam) const;

  LaserScan beams_;                                   ///< without ranges
  std::size_t count_ = 0;                             ///< of beams
  std::vector<std::array<float, kSamples>> samples_;  ///< [m] by beam; 0: no reading; -1: far
  std::size_t taken_ = 0;                             ///< samples, in all
  std::array<std::size_t, kDirections> looked_{};     ///< samples by heading
  Pose2 newest_;                                      ///< where the newest sample was taken
  Pose2 first_;
  double farthest_ = 0.0;        ///< [m] of a sample from the first one
  std::vector<double> sectors_;  ///< that were found last
};

}  // namespace matchbox_slam
