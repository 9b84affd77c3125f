#include <gtest/gtest.h>

#include <chrono>
#include <limits>

#include "common/error_text.hpp"
#include "ros/imu_heading.hpp"
#include "ros/messages.hpp"
#include "ros/transform_store.hpp"

namespace matchbox_slam {
namespace {

double x_at(const TransformStore& store, const std::string& target, const std::string& source,
            double stamp) {
  const auto transform = store.lookup(target, source, ros::Time(stamp));
  return transform ? transform->translation().x() : std::numeric_limits<double>::quiet_NaN();
}

TEST(TransformStore, InterpolatesBetweenTransforms) {
  TransformStore store("map");
  store.add(make_link(100.0, "odom", "base", 1.0), false);
  store.add(make_link(101.0, "odom", "base", 2.0), false);
  EXPECT_NEAR(x_at(store, "odom", "base", 100.25), 1.25, 1e-9);
  EXPECT_FALSE(store.covers("odom", "base", ros::Time(101.01)));
  EXPECT_FALSE(store.covers("odom", "base", ros::Time(99.99)));
}

TEST(TransformStore, StripsOneLeadingSlash) {
  TransformStore store("map");
  store.add(make_link(100.0, "/odom", "/base", 1.0), true);
  EXPECT_NEAR(x_at(store, "odom", "base", 5.0), 1.0, 0.0);
}

TEST(TransformStore, IgnoresWhatTouchesTheMapFrame) {
  TransformStore store("map");
  store.add(make_link(100.0, "odom", "base", 1.0), true);
  EXPECT_EQ(store.ignored_map_link(), "");
  store.add(make_link(100.0, "odom", "/map", 7.0), false);
  store.add(make_link(100.0, "map", "odom", 7.0), true);
  EXPECT_EQ(store.ignored_map_link(), "odom -> map");
  EXPECT_FALSE(store.covers("map", "base", ros::Time(100.0)));
}

TEST(TransformStore, TakesTransformsInAnyOrderAndTwice) {
  TransformStore store("map");
  for (const double stamp : {100.0, 103.0, 101.0, 101.0, 102.0, 100.0}) {
    store.add(make_link(stamp, "odom", "base", stamp - 100.0), false);
  }
  EXPECT_NEAR(x_at(store, "odom", "base", 101.5), 1.5, 1e-9);
  EXPECT_NEAR(x_at(store, "odom", "base", 102.5), 2.5, 1e-9);
}

TEST(TransformStore, ALinkThatStandsStillHasStoodStillBefore) {
  TransformStore store("map");
  store.add(make_link(100.5, "base", "laser", 0.3), false);
  EXPECT_FALSE(store.covers("base", "laser", ros::Time(100.0)));
  store.add(make_link(100.6, "base", "laser", 0.3), false);
  EXPECT_NEAR(x_at(store, "base", "laser", 100.0), 0.3, 0.0);
  EXPECT_FALSE(store.covers("base", "laser", ros::Time(100.7))) << "it may begin to move";
}

TEST(TransformStore, ALinkThatMovesIsNotExtrapolated) {
  TransformStore store("map");
  store.add(make_link(100.5, "odom", "base", 0.3), false);
  store.add(make_link(100.6, "odom", "base", 0.4), false);
  EXPECT_FALSE(store.covers("odom", "base", ros::Time(100.0)));
}

TEST(TransformStore, LeavesOutWhatIsNoTransform) {
  TransformStore store("map");
  auto bad = make_transform(100.0, "odom", "base", std::numeric_limits<double>::quiet_NaN());
  store.add(make_transforms({bad}), false);
  bad = make_transform(100.0, "odom", "base", 1.0);
  bad.transform.rotation.w = 0.0;
  store.add(make_transforms({bad}), false);
  bad = make_transform(100.0, "odom", "odom", 1.0);
  store.add(make_transforms({bad}), false);
  bad = make_transform(100.0, "", "base", 1.0);
  store.add(make_transforms({bad}), false);
  bad = make_transform(4.29e9, "odom", "base", 1.0);
  store.add(make_transforms({bad}), false);
  bad = make_transform(100.0, "odom", "base", 1e300);
  store.add(make_transforms({bad}), false);
  bad = make_transform(100.0, "odom", "base", 1.0);
  bad.header.stamp.nsec = 4'294'967'295U;
  store.add(make_transforms({bad}), false);
  store.add(make_link(100.0, "//", "base", 1.0), false);
  EXPECT_EQ(store.invalid_count(), 8U);
}

TEST(TransformStore, OneStampFarAheadCostsNoLink) {
  TransformStore store("map");
  store.add(make_link(100.0, "odom", "base", 1.0), false);
  store.add(make_link(3.9e9, "odom", "base", 7.0), false);
  for (const double stamp : {100.1, 100.2, 100.3, 100.4}) {
    store.add(make_link(stamp, "odom", "base", 1.0), false);
  }
  EXPECT_TRUE(store.covers("odom", "base", ros::Time(100.35)));
  EXPECT_NEAR(x_at(store, "odom", "base", 100.35), 1.0, 0.0);
}

TEST(TransformStore, ClearKeepsStaticLinks) {
  TransformStore store("map");
  store.add(make_link(100.0, "base", "laser", 0.3), true);
  store.add(make_link(100.0, "odom", "base", 1.0), false);
  store.clear();
  EXPECT_TRUE(store.covers("base", "laser", ros::Time(50.0)));
  EXPECT_FALSE(store.covers("odom", "base", ros::Time(100.0)));
  store.add(make_link(50.0, "odom", "base", 2.0), false);
  EXPECT_NEAR(x_at(store, "odom", "base", 50.0), 2.0, 0.0);
}

TEST(TransformStore, SaysWhyThereIsNoTransform) {
  TransformStore store("map");
  EXPECT_EQ(
      store.why_not("odom", "base", ros::Time(100.0)),
      "no transform from 'base' to 'odom' at 100.000: tf has no frame 'base', nor any other yet");
  store.add(make_link(100.0, "odom", "base", 1.0), false);
  store.add(make_link(100.0, "wall", "camera", 1.0), true);
  EXPECT_EQ(store.why_not("odom", "base", ros::Time(100.25)),
            "no transform from 'base' to 'odom' at 100.250: the newest is 0.250 s older");
  EXPECT_EQ(store.why_not("odom", "base_link", ros::Time(100.0)),
            "no transform from 'base_link' to 'odom' at 100.000: tf has no frame 'base_link'; it "
            "has base, camera, odom, wall");
  EXPECT_EQ(store.why_not("base", kImuHeadingFrame, ros::Time(100.0)),
            "no orientation by the IMU at 100.000: no usable message of the IMU has come yet");
  store.add(make_link(100.0, "imu_link", kImuHeadingFrame, 0.0), false);
  store.add(make_link(100.0, "base", "laser", 0.0), true);
  EXPECT_EQ(store.why_not("base", kImuHeadingFrame, ros::Time(100.0)),
            "no orientation by the IMU at 100.000: tf does not say how it is mounted");
  store.add(make_link(100.0, "base", "imu_link", 0.0), true);
  EXPECT_EQ(store.why_not("base", kImuHeadingFrame, ros::Time(100.25)),
            "no orientation by the IMU at 100.250: the newest is 0.250 s older");
  EXPECT_TRUE(contains(store.why_not("odom", "base", ros::Time(99.0)), "from later on only"));
  EXPECT_TRUE(contains(store.why_not("odom", "camera", ros::Time(100.0)), "does not connect them"));
}

TEST(TransformStore, ProjectsAPoseInSpaceOntoThePlane) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(1.0, 2.0, 3.0);
  pose.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()) *
              Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()));
  const Pose2 plane = project_to_plane(pose);
  EXPECT_DOUBLE_EQ(plane.x, 1.0);
  EXPECT_DOUBLE_EQ(plane.y, 2.0);
  EXPECT_NEAR(plane.theta, 0.5, 1e-12);
}

TEST(TransformStore, StaysFastOverALongDrive) {
  TransformStore store("map");
  const auto begin = std::chrono::steady_clock::now();
  std::size_t covered = 0;
  for (int k = 0; k < 120 * 600; ++k) {  // ten minutes at 120 Hz
    const double stamp = 1e9 + k / 120.0;
    store.add(make_link(stamp, "odom", "base", 0.01 * k), false);
    covered += store.covers("odom", "base", ros::Time(stamp - 0.004)) ? 1U : 0U;
  }
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(covered, 120U * 600U - 1U);
  EXPECT_LT(elapsed.count(), 5.0);
}

}  // namespace
}  // namespace matchbox_slam
