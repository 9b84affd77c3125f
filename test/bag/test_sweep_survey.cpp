// Of bag/sweep_survey.hpp, and of BagScans as far as it goes by that.

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "bag/scans_of_bag.hpp"
#include "bag/simulated_bag.hpp"
#include "bag/sweep_survey.hpp"
#include "io/temporary_folder.hpp"
#include "ros/messages.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

constexpr double kTurn = 0.18;  // [s] of the laser

LaserOptions turning_laser() {
  LaserOptions laser;
  laser.beams = 360;
  laser.field_of_view = 2.0 * kPi * 359.0 / 360.0;
  laser.time_increment = kTurn / 360.0;
  return laser;
}

class SweepSurvey : public testing::Test {
 protected:
  /// @param sent  [s] between beams, as messages tell it.
  void record(double sent, bool sweeps = true, double seconds = 20.0, double rate = 1.0 / kTurn) {
    SimulationOptions options;
    options.laser = turning_laser();
    options.laser.time_increment = sweeps ? options.laser.time_increment : 0.0;
    options.laser.sent_time_increment = sent;
    options.laser.scan_rate = rate;
    SimulatedBagWriter(path_, {"bz2"})
        .write(drive_through("rooms", seconds, 3, options), {"rooms", 3, options.laser, {}});
  }

  /// Times between the beams of all scans that are mapped [s].
  std::vector<double> increments(const BagPeriod& period = {}, bool is_repetition = false) {
    BagRequest request;
    request.bags = {path_};
    request.scan_topics = topics_;
    request.period = period;
    request.is_repetition = is_repetition;
    told_.clear();
    std::vector<double> all;
    for (const ScanInput& input : scans_of_bag(request, told_)) {
      all.push_back(input.scan.time_increment);
    }
    return all;
  }

  struct Part {
    double from;  ///< [s] from the begin of the recording, as the next
    double to;
    double later;  ///< [s] by which it was recorded later than its stamps say
  };
  /// Makes of the recording one of parts of it, by the time of recording, after a link of tf that
  /// came this much [s] after its begin.
  void copy(const std::vector<Part>& parts, double link = 0.0) {
    const std::string whole = folder_ / "whole.bag";
    std::filesystem::rename(path_, whole);
    const rosbag::Bag from(whole, rosbag::bagmode::Read);
    rosbag::Bag to(path_, rosbag::bagmode::Write);
    rosbag::View view(from);
    for (const Part& part : parts) {
      for (const rosbag::MessageInstance& message : view) {
        const double at = (message.getTime() - view.getBeginTime()).toSec();
        if (at >= part.from && at <= part.to) {
          to.write(message.getTopic(), message.getTime() + ros::Duration(part.later), message);
        }
      }
    }
    if (link != 0.0) {
      const ros::Time time = view.getBeginTime() + ros::Duration(link);
      to.write("/tf", time, make_link(time.toSec(), "elsewhere", "nowhere", 1.0));
    }
  }

  TemporaryFolder folder_;
  const std::string path_ = folder_ / "drive.bag";
  std::vector<std::string> topics_;  ///< none: the only one
  std::vector<std::string> told_;
};

TEST_F(SweepSurvey, ScansAreMappedFromTheFirstOnWithWhatAllOfThemShow) {
  record(0.0);
  const std::vector<double> all = increments();
  ASSERT_GT(all.size(), 100U);
  EXPECT_NEAR(all.front(), kTurn / 360.0, 0.02 * kTurn / 360.0);
  EXPECT_EQ(all, std::vector<double>(all.size(), all.front()));
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_NE(told_.front().find("scans of the moving robot show a sweep of "), std::string::npos);
}

TEST_F(SweepSurvey, IsTheSameForEachPartOfARecording) {
  record(0.0);
  const double whole = increments().front();
  EXPECT_EQ(increments({0.0, 2.0}).front(), whole);
  EXPECT_EQ(increments({15.0, 2.0}).front(), whole);
}

TEST_F(SweepSurvey, LeavesAloneWhatCanBe) {
  record(kTurn / 360.0);
  const std::vector<double> all = increments();
  EXPECT_EQ(all, std::vector<double>(all.size(), all.front()));
  EXPECT_NEAR(all.front(), kTurn / 360.0, 1e-9);
  EXPECT_TRUE(told_.empty());
  record(0.0, false);
  EXPECT_EQ(increments().front(), 0.0);
  EXPECT_TRUE(told_.empty());
}

/// It had not seen yet what came later.
TEST_F(SweepSurvey, RepeatsANodeThatWentByTheScansBeforeEach) {
  record(0.0);
  const std::vector<double> all = increments({}, true);
  EXPECT_EQ(all.front(), 0.0);
  EXPECT_NEAR(all.back(), kTurn / 360.0, 0.02 * kTurn / 360.0);
}

TEST_F(SweepSurvey, CountsItsTimeFromTheFirstScanOn) {
  record(0.0);
  copy({{0.0, 20.0, 0.0}}, -200.0);
  EXPECT_NEAR(increments().front(), kTurn / 360.0, 0.02 * kTurn / 360.0);
}

TEST_F(SweepSurvey, KeepsWhatWasShownBeforeTimeJumpedBack) {
  record(0.0, true, 40.0, 1.0);
  const double whole = increments().front();
  copy({{0.0, 40.0, 0.0}, {0.0, 5.0, 45.0}});
  const std::vector<double> all = increments();
  EXPECT_EQ(all, std::vector<double>(all.size(), all.front()));
  EXPECT_NEAR(all.front(), whole, 0.01 * whole);  // the last scan before tells, too
}

TEST_F(SweepSurvey, GoesOnWithSeveralLasersWhereTimeJumpsBack) {
  SimulationOptions options;
  options.laser = turning_laser();
  options.laser.sent_time_increment = 0.0;
  options.laser.scan_rate = 1.0 / kTurn;
  options.drive.rest = 4.0;
  options.second_laser = SecondLaserOptions{{-0.2, 0.0, kPi}, {-0.2, 0.0, kPi}};
  SimulatedBagWriter(path_, {}).write(drive_through("rooms", 20.0, 3, options),
                                      {"rooms", 3, options.laser, {}});
  topics_ = {"/base_scan", "/second_scan"};
  const double whole = increments().front();
  ASSERT_EQ(told_.size(), 2U);
  EXPECT_EQ(told_[0].find("/base_scan: scans of the moving robot"), 0U) << told_[0];
  copy({{0.0, 4.0, 0.0}, {0.0, 20.0, 5.0}});
  EXPECT_NEAR(increments().front(), whole, 0.01 * whole);
}

/// It stands longer than that.
TEST_F(SweepSurvey, LooksAtTenMinutesOfScans) {
  SimulationOptions options;
  options.laser = turning_laser();
  options.laser.sent_time_increment = 0.0;
  options.laser.scan_rate = 1.0;
  options.drive.rest = 620.0;
  SimulatedBagWriter(path_, {}).write(drive_through("rooms", 680.0, 3, options),
                                      {"rooms", 3, options.laser, {}});
  EXPECT_EQ(increments().front(), 0.0);
}

TEST_F(SweepSurvey, GoesAsFarAsADamagedBagCanBeRead) {
  record(0.0, true, 90.0, 0.5);  // it is reached before enough scans of a turning robot are seen
  const auto size = static_cast<std::streamoff>(std::filesystem::file_size(path_));
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(size / 2);
  file << "damaged";
  file.close();
  EXPECT_NEAR(increments().front(), kTurn / 360.0, 0.15 * kTurn / 360.0);  // by few scans
}

}  // namespace
}  // namespace matchbox_slam
