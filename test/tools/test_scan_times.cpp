// Of sensor/sweep_time_choice.hpp and sensor/scan_joiner.hpp: lasers whose messages tell times that
// cannot be, and whose turns come in parts, are mapped as well as if they told the truth.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "common/error_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

class ScanTimes : public testing::Test {
 protected:
  void simulate(const std::string& laser, int seed = 41, int seconds = 30) {
    const Outcome simulated = run_command(
        MATCHBOX_SIMULATE, "--world rooms --seed " + std::to_string(seed) + " --duration " +
                               std::to_string(seconds) + " --turn-rate 1 " + laser + " --bag " +
                               bag_ + " --truth " + truth_);
    ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  }

  /// [m] of the trajectory.
  double error(const std::string& arguments = "") {
    const Outcome mapped =
        run_command(MATCHBOX_MAP_BAG, bag_ + " --quiet --out " + out_ + " " + arguments);
    EXPECT_EQ(mapped.exit_code, 0) << mapped.output;
    told_ = mapped.output;
    return absolute_trajectory_error(read_tum(out_ + "/trajectory.tum"), read_tum(truth_))
        .translation.rmse;
  }

  TemporaryFolder folder_;
  const std::string bag_ = folder_ / "drive.bag";
  const std::string truth_ = folder_ / "truth.tum";
  const std::string out_ = folder_ / "out";
  std::string told_;
};

TEST_F(ScanTimes, OfLasersWhoseDriversTellNonsenseAreSeenFromTheirScans) {
  for (const std::string laser : {"lds01_as_sent", "rplidar_a1"}) {
    SCOPED_TRACE(laser);
    simulate("--sensor " + laser, 42);
    const double as_sent = error("--set scan/sweep_time=as_sent");
    EXPECT_EQ(told_, "");
    const double with_truth =
        error("--set scan/sweep_time=" + std::string(laser == "rplidar_a1" ? "0.1813" : "0.1994"));
    const double found = error();
    EXPECT_TRUE(contains(told_, "scans of the moving robot show a sweep of ")) << told_;
    EXPECT_LT(found, 1.1 * with_truth);  // 1.00, and 5 when it took two scans of turns to decide
    EXPECT_LT(found, 0.3 * as_sent);
  }
}

TEST_F(ScanTimes, AreSeenWithoutOdometry) {
  simulate("--sensor rplidar_a1 --no-odometry", 42);
  const double as_sent = error("--no-odom --set scan/sweep_time=as_sent");
  const double with_truth = error("--no-odom --set scan/sweep_time=0.1813");
  const double found = error("--no-odom");
  EXPECT_TRUE(contains(told_, "scans of the moving robot show a sweep of ")) << told_;
  EXPECT_LT(found, 1.3 * with_truth);  // 1.01
  EXPECT_LT(found, 0.3 * as_sent);
  simulate("--sensor rplidar_a1 --time-increment 0 --no-odometry");
  const double at_once = error("--no-odom");
  EXPECT_EQ(told_, "");
  EXPECT_EQ(at_once, error("--no-odom --set scan/sweep_time=0"));
}

TEST_F(ScanTimes, AreSeenWhereMostScansAreLeftOut) {
  simulate("--sensor rplidar_a1 --scan-rate 1", 42, 120);
  const double as_sent = error("--set scan/sweep_time=as_sent");
  const double with_truth = error("--set scan/sweep_time=0.1813");
  const double found = error();
  EXPECT_LT(found, 1.5 * with_truth);  // 1.15
  EXPECT_LT(found, 0.2 * as_sent);
}

TEST_F(ScanTimes, OfALaserThatTakesAllBeamsAtOnceStayAsTheyAre) {
  simulate("--sensor rplidar_a1 --time-increment 0");
  const double found = error();
  EXPECT_EQ(told_, "");
  EXPECT_EQ(found, error("--set scan/sweep_time=0"));
}

TEST_F(ScanTimes, OfATurnInPartsAreThoseOfAWholeTurn) {
  simulate("--sensor in_parts --parts 1");
  const double whole = error();
  EXPECT_EQ(told_, "");
  simulate("--sensor in_parts");
  const double joined = error();
  EXPECT_TRUE(contains(told_, "each turn of the laser comes in parts, here of 36 beams")) << told_;
  EXPECT_LT(joined, 1.05 * whole);  // 1.000 in twelve worlds and seeds
  const auto report = nlohmann::json::parse(read_file(out_ + "/report.json"));
  EXPECT_EQ(report["scans"]["received"], 301);
  EXPECT_EQ(report["scans"]["skipped_total"], 0);
  error("--set scan/join_parts=1");
  EXPECT_FALSE(contains(told_, "in parts")) << told_;
}

TEST_F(ScanTimes, ThatAreNoneAreRefused) {
  simulate("--sensor rplidar_a1");
  for (const std::string bad :
       {"scan/sweep_time=soon", "scan/sweep_time=-1", "scan/sweep_time=11", "scan/join_parts=0",
        "scan/join_parts=2.5", "scan/join_parts=all"}) {
    const Outcome refused =
        run_command(MATCHBOX_MAP_BAG, bag_ + " --quiet --out " + out_ + " --set " + bad);
    EXPECT_EQ(refused.exit_code, 2) << bad;
    EXPECT_TRUE(contains(refused.output, bad.substr(0, bad.find('=')) + ": ")) << refused.output;
    EXPECT_TRUE(contains(refused.output, "is not allowed; allowed: auto")) << refused.output;
  }
}

}  // namespace
}  // namespace matchbox_slam
