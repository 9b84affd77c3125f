#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>

#include "common/error_text.hpp"
#include "node/slam_diagnostics.hpp"

namespace matchbox_slam {
namespace {

using diagnostic_msgs::DiagnosticStatus;

/// A robot that maps well: 200 scans at 40 Hz, matched in 2 ms.
SlamHealth healthy() {
  SlamHealth health;
  health.matcher = "matchbox_slam/Olson";
  for (int k = 0; k < 200; ++k) {
    health.recent.push_back({100.0 + 0.025 * k, 0.004, 0.002, 0.9, MatchStatus::kAccepted, 0});
  }
  health.account.received = 200;
  health.account.delivered = 200;
  health.map_bytes = 3 << 20;
  health.key_scans = 12;
  health.loops_closed = 4;
  return health;
}

diagnostic_updater::DiagnosticStatusWrapper judge(const SlamHealth& health) {
  diagnostic_updater::DiagnosticStatusWrapper status;
  SlamDiagnostics().fill(health, status);
  return status;
}

std::string value_of(const diagnostic_updater::DiagnosticStatusWrapper& status,
                     const std::string& key) {
  for (const auto& value : status.values) {
    if (value.key == key) {
      return value.value;
    }
  }
  return "none";
}

TEST(SlamDiagnostics, TellsHowItGoes) {
  const auto status = judge(healthy());
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
  EXPECT_EQ(status.message, "mapping");
  EXPECT_EQ(value_of(status, "Scan rate [Hz]"), "40.0");
  EXPECT_EQ(value_of(status, "Scan period [ms]"), "25.0");
  EXPECT_EQ(value_of(status, "Match time p95 [ms]"), "2.00");
  EXPECT_EQ(value_of(status, "Lag [s]"), "0.004");
  EXPECT_EQ(value_of(status, "Score"), "0.900");
  EXPECT_EQ(value_of(status, "Map memory [MB]"), "3.0");
  EXPECT_EQ(value_of(status, "Paused"), "no");
  EXPECT_EQ(value_of(status, "Key scans"), "12");
  EXPECT_EQ(value_of(status, "Loops closed"), "4");
  SlamHealth localising = healthy();
  localising.updates_map = false;
  EXPECT_EQ(judge(localising).message, "localising");
}

TEST(SlamDiagnostics, IsSureOfNothingBeforeAScanWasUsed) {
  SlamHealth health = healthy();
  health.recent.clear();
  health.account.delivered = 0;
  health.waiting = 200;
  const auto status = judge(health);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "no scan was used yet, 200 wait for their transforms");
  for (const char* key : {"State", "Certainty", "Match"}) {
    EXPECT_EQ(value_of(status, key), "no scan was used yet") << key;
  }
}

TEST(SlamDiagnostics, FramesThatAreNotThereAreAnError) {
  SlamHealth health = healthy();
  health.account.delivered = 0;
  health.account.skipped[SkipReason::kNoTransform] = 200;
  health.last_skip = "scan of 1 s skipped (no_transform): tf has no frame 'odm'";
  const auto status = judge(health);
  EXPECT_EQ(status.level, DiagnosticStatus::ERROR);
  EXPECT_EQ(status.message, "no scan can be used: " + health.last_skip);
  health.account.delivered = 1;
  EXPECT_EQ(judge(health).level, DiagnosticStatus::WARN) << "some can";
}

TEST(SlamDiagnostics, TellsWhatTheLogTells) {
  SlamHealth unsaved = healthy();
  unsaved.unsaved = "the disk is full";
  EXPECT_EQ(judge(unsaved).level, DiagnosticStatus::ERROR);
  EXPECT_EQ(judge(unsaved).message, "the map is not saved: the disk is full");
  SlamHealth rivals = healthy();
  rivals.rivals = "two nodes publish tf from the odometry frame 'odom': /a and /b";
  EXPECT_EQ(judge(rivals).level, DiagnosticStatus::WARN);
  EXPECT_EQ(judge(rivals).message, rivals.rivals);
  SlamHealth few = healthy();
  few.few_returns = "scans have 31 returns in the median";
  EXPECT_EQ(judge(few).level, DiagnosticStatus::WARN);
  EXPECT_EQ(judge(few).message, few.few_returns);
  SlamHealth masked = healthy();
  masked.robot_beams = "beams end on the robot itself";
  EXPECT_EQ(value_of(judge(masked), "Beams on the robot"), masked.robot_beams);
  EXPECT_EQ(judge(masked).level, DiagnosticStatus::OK);
}

TEST(SlamDiagnostics, SaysThatThereIsNoMapToLocaliseIn) {
  SlamHealth health = healthy();
  health.updates_map = false;
  health.recent.back().status = MatchStatus::kRejectedNoReference;
  const auto status = judge(health);
  EXPECT_EQ(status.level, DiagnosticStatus::ERROR);
  EXPECT_EQ(status.message,
            "there is no map to localise in, and slam/update_map is false; give one by ~load_map "
            "or initial_map");
}

TEST(SlamDiagnostics, SaysThatItMapsAnewWhereAMapWasDamaged) {
  SlamHealth health = healthy();
  health.set_aside = "/maps/map.damaged";
  const auto status = judge(health);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_TRUE(contains(status.message, "could not be read, and is in /maps/map.damaged; "))
      << status.message;
}

TEST(SlamDiagnostics, SaysThatItIsPaused) {
  SlamHealth health = healthy();
  health.paused = true;
  health.account.skipped[SkipReason::kPaused] = 7;
  const auto status = judge(health);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "paused: scans are skipped until ~pause is called with false");
  EXPECT_EQ(value_of(status, "Paused"), "yes");
}

