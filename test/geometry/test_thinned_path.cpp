#include <gtest/gtest.h>

#include "geometry/thinned_path.hpp"

namespace matchbox_slam {
namespace {

StampedPose2 at(double stamp, double x) { return {stamp, {x, 0.0, 0.0}}; }

TEST(ThinnedPath, KeepsPosesThatAreFarEnoughApartAndTheNewest) {
  ThinnedPath path(1.0, 100);
  for (int i = 0; i <= 45; ++i) {
    path.add(at(i, 0.1 * i));
  }
  std::vector<double> stamps;
  for (const StampedPose2& pose : path.poses()) {
    stamps.push_back(pose.stamp);
  }
  EXPECT_EQ(stamps, (std::vector<double>{0, 10, 20, 30, 40, 45}));
}

TEST(ThinnedPath, ARobotAtRestAddsNothing) {
  ThinnedPath path;
  for (int i = 0; i < 1000; ++i) {
    path.add(at(i, 0.0));
  }
  EXPECT_EQ(path.poses().size(), 2U);
  EXPECT_EQ(path.poses().back().stamp, 999.0);
}

TEST(ThinnedPath, IsBoundedAndStillCoversTheWholeWay) {
  ThinnedPath path(0.02, 100);
  constexpr int kPoses = 100000;
  for (int i = 0; i < kPoses; ++i) {
    path.add(at(i, 0.05 * i));
    ASSERT_LE(path.poses().size(), 100U);
    ASSERT_EQ(path.poses().back().stamp, i);
  }
  EXPECT_EQ(path.poses().front().stamp, 0.0);
  EXPECT_GE(path.poses().size(), 40U);
  double longest = 0.0;
  for (std::size_t i = 1; i < path.poses().size(); ++i) {
    longest = std::max(longest, path.poses()[i].pose.x - path.poses()[i - 1].pose.x);
  }
  EXPECT_LT(longest, 0.05 * kPoses / 20);
}

TEST(ThinnedPath, HasOnePoseAStamp) {  // of two lasers at one moment
  ThinnedPath path(0.1);
  for (const double stamp : {1.0, 2.0, 3.0}) {
    path.add({stamp, {stamp, 0.0, 0.0}});
    path.add({stamp, {stamp, 0.01, 0.0}});
  }
  const Trajectory poses(path.poses());
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_EQ(poses.poses()[1].pose.y, 0.01) << "the later one knows more";
}

}  // namespace
}  // namespace matchbox_slam
