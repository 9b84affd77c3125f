#include "node/slam_diagnostics.hpp"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "evaluation/error_statistics.hpp"
#include "ros/clock_comparison.hpp"

namespace matchbox_slam {

namespace {

using diagnostic_msgs::DiagnosticStatus;
using diagnostic_updater::DiagnosticStatusWrapper;

// So many scans in a row that match nowhere: the robot is elsewhere, or was carried away.
constexpr std::size_t kRejectedInRow = 20;

// Share of the recent scans that may match nowhere without a warning: a guess, half and double were
// not tried.
constexpr double kMaxRejectedShare = 0.2;

/// Whether it matches nowhere. One that is likelier where its motion leads to fits there.
bool is_rejected(const ScanHealth& scan) {
  return scan.status != MatchStatus::kAccepted &&
         scan.status != MatchStatus::kRejectedNoReference &&
         scan.status != MatchStatus::kRejectedUnexpected;
}

/// Seconds from scan to scan; 0 while there are too few.
double period_of(const std::deque<ScanHealth>& scans) {
  return scans.size() < 2
             ? 0.0
             : (scans.back().stamp - scans.front().stamp) / static_cast<double>(scans.size() - 1);
}

std::vector<float> match_seconds_of(const std::deque<ScanHealth>& scans) {
  std::vector<float> seconds;
  for (const ScanHealth& scan : scans) {
    if (scan.match_seconds > 0.0) {
      seconds.push_back(static_cast<float>(scan.match_seconds));
    }
  }
  return seconds;
}

TrackingState state_of(const std::deque<ScanHealth>& scans) {
  return scans.empty() ? TrackingState::kTracking : scans.back().state;
}

bool match_nowhere(const std::deque<ScanHealth>& scans) {
  return scans.size() >= kRejectedInRow &&
         std::all_of(scans.end() - kRejectedInRow, scans.end(), is_rejected);
}

bool is_unexpected(const ScanHealth& scan) {
  return scan.status == MatchStatus::kRejectedUnexpected;
}

double share_of(const std::deque<ScanHealth>& scans, bool (*is_such)(const ScanHealth&)) {
  const auto count = std::count_if(scans.begin(), scans.end(), is_such);
  return scans.empty() ? 0.0 : static_cast<double>(count) / static_cast<double>(scans.size());
}

double rejected_share(const std::deque<ScanHealth>& scans) { return share_of(scans, is_rejected); }

std::size_t skipped_for_transforms(const ScanAccount& account) {
  const auto found = account.skipped.find(SkipReason::kNoTransform);
  return found == account.skipped.end() ? 0 : found->second;
}

void summarize(const SlamHealth& health, const ScanAccount& before,
               DiagnosticStatusWrapper& status) {
  const std::size_t received = health.account.received - before.received;
  const std::size_t skipped = health.account.skipped_total() - before.skipped_total();
  const std::size_t used = health.account.delivered - before.delivered;
  const std::size_t without_transform =
      skipped_for_transforms(health.account) - skipped_for_transforms(before);
  const double period = period_of(health.recent);
  const double p95 = statistics_of(match_seconds_of(health.recent)).p95;
  if (health.stopped) {
    status.summary(
        DiagnosticStatus::ERROR,
        "stopped, as time has jumped back: no scan is used any more; ~save_map saves the "
        "map, ~reset forgets it and begins anew");
  } else if (health.paused) {
    status.summary(DiagnosticStatus::WARN,
                   "paused: scans are skipped until ~pause is called with false");
  } else if (!health.updates_map && !health.recent.empty() &&
             health.recent.back().status == MatchStatus::kRejectedNoReference) {
    status.summary(DiagnosticStatus::ERROR,
                   "there is no map to localise in, and slam/update_map is false; give one by "
                   "~load_map or initial_map");
  } else if (state_of(health.recent) == TrackingState::kLost) {
    status.summary(DiagnosticStatus::ERROR,
                   "lost: what is seen is mapped apart, and searched in the map; drive where the "
                   "map is known, or tell where the robot is by initialpose or ~relocalise");
  } else if (match_nowhere(health.recent)) {
    status.summary(DiagnosticStatus::ERROR,
                   fmt::format("lost: the last {} scans match nowhere near; tell where the robot "
                               "is by initialpose or ~relocalise",
                               kRejectedInRow));
  } else if (state_of(health.recent) == TrackingState::kDoubt) {
    status.summary(DiagnosticStatus::WARN,
                   "in doubt: the robot may be elsewhere than it is thought to be; the next scans "
                   "will tell, and what is mapped meanwhile moves with it");
  } else if (without_transform > 0 && used == 0) {
    status.summary(DiagnosticStatus::ERROR, "no scan can be used: " + health.last_skip);
  } else if (!health.unsaved.empty()) {
    status.summary(DiagnosticStatus::ERROR, "the map is not saved: " + health.unsaved);
  } else if (std::abs(health.estimated_clock_offset) > kMinToldClockOffset) {
    status.summaryf(DiagnosticStatus::WARN,
                    "the clocks of scans and tf differ by %.1f s; set scan_time_offset",
                    health.estimated_clock_offset);
  } else if (skipped > 0) {
    status.summary(DiagnosticStatus::WARN,
                   fmt::format("{} scans skipped; the last: {}", skipped, health.last_skip));
  } else if (received == 0) {
    status.summary(DiagnosticStatus::WARN, "no scans are coming in");
  } else if (health.recent.empty()) {
    status.summary(
        DiagnosticStatus::WARN,
        fmt::format("no scan was used yet, {} wait for their transforms", health.waiting));
  } else if (!health.rivals.empty()) {
    status.summary(DiagnosticStatus::WARN, health.rivals);
  } else if (period > 0.0 && p95 > period) {
    status.summaryf(
        DiagnosticStatus::WARN,
        "matching takes %.1f ms, longer than the %.1f ms from scan to scan; see max_lag "
        "and the matcher's deadline",
        1e3 * p95, 1e3 * period);
  } else if (rejected_share(health.recent) > kMaxRejectedShare) {
    status.summaryf(DiagnosticStatus::WARN, "%.0f %% of the recent scans match nowhere near",
                    100.0 * rejected_share(health.recent));
  } else if (share_of(health.recent, is_unexpected) > kMaxRejectedShare) {
    status.summaryf(DiagnosticStatus::WARN,
                    "%.0f %% of the recent scans match where their motion hardly leads to; see "
                    "motion/*",
                    100.0 * share_of(health.recent, is_unexpected));
  } else if (!health.set_aside.empty()) {
    status.summary(DiagnosticStatus::WARN,
                   fmt::format("mapping anew: the map to go on with could not be read, and is in "
                               "{}; ~load_map goes on with another one, ~reset keeps to a new one",
                               health.set_aside));
  } else if (!health.few_returns.empty()) {
    status.summary(DiagnosticStatus::WARN, health.few_returns);
  } else {
    status.summary(DiagnosticStatus::OK, health.updates_map ? "mapping" : "localising");
  }
}

void add_recent(const std::deque<ScanHealth>& scans, DiagnosticStatusWrapper& status) {
  const double period = period_of(scans);
  status.addf("Scan rate [Hz]", "%.1f", period > 0.0 ? 1.0 / period : 0.0);
  status.addf("Scan period [ms]", "%.1f", 1e3 * period);
  const ErrorStatistics match = statistics_of(match_seconds_of(scans));
  status.addf("Match time p50 [ms]", "%.2f", 1e3 * match.median);
  status.addf("Match time p95 [ms]", "%.2f", 1e3 * match.p95);
  status.addf("Match time max [ms]", "%.2f", 1e3 * match.max);
  const ScanHealth newest = scans.empty() ? ScanHealth{} : scans.back();
  status.addf("Lag [s]", "%.3f", newest.lag);
  status.addf("Score", "%.3f", newest.score);
  const bool is_any_used = !scans.empty();
  constexpr const char* kNone = "no scan was used yet";
  status.add("Match", is_any_used ? to_string(newest.status) : kNone);
  status.add("State", is_any_used ? to_string(newest.state) : kNone);
  status.add("Unconstrained directions", newest.unconstrained_directions);
  status.addf("Evidence", "%.3f", newest.evidence);
  status.add("Certainty", is_any_used ? to_string(newest.certainty) : kNone);
  status.addf("Scans that match nowhere [%]", "%.1f", 100.0 * rejected_share(scans));
}

}  // namespace

void SlamDiagnostics::fill(const SlamHealth& health, DiagnosticStatusWrapper& status) {
  summarize(health, before_, status);
  status.add("Matcher", health.matcher);
  status.add("Paused", health.paused ? "yes" : "no");
  status.add("Scans received", health.account.received);
  status.add("Scans used", health.account.delivered);
  status.add("Scans waiting", health.waiting);
  for (const auto& [reason, count] : health.account.skipped) {
    status.add(std::string("Scans skipped: ") + to_string(reason), count);
  }
  status.add("Scans left out of the map", health.left_out);
  status.add("Key scans", health.key_scans);
  status.add("Loops closed", health.loops_closed);
  status.add("Maps apart", health.disconnected_components);
  status.add("Maps apart given up", health.components_given_up);
  for (std::size_t i = 0; i < health.secondary_lasers.size(); ++i) {
    status.add(fmt::format("Secondary laser {}", i + 1), health.secondary_lasers[i]);
  }
  status.add("Beams on the robot", health.robot_beams.empty() ? "none seen" : health.robot_beams);
  add_recent(health.recent, status);
  status.addf("Map memory [MB]", "%.1f", static_cast<double>(health.map_bytes) / (1024.0 * 1024.0));
  before_ = health.account;
}

}  // namespace matchbox_slam
