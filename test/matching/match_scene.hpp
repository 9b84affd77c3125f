#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"
#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "simulation/laser.hpp"
#include "simulation/world.hpp"

namespace matchbox_slam {

/// A simulated place for a matcher: a map of scans taken around it at true poses, and one more scan
/// that is not in the map. Owns what a MatchProblem refers to.
struct MatchScene {
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  PlacedScans key_scans;
  PointScan scan;
  Pose2 map_from_base;  ///< the truth

  [[nodiscard]] MatchProblem problem(const Pose2& predicted, const Eigen::Matrix3d& covariance,
                                     std::uint64_t seed = 1) const {
    return {scan, predicted, covariance, map.field, key_scans, seed};
  }
};

/// A key scan of these points.
[[nodiscard]] inline PlacedScan placed(PointScan points, const Pose2& map_from_base) {
  return {std::make_shared<const KeyScan>(std::move(points)), map_from_base};
}

/// The points that a laser sees from a pose.
/// @param seed  of its noise.
[[nodiscard]] PointScan look_around(const World& world, const LaserOptions& laser,
                                    const Pose2& world_from_base, std::uint64_t seed);

/// A robot that drives the route of a world: what it maps from 2 s before a time [s] until 2 s
/// after it, one scan each half second, and the scan at that time.
/// @param seed  of the laser's noise.
[[nodiscard]] MatchScene make_match_scene(const World& world, const LaserOptions& laser,
                                          double time, std::uint64_t seed);

/// One of the rooms world, made once.
[[nodiscard]] const MatchScene& rooms_scene();

/// The pose moved by (x, y, theta) along the axes of the map.
[[nodiscard]] Pose2 shifted(const Pose2& pose, const Eigen::Vector3d& by);

/// (x, y, theta) that shifts `from` to `pose`.
[[nodiscard]] Eigen::Vector3d shift_between(const Pose2& from, const Pose2& pose);

/// Diagonal, from standard deviations of the position [m] and the heading [rad].
[[nodiscard]] Eigen::Matrix3d prior_of(double sigma_xy, double sigma_theta);

/// Squared distance of the answer from the truth, in standard deviations of its covariance; the
/// mean over many honest answers is 3.
[[nodiscard]] double normalised_error_square(const MatchResult& result, const Pose2& truth);

}  // namespace matchbox_slam
