// Of odometry/sweep_times.hpp.

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "matchbox_slam/geometry/angles.hpp"
#include "odometry/sweep_times.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

constexpr double kTurn = 0.18;  // [s] of the laser, which tells no times

SimulatedRun drive_of_turning_laser() {
  SimulationOptions options;
  options.laser.beams = 360;
  options.laser.field_of_view = 2.0 * kPi * 359.0 / 360.0;
  options.laser.scan_rate = 1.0 / kTurn;
  options.laser.time_increment = kTurn / 360.0;
  return drive_through("rooms", 15.0, 3, options);
}

class SweepTimesTest : public testing::TestWithParam<bool> {
 protected:
  /// [s] that the last of the scans is taken for.
  double sweep_of_last(SweepTimes& times) {
    double sweep = 0.0;
    for (std::size_t i = 0; i < run_.scans.size(); ++i) {
      ScanInput input = scan_input(run_, i, times.has_odometry());
      if (times.has_odometry()) {
        times.note_pose(2, input.scan.stamp, input.odometry->odom_from_base, [this](double stamp) {
          return std::optional(interpolate_odometry(run_.odometry, stamp));
        });
      }
      input.laser = 2;
      input.scan.time_increment = 0.0;
      input.scan.time_increment = times.time_increment(2, input.scan, 0.0);
      sweep = input.scan.duration();
      times.add(input, 0.0);
    }
    return sweep;
  }

  const SimulatedRun run_ = drive_of_turning_laser();
};

TEST_P(SweepTimesTest, AreSeenAndForgotten) {
  SweepTimes times({}, {}, {}, GetParam());
  EXPECT_NEAR(sweep_of_last(times), kTurn, 0.01);
  EXPECT_NE(times.take_news(2).find("scans of the moving robot show"), std::string::npos);
  times.forget();
  EXPECT_EQ(times.take_news(2), "");
  LaserScan next = run_.scans.back();
  next.time_increment = 0.0;
  EXPECT_EQ(times.time_increment(2, next, 0.0), 0.0) << "stamps begin anew";
}

TEST_P(SweepTimesTest, AreWhatTheyAreSetTo) {
  SweepTimes times({false, 0.1}, {}, {}, GetParam());
  EXPECT_NEAR(sweep_of_last(times), 0.1, 1e-9);
  EXPECT_FALSE(times.is_any_open());
  EXPECT_EQ(times.take_news(2), "");
}

TEST_P(SweepTimesTest, AreWhatTheRecordingHasShownOfThatLaser) {
  SweepTimes times({}, {{2, 0.15}}, {}, GetParam());
  EXPECT_NEAR(sweep_of_last(times), 0.15, 1e-9);
  EXPECT_FALSE(times.is_any_open());
  SweepTimes of_another({}, {{1, 0.15}}, {}, GetParam());
  EXPECT_NEAR(sweep_of_last(of_another), kTurn, 0.01);
  ASSERT_EQ(of_another.shown().count(2), 1U);
  EXPECT_NEAR(of_another.shown().at(2).seconds, kTurn, 0.01);
}

INSTANTIATE_TEST_SUITE_P(With, SweepTimesTest, testing::Bool(), [](const auto& has_odometry) {
  return has_odometry.param ? "Odometry" : "ScansAlone";
});

}  // namespace
}  // namespace matchbox_slam
