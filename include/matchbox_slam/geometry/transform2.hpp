#pragma once

#include <Eigen/Core>
#include <cmath>

#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

/// A pose with the cosine and sine of its heading at hand, for many points: yields the same bits as
/// the pose itself.
class Transform2 {
 public:
  explicit Transform2(const Pose2& a_from_b)
      : x_(a_from_b.x),
        y_(a_from_b.y),
        cosine_(std::cos(a_from_b.theta)),
        sine_(std::sin(a_from_b.theta)) {}

  [[nodiscard]] Eigen::Vector2d operator*(const Eigen::Vector2d& point) const {
    return {x_ + cosine_ * point.x() - sine_ * point.y(),
            y_ + sine_ * point.x() + cosine_ * point.y()};
  }

  /// A direction, which the translation does not move.
  [[nodiscard]] Eigen::Vector2d turned(const Eigen::Vector2d& direction) const {
    return {cosine_ * direction.x() - sine_ * direction.y(),
            sine_ * direction.x() + cosine_ * direction.y()};
  }

 private:
  double x_, y_;
  double cosine_, sine_;
};

}  // namespace matchbox_slam
