#include <gtest/gtest.h>

#include <string>

#include "node/scan_matcher_diagnostics.hpp"

namespace matchbox_slam {
namespace {

LaserOdometryOutcome outcome_of(MatchStatus status) {
  LaserOdometryOutcome outcome;
  outcome.match.status = status;
  return outcome;
}

TEST(ScanMatcherDiagnostics, JudgesWhatHasHappenedSince) {
  ScanMatcherDiagnostics diagnostics;
  ScanMatcherHealth health;
  const auto level = [&] {
    diagnostic_updater::DiagnosticStatusWrapper status;
    diagnostics.fill(health, status);
    return std::to_string(status.level) + " " + status.message;
  };
  EXPECT_EQ(level(), "1 no scans are coming in");
  health.account.received = 10;
  health.matches.add(outcome_of(MatchStatus::kRejectedNoReference), 0.0);
  health.matches.add(outcome_of(MatchStatus::kAccepted), 0.001);
  EXPECT_EQ(level(), "0 matching");
  health.account.received = 20;
  health.matches.add(outcome_of(MatchStatus::kRejectedLowScore), 0.001);
  EXPECT_EQ(level(), "1 1 scans did not fit; the guess stands for them");
  health.account.received = 30;
  EXPECT_EQ(level(), "0 matching") << "it is over";
  health.account.received = 31;
  health.account.skipped[SkipReason::kEmpty] = 1;
  health.last_skip = "it has no ranges";
  EXPECT_EQ(level(), "1 1 scans skipped; the last: it has no ranges");
  health.tf_conflict = "no tf";
  EXPECT_EQ(level(), "2 no tf");
}

TEST(MatchRecord, CountsAndForgetsOldTimes) {
  MatchRecord record;
  LaserOdometryOutcome outcome = outcome_of(MatchStatus::kAccepted);
  outcome.match.unconstrained_directions = {{1.0, 0.0}};
  outcome.is_key_scan = true;
  for (int k = 0; k < 300; ++k) {
    record.add(outcome, 0.001 * k);
  }
  EXPECT_EQ(record.statuses().at(MatchStatus::kAccepted), 300U);
  EXPECT_EQ(record.unconstrained(), 300U);
  EXPECT_EQ(record.key_scans(), 300U);
  EXPECT_EQ(record.failed(), 0U);
  ASSERT_EQ(record.recent_match_seconds().size(), 200U);
  EXPECT_NEAR(record.recent_match_seconds().front(), 0.1, 1e-6);
}

}  // namespace
}  // namespace matchbox_slam
