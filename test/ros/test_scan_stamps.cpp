#include <gtest/gtest.h>

#include "ros/scan_stamps.hpp"

namespace matchbox_slam {
namespace {

TEST(ScanStamps, HaveLasersThatWereNotHeardOfWaitedForButNotForLong) {
  ScanStamps stamps(2);
  stamps.note(ros::Time(100.0), 0);
  EXPECT_FALSE(stamps.is_next(ros::Time(100.0)));
  EXPECT_TRUE(stamps.is_next(ros::Time(100.6))) << "the other one is off";
  stamps.note(ros::Time(100.0), 1);
  EXPECT_TRUE(stamps.is_next(ros::Time(100.0)));
  EXPECT_FALSE(stamps.is_next(ros::Time(100.1))) << "both may send an earlier one";
}

TEST(ScanStamps, TellAClockThatWasSetBackByThreeScansOfALaserOlderThanItsOwn) {
  ScanStamps stamps(2);
  const ros::Time used(100.0);
  stamps.note(used, 0);
  stamps.note(ros::Time(97.0), 1);
  for (int k = 0; k < 5; ++k) {
    EXPECT_FALSE(stamps.is_set_back(ros::Time(97.1 + 0.1 * k), 1, &used)) << "it is late";
    EXPECT_EQ(stamps.is_set_back(ros::Time(50.0 + 0.1 * k), 0, &used), k >= 2) << k;
  }
  EXPECT_FALSE(stamps.is_set_back(ros::Time(50.0), 0, nullptr)) << "no scan was used";
}

TEST(ScanStamps, BelieveAStampFarAheadByTheThird) {
  ScanStamps stamps(1);
  const ros::Time now(200.0);
  EXPECT_FALSE(stamps.leaps_ahead(ros::Time(100.0), now)) << "the first";
  EXPECT_FALSE(stamps.leaps_ahead(ros::Time(159.0), now));
  EXPECT_TRUE(stamps.leaps_ahead(ros::Time(5000.0), now));
  EXPECT_TRUE(stamps.leaps_ahead(ros::Time(5000.1), now));
  EXPECT_FALSE(stamps.leaps_ahead(ros::Time(5000.2), now));
}

TEST(ScanStamps, KnowWhatComesFromBeforeATimeJump) {
  ScanStamps stamps(1);
  EXPECT_FALSE(stamps.is_straggler(ros::Time(100.0), ros::Time(100.0)));
  stamps.note(ros::Time(100.0), 0);
  stamps.jump_back(50.0, ros::Time(50.0));
  EXPECT_TRUE(stamps.is_straggler(ros::Time(99.0), ros::Time(51.0)));
  EXPECT_FALSE(stamps.is_straggler(ros::Time(50.5), ros::Time(51.0)));
  EXPECT_FALSE(stamps.is_straggler(ros::Time(99.0), ros::Time(52.5))) << "too late for one";
}

}  // namespace
}  // namespace matchbox_slam
