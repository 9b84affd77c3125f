#include <gtest/gtest.h>

#include "bag/carmen_stamps.hpp"
#include "common/error_text.hpp"

namespace matchbox_slam {
namespace {

/// Scans, one every 0.2 s, each with an odometry in the middle before the next one.
std::vector<CarmenMoment> some_scans(std::size_t scans = 10) {
  std::vector<CarmenMoment> moments;
  for (std::size_t k = 0; k < 2 * scans; ++k) {
    const double time = 0.1 * static_cast<double>(k);
    moments.push_back({k + 1, k % 2 == 0, 976052857.0 + time, time});
  }
  return moments;
}

TEST(CarmenStamps, AreThoseOfTheMessages) {
  const CarmenStamps chosen = choose_stamps(some_scans());
  EXPECT_EQ(chosen.remark, "");
  EXPECT_EQ(chosen.stamps.at(3), 976052857.0 + 0.1 * 3.0);
}

TEST(CarmenStamps, OneOfTwentyOutOfOrderIsNoReasonToGiveThemUp) {
  std::vector<CarmenMoment> moments = some_scans(20);
  moments[4].ipc_stamp = moments[2].ipc_stamp;
  EXPECT_EQ(choose_stamps(moments).remark, "");
}

TEST(CarmenStamps, CutToSixDigitsTheyAreTheLoggers) {
  std::vector<CarmenMoment> moments = some_scans();
  for (CarmenMoment& moment : moments) {
    moment.ipc_stamp = 976053.0;
  }
  const CarmenStamps chosen = choose_stamps(moments);
  EXPECT_TRUE(contains(chosen.remark, "line 3 has 976053 after 976053")) << chosen.remark;
  EXPECT_TRUE(contains(chosen.remark, "of the logger")) << chosen.remark;
  EXPECT_DOUBLE_EQ(chosen.stamps.at(3), 1000000000.3);
}

TEST(CarmenStamps, AbsentTheyAreMadeUpAtASecondAScan) {
  std::vector<CarmenMoment> moments = some_scans();
  moments.insert(moments.begin(), {0, false, {}, {}});
  moments.insert(moments.begin() + 3, {0, false, {}, {}});
  for (CarmenMoment& moment : moments) {
    moment.ipc_stamp.reset();
    moment.logger_stamp.reset();
  }
  const CarmenStamps chosen = choose_stamps(moments);
  EXPECT_TRUE(contains(chosen.remark, "line 1 has none")) << chosen.remark;
  EXPECT_TRUE(contains(chosen.remark, "a second a scan, from 1000000000 on")) << chosen.remark;
  ASSERT_EQ(chosen.stamps.size(), moments.size());
  EXPECT_DOUBLE_EQ(chosen.stamps[0], 999999999.5);
  EXPECT_DOUBLE_EQ(chosen.stamps[1], 1000000000.0);  // the first scan
  EXPECT_DOUBLE_EQ(chosen.stamps[2], 1000000000.0 + 1.0 / 3.0);
  EXPECT_DOUBLE_EQ(chosen.stamps[3], 1000000000.0 + 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(chosen.stamps[4], 1000000001.0);
  EXPECT_DOUBLE_EQ(chosen.stamps.back(), 1000000009.5);
}

/// Where the stamps of some scans say that the clock was set back.
std::vector<std::size_t> steps_in(const std::vector<CarmenMoment>& moments) {
  return find_clock_steps(moments, choose_stamps(moments).stamps);
}

TEST(CarmenStamps, AClockThatIsSetBackIsSeen) {
  std::vector<CarmenMoment> moments = some_scans(40);
  EXPECT_TRUE(steps_in(moments).empty());
  for (std::size_t k = 31; k < moments.size(); ++k) {
    *moments[k].ipc_stamp -= 3.0;  // from an odometry on
  }
  for (std::size_t k = 60; k < moments.size(); ++k) {
    *moments[k].ipc_stamp -= 1000.0;
  }
  EXPECT_EQ(steps_in(moments), (std::vector<std::size_t>{31, 60}));
}

TEST(CarmenStamps, OfTwoScansThatAreWrongAreNoClock) {
  for (const double wrong : {-50.0, 50.0}) {
    std::vector<CarmenMoment> moments = some_scans(40);
    *moments[30].ipc_stamp += wrong;
    *moments[32].ipc_stamp += wrong;
    EXPECT_TRUE(steps_in(moments).empty()) << wrong;
  }
  // Nor is an odometry of another clock.
  std::vector<CarmenMoment> moments = some_scans(40);
  for (std::size_t k = 1; k < moments.size(); k += 2) {
    *moments[k].ipc_stamp -= 5.0;
  }
  EXPECT_TRUE(steps_in(moments).empty());
}

}  // namespace
}  // namespace matchbox_slam
