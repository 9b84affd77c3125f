// Of odometry/scan_motion.hpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "matchbox_slam/geometry/angles.hpp"
#include "odometry/scan_motion.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

class ScanMotionTest : public testing::Test {
 protected:
  std::optional<Pose2> add(std::size_t scan) { return motion_.add(scan_input(run_, scan, false)); }

  const SimulatedRun run_ = drive_through("rooms", 8.0, 3);
  ScanMotion motion_{{}};
};

TEST_F(ScanMotionTest, IsThatOfTheBase) {
  std::optional<Pose2> odom_from_base;
  for (std::size_t i = 0; i < run_.scans.size(); ++i) {
    odom_from_base = add(i);
    ASSERT_TRUE(odom_from_base) << i;
    const Pose2 truth = run_.world_from_base.front().inverse() * run_.world_from_base[i];
    EXPECT_NEAR((odom_from_base->translation() - truth.translation()).norm(), 0.0, 0.02);
    EXPECT_NEAR(wrap_angle(odom_from_base->theta - truth.theta), 0.0, 0.01);
  }
  EXPECT_GT(odom_from_base->translation().norm(), 1.0) << "it has driven";
}

TEST_F(ScanMotionTest, IsSteadyBetweenScans) {
  const std::size_t last = run_.scans.size() / 2;
  const std::size_t step = 10;
  std::optional<Pose2> first;
  for (std::size_t i = 0; i < last; i += step) {
    first = add(i);
    EXPECT_EQ(motion_.odom_from_base_at(run_.scans[i].stamp).has_value(), i > 0);
  }
  const double before = run_.scans[(last - 1) / step * step].stamp;
  const std::optional<Pose2> second = add(last);
  ASSERT_TRUE(first && second);
  ASSERT_GT(std::abs(second->x - first->x), 0.01) << "it drives";
  const double stamp = run_.scans[last].stamp;
  const auto quarter = motion_.odom_from_base_at(0.75 * before + 0.25 * stamp);
  ASSERT_TRUE(quarter);
  EXPECT_NEAR(quarter->x, 0.75 * first->x + 0.25 * second->x, 1e-3);
  EXPECT_NEAR(quarter->y, 0.75 * first->y + 0.25 * second->y, 1e-3);
  EXPECT_FALSE(motion_.odom_from_base_at(before - 0.01));
  EXPECT_FALSE(motion_.odom_from_base_at(stamp + 0.01));
}

TEST_F(ScanMotionTest, IsNotToldByWhatComesTwiceOrLateOrDoesNotMatch) {
  EXPECT_TRUE(add(0));
  EXPECT_FALSE(add(0)) << "twice";
  EXPECT_TRUE(add(1));
  const std::size_t late = run_.scans.size() - 2;
  EXPECT_FALSE(add(late));
  EXPECT_FALSE(motion_.odom_from_base_at(run_.scans[1].stamp));
  ScanInput covered = scan_input(run_, late + 1, false);
  std::fill(covered.scan.ranges.begin(), covered.scan.ranges.end(), 0.0F);
  EXPECT_FALSE(motion_.add(covered));
}

}  // namespace
}  // namespace matchbox_slam
