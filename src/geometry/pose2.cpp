#include "matchbox_slam/geometry/pose2.hpp"

namespace matchbox_slam {

Eigen::Matrix3d compose_covariance(const Pose2& a_from_b,
                                   const Eigen::Matrix3d& covariance_a_from_b,
                                   const Pose2& b_from_c,
                                   const Eigen::Matrix3d& covariance_b_from_c) {
  const double c = std::cos(a_from_b.theta);
  const double s = std::sin(a_from_b.theta);
  Eigen::Matrix3d by_first = Eigen::Matrix3d::Identity();
  by_first(0, 2) = -s * b_from_c.x - c * b_from_c.y;
  by_first(1, 2) = c * b_from_c.x - s * b_from_c.y;
  Eigen::Matrix3d by_second = Eigen::Matrix3d::Identity();
  by_second.topLeftCorner<2, 2>() << c, -s, s, c;
  return by_first * covariance_a_from_b * by_first.transpose() +
         by_second * covariance_b_from_c * by_second.transpose();
}

}  // namespace matchbox_slam
