#include <gtest/gtest.h>

#include "ros/clock_watch.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {
namespace {

/// Scans and transforms at 10 Hz, the scans stamped by a clock that is off.
std::optional<double> watch(ClockWatch& clocks, double scan_clock, double seconds,
                            bool with_transforms = true) {
  std::optional<double> answer;
  for (int k = 0; k < static_cast<int>(10.0 * seconds) && !answer; ++k) {
    const double now = 1000.0 + 0.1 * k;
    if (with_transforms) {
      clocks.add_transforms(make_link(now, "odom", "base", 0.01 * k), ros::Time(now));
      clocks.add_transforms(make_link(now + 50.0, "map", "odom", 0.0), ros::Time(now));
    }
    clocks.add_scan(ros::Time(now + scan_clock), ros::Time(now));
    answer = clocks.conclude(ros::Time(now));
  }
  return answer;
}

TEST(ClockWatch, TellsByHowMuchScansAreBehind) {
  ClockWatch clocks("map");
  const std::optional<double> offset = watch(clocks, -82.2, 10.0);
  ASSERT_TRUE(offset);
  EXPECT_NEAR(*offset, 82.2, 1e-6);
  EXPECT_FALSE(clocks.is_watching());
  EXPECT_FALSE(clocks.conclude(ros::Time(2000.0))) << "once";
}

TEST(ClockWatch, DelaysInDriversAreNoDifference) {
  ClockWatch clocks("map");
  EXPECT_EQ(watch(clocks, -0.1, 10.0), 0.0);
}

TEST(ClockWatch, WaitsForEnoughOfBothButNotForEver) {
  ClockWatch clocks("map");
  EXPECT_FALSE(watch(clocks, -82.2, 1.9));
  ClockWatch alone("map");
  EXPECT_FALSE(watch(alone, -82.2, 4.5, false));
  EXPECT_EQ(alone.conclude(ros::Time(1006.0)), 0.0);
}

TEST(ClockWatch, TimeThatHasNotBegunSaysNothing) {
  ClockWatch clocks("map");
  clocks.add_scan(ros::Time(1000.0), ros::Time());
  EXPECT_FALSE(clocks.conclude(ros::Time(1000.0)));
}

}  // namespace
}  // namespace matchbox_slam
