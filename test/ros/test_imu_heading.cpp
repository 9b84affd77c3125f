#include <gtest/gtest.h>
#include <tf2_eigen/tf2_eigen.h>

#include <Eigen/Geometry>
#include <limits>

#include "common/error_text.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "ros/imu_heading.hpp"
#include "ros/message_conversion.hpp"
#include "ros/messages.hpp"
#include "ros/transform_store.hpp"

namespace matchbox_slam {
namespace {

sensor_msgs::Imu imu_message(const Eigen::Quaterniond& world_from_imu) {
  sensor_msgs::Imu message;
  message.header.stamp = ros::Time(5.0);
  message.header.frame_id = "imu_link";
  message.orientation.w = world_from_imu.w();
  message.orientation.x = world_from_imu.x();
  message.orientation.y = world_from_imu.y();
  message.orientation.z = world_from_imu.z();
  return message;
}

Eigen::Quaterniond turn(double angle, const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
}

TEST(ImuHeading, IsTheBasesHoweverTheImuIsMounted) {
  constexpr double kYaw = 0.7;
  for (const Eigen::Quaterniond& base_from_imu :
       {Eigen::Quaterniond::Identity(), turn(kPi, Eigen::Vector3d::UnitX()),
        turn(1.2, Eigen::Vector3d::UnitZ()), turn(0.5 * kPi, Eigen::Vector3d::UnitY())}) {
    const Eigen::Quaterniond world_from_base = turn(kYaw, Eigen::Vector3d::UnitZ());
    geometry_msgs::TransformStamped mount = make_transform(0.0, "base_link", "imu_link", 0.3);
    mount.transform.rotation = tf2::toMsg(base_from_imu);
    const sensor_msgs::Imu message = imu_message(world_from_base * base_from_imu);
    ASSERT_EQ(find_defect(message), "");
    TransformStore store("");
    store.add(make_transforms({mount}), true);
    store.add(make_transforms({heading_link(message)}), false);
    const auto heading_from_base = store.lookup(kImuHeadingFrame, "base_link", ros::Time(5.0));
    ASSERT_TRUE(heading_from_base);
    EXPECT_NEAR(project_to_plane(*heading_from_base).theta, kYaw, 1e-9);
  }
}

TEST(ImuHeading, DoesNotGiveTheBaseASecondParent) {
  TransformStore store("");
  store.add(make_link(4.0, "odom", "base_link", 1.0), false);
  store.add(make_link(6.0, "odom", "base_link", 2.0), false);
  for (const double stamp : {4.0, 6.0}) {
    sensor_msgs::Imu message = imu_message(turn(stamp, Eigen::Vector3d::UnitZ()));
    message.header.stamp = ros::Time(stamp);
    message.header.frame_id = "/base_link";
    store.add(make_transforms({heading_link(message)}), false);
  }
  EXPECT_TRUE(store.covers("odom", "base_link", ros::Time(5.0)));
  const auto heading = store.lookup(kImuHeadingFrame, "base_link", ros::Time(5.0));
  ASSERT_TRUE(heading);
  EXPECT_NEAR(wrap_angle(project_to_plane(*heading).theta - 5.0), 0.0, 1e-9) << "interpolated";
}

TEST(ImuHeading, ToldWhatIsNone) {
  sensor_msgs::Imu message = imu_message(Eigen::Quaterniond::Identity());
  message.orientation_covariance[0] = -1.0;
  EXPECT_TRUE(contains(find_defect(message), "measures no orientation"));
  message = imu_message(Eigen::Quaterniond::Identity());
  message.orientation.w = 0.0;
  EXPECT_TRUE(contains(find_defect(message), "of length 0"));
  message.orientation.w = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(find_defect(message), "");
  message = imu_message(Eigen::Quaterniond::Identity());
  message.header.stamp = ros::Time();
  EXPECT_TRUE(contains(find_defect(message), "stamp"));
  message = imu_message(Eigen::Quaterniond::Identity());
  message.header.frame_id = "/";
  EXPECT_EQ(find_defect(message), "it does not name its frame");
}

}  // namespace
}  // namespace matchbox_slam