TEST(SlamDiagnostics, WarnsOfSkippedScansOnce) {
  SlamHealth health = healthy();
  health.account.received += 3;
  health.account.skipped[SkipReason::kNoTransform] = 3;
  health.last_skip = "no transform";
  SlamDiagnostics diagnostics;
  diagnostic_updater::DiagnosticStatusWrapper status;
  diagnostics.fill(health, status);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.message, "3 scans skipped; the last: no transform");
  EXPECT_EQ(value_of(status, "Scans skipped: no_transform"), "3");
  health.account.received += 10;
  diagnostics.fill(health, status);
  EXPECT_EQ(status.level, DiagnosticStatus::OK);
  diagnostics.fill(health, status);
  EXPECT_EQ(status.message, "no scans are coming in");
}

TEST(SlamDiagnostics, WarnsWhenMatchingTakesLongerThanThereIsTime) {
  SlamHealth health = healthy();
  for (ScanHealth& scan : health.recent) {
    scan.match_seconds = 0.030;
  }
  const auto status = judge(health);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_TRUE(contains(status.message, "matching takes 30.0 ms, longer than the 25.0 ms"))
      << status.message;
}

TEST(SlamDiagnostics, SaysWhenTheRobotIsLost) {
  SlamHealth health = healthy();
  for (std::size_t k = 0; k < 60; ++k) {
    health.recent[2 * k].status = MatchStatus::kRejectedLowScore;
  }
  EXPECT_EQ(judge(health).level, DiagnosticStatus::WARN);
  EXPECT_TRUE(contains(judge(health).message, "30 % of the recent scans match nowhere near"));
  for (std::size_t k = 180; k < 200; ++k) {
    health.recent[k].status = MatchStatus::kRejectedLowScore;
  }
  EXPECT_EQ(judge(health).level, DiagnosticStatus::ERROR);
  EXPECT_TRUE(contains(judge(health).message, "lost"));
}

TEST(SlamDiagnostics, AScanThatFitsWhereItsMotionLeadsIsNotLost) {
  SlamHealth health = healthy();
  for (std::size_t k = 100; k < 200; ++k) {
    health.recent[k].status = MatchStatus::kRejectedUnexpected;
  }
  EXPECT_EQ(judge(health).level, DiagnosticStatus::WARN);
  EXPECT_TRUE(contains(judge(health).message,
                       "50 % of the recent scans match where their motion hardly leads to"))
      << judge(health).message;
}

TEST(SlamDiagnostics, TellsOfClocksThatDifferAndOfAStop) {
  SlamHealth health = healthy();
  health.estimated_clock_offset = 82.2;
  EXPECT_EQ(judge(health).message,
            "the clocks of scans and tf differ by 82.2 s; set scan_time_offset");
  health.stopped = true;
  EXPECT_EQ(judge(health).level, DiagnosticStatus::ERROR);
  EXPECT_TRUE(contains(judge(health).message, "~reset forgets it and begins anew"));
}

}  // namespace
}  // namespace matchbox_slam
