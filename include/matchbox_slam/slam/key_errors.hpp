#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// What is known about the errors of the poses of a local map's key scans, all together: scans that
/// are matched against the map share its errors, and where it is made of many key scans, the map
/// has their mean error.
///
/// An error is a small motion of the fixed frame, (x, y, theta) about its origin, by which the true
/// pose differs: with the same error, a whole map is displaced as one piece.
class KeyErrors {
 public:
  /// One key scan.
  /// @param covariance  of the pose over (x, y, theta) in the fixed frame.
  KeyErrors(const Pose2& fixed_from_key, const Eigen::Matrix3d& covariance);

  /// Covariance of a pose that was matched against the map, over (x, y, theta) in the fixed frame,
  /// first order.
  /// @param prior  covariance of the prediction, counted from the newest key scan on.
  /// @param match  covariance of the match, likewise: what it says less than the prior comes from
  ///               the map, the rest from the newest key scan by the prediction.
  [[nodiscard]] Eigen::Matrix3d covariance_of(const Pose2& fixed_from_base,
                                              const Eigen::Matrix3d& prior,
                                              const Eigen::Matrix3d& match) const;

  /// That pose becomes a key scan.
  void add(const Pose2& fixed_from_key, const Eigen::Matrix3d& prior, const Eigen::Matrix3d& match);

  /// Forgets the others; at least one stays.
  void keep_newest(std::size_t count);

 private:
  /// How the error of a matched pose follows those of the key scans.
  [[nodiscard]] Eigen::Matrix3Xd shares(const Pose2& fixed_from_base, const Eigen::Matrix3d& prior,
                                        const Eigen::Matrix3d& match) const;

  /// How much each key scan counts in the map around a pose; 1 in all.
  [[nodiscard]] Eigen::VectorXd weights_at(const Pose2& fixed_from_base) const;

  std::vector<Eigen::Vector2d> positions_;  ///< of the key scans, oldest first
  Eigen::MatrixXd joint_;                   ///< covariance of all their errors
};

}  // namespace matchbox_slam
