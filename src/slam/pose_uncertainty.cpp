#include "slam/pose_uncertainty.hpp"

#include <Eigen/LU>
#include <cmath>

#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"

namespace matchbox_slam {

namespace {

/// How well it is known where a place of the map lies as seen from where the map began: what lies
/// farther away hangs on it by a heading that is known no better.
Eigen::Matrix3d bend_at(const Pose2& map_from_base, const KeyScans& key_scans) {
  constexpr double kBend = 1e-4;  // [rad], so that what is told of poses is honest
  const double away =
      (map_from_base.translation() - key_scans.all().front().map_from_base.translation()).norm();
  return covariance_of(kBend * away, kBend);
}

/// A lost robot may be anywhere in the map, in any heading.
Eigen::Matrix3d anywhere_in(const SlamMap& map) {
  const CellBox box = map.occupancy.known_bounds();
  const double size = map.field.geometry().resolution() * std::hypot(box.width(), box.height());
  return covariance_of(size, kPi);
}

}  // namespace

Eigen::Matrix3d reported_covariance(const ScanOutcome& outcome, const MapComponents& components,
                                    bool maps) {
  Eigen::Matrix3d told = outcome.covariance;
  const KeyScans& active = components.active().key_scans;
  if (outcome.match.accepted() && maps && !active.empty()) {
    // What it was matched with was drawn where scans were thought to be that were no surer.
    told += outcome.match.covariance + bend_at(outcome.map_from_base, active);
  }
  if (components.is_lost()) {
    told += anywhere_in(components.map().map);
  }
  return told;
}

Eigen::Matrix3d beside_drawn(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix3d drawn = covariance_of(0.15, 0.05);  // [m], [rad]
  return symmetric(covariance * (covariance + drawn).inverse() * drawn);
}

}  // namespace matchbox_slam
