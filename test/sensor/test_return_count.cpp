#include <gtest/gtest.h>

#include <limits>

#include "sensor/return_count.hpp"

namespace matchbox_slam {
namespace {

/// A scan of which so many of 40 beams meet something.
LaserScan scan_with(std::size_t returns) {
  LaserScan scan;
  scan.angle_min = -1.0;
  scan.angle_increment = 0.05;
  scan.range_min = 0.1;
  scan.range_max = 8.0;
  scan.ranges.assign(40, std::numeric_limits<float>::infinity());
  std::fill_n(scan.ranges.begin(), returns, 2.0F);
  return scan;
}

TEST(ReturnCount, IsTheMedianOfAllScansOnceThereAreEnough) {
  ReturnCount count;
  for (std::size_t k = 0; k < 49; ++k) {
    count.add(scan_with(k < 30 ? 12 : 40), {});
    EXPECT_FALSE(count.median());
  }
  count.add(scan_with(0), {});
  EXPECT_EQ(count.median(), 12U);
}

TEST(ReturnCount, IsOfReadingsThatAreUsed) {
  LaserScan scan = scan_with(40);
  scan.ranges[0] = 0.05F;
  scan.ranges[1] = std::numeric_limits<float>::quiet_NaN();
  scan.ranges[2] = 8.5F;
  scan.ranges[3] = 7.0F;
  scan.ranges[4] = 0.3F;
  ProjectionOptions options;
  options.min_range = 0.5;
  options.max_range = 6.0;
  options.masked_angles = {0.76, 1.1};  // the last four
  ReturnCount count;
  for (int k = 0; k < 50; ++k) {
    count.add(scan, options);
  }
  EXPECT_EQ(count.median(), 31U);
}

}  // namespace
}  // namespace matchbox_slam
