#include <gtest/gtest.h>

#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"

namespace matchbox_slam {
namespace {

TEST(PoseCovariance, OfWhatIsKnownApartIsDiagonal) {
  const Eigen::Matrix3d expected = Eigen::Vector3d(0.04, 0.04, 0.0001).asDiagonal();
  EXPECT_TRUE(covariance_of(0.2, 0.01).isApprox(expected));
}

/// What is long along x lies along -y of a frame that is turned by a quarter.
TEST(PoseCovariance, InATurnedFrameItsAxesTurnBack) {
  Eigen::Matrix3d covariance;
  covariance << 4.0, 0.5, 0.3, 0.5, 1.0, 0.2, 0.3, 0.2, 0.1;
  Eigen::Matrix3d expected;
  expected << 1.0, -0.5, 0.2, -0.5, 4.0, -0.3, 0.2, -0.3, 0.1;
  EXPECT_TRUE(in_turned_frame(covariance, 0.5 * kPi).isApprox(expected));
  EXPECT_TRUE(in_turned_frame(in_turned_frame(covariance, 0.7), -0.7).isApprox(covariance));
}

}  // namespace
}  // namespace matchbox_slam
