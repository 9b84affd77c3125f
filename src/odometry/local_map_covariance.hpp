#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// The error of a pose that is matched against a local map of key scans, and those of the key
/// scans, all together: they share errors, and where the map is made of many, it has their mean
/// error.
///
/// All poses are of the base in one fixed frame, all covariances over (x [m], y [m], theta [rad])
/// of a pose in that frame; first order. A displaced map displaces what is matched against it as
/// one piece. How much each key scan counts is guessed from its distance. (The joint Gaussian and
/// the gain are those of the Kalman filter, as in Smith, Self and Cheeseman, "Estimating Uncertain
/// Spatial Relationships in Robotics", 1990.)
class LocalMapCovariance {
 public:
  /// One key scan, with the base still there.
  LocalMapCovariance(const Pose2& fixed_from_base, const Eigen::Matrix3d& covariance);

  /// The base has moved on and was matched. Where the match says less than its prior did, it does
  /// so by the map; the rest is prediction, on from the newest key scan. A prior that has no
  /// inverse counts as all there is.
  /// @param prior  covariance of the prediction, counted from the newest key scan on.
  /// @param match  covariance of the answer, likewise.
  void follow(const Pose2& fixed_from_base, const Eigen::Matrix3d& prior,
              const Eigen::Matrix3d& match);

  /// Of the base where it is.
  [[nodiscard]] Eigen::Matrix3d covariance() const;

  /// What was matched last becomes a key scan.
  void add();

  /// Forgets older key scans; one stays at least.
  void keep_newest(std::size_t count);

  /// Key scans.
  [[nodiscard]] std::size_t size() const { return keys_.size(); }

  /// Memory, which grows with the square of the number of key scans.
  [[nodiscard]] std::size_t bytes() const {
    return sizeof(double) * static_cast<std::size_t>(joint_.size());
  }

 private:
  /// How the error of the base follows those of the key scans; three columns a key scan.
  [[nodiscard]] Eigen::Matrix3Xd shares() const;

  std::vector<Eigen::Vector2d> keys_;  ///< where they are, oldest first
  Eigen::MatrixXd joint_;              ///< covariance of their errors; three rows a key scan
  Eigen::Vector2d base_;               ///< where the base is
  Eigen::Matrix3d predicted_;  ///< share of the newest key scan's error that no match has replaced,
                               ///< for errors moved to where the newest key scan is
  Eigen::Matrix3d match_;      ///< what has come since the newest key scan
};

}  // namespace matchbox_slam
