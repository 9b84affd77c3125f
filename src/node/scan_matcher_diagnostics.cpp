#include "node/scan_matcher_diagnostics.hpp"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <fmt/core.h>

#include "evaluation/error_statistics.hpp"

namespace matchbox_slam {

using diagnostic_msgs::DiagnosticStatus;

void MatchRecord::add(const LaserOdometryOutcome& outcome, double seconds) {
  constexpr std::size_t kRecentMatches = 200;
  ++statuses_[outcome.match.status];
  key_scans_ += outcome.is_key_scan ? 1 : 0;
  restarts_ += outcome.restarted ? 1 : 0;
  unconstrained_ += outcome.match.unconstrained_directions.empty() ? 0 : 1;
  if (seconds > 0.0) {
    match_seconds_.push_back(static_cast<float>(seconds));
  }
  if (match_seconds_.size() > kRecentMatches) {
    match_seconds_.pop_front();
  }
}

std::size_t MatchRecord::failed() const {
  std::size_t failed = 0;
  for (const auto& [status, count] : statuses_) {
    const bool stands = status == MatchStatus::kAccepted ||
                        status == MatchStatus::kRejectedNoReference;  // it starts a local map
    failed += stands ? 0 : count;
  }
  return failed;
}

std::vector<float> MatchRecord::recent_match_seconds() const {
  return {match_seconds_.begin(), match_seconds_.end()};
}

void ScanMatcherDiagnostics::fill(const ScanMatcherHealth& health,
                                  diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::size_t received = health.account.received - account_before_.received;
  const std::size_t skipped = health.account.skipped_total() - account_before_.skipped_total();
  const std::size_t failed = health.matches.failed() - failed_before_;
  if (!health.tf_conflict.empty()) {
    status.summary(DiagnosticStatus::ERROR, health.tf_conflict);
  } else if (skipped > 0) {
    status.summary(DiagnosticStatus::WARN,
                   fmt::format("{} scans skipped; the last: {}", skipped, health.last_skip));
  } else if (failed > 0) {
    status.summary(DiagnosticStatus::WARN,
                   fmt::format("{} scans did not fit; the guess stands for them", failed));
  } else if (received == 0) {
    status.summary(DiagnosticStatus::WARN, "no scans are coming in");
  } else {
    status.summary(DiagnosticStatus::OK, "matching");
  }
  status.add("Matcher", health.matcher);
  status.add("Scans received", health.account.received);
  status.add("Scans used", health.account.delivered);
  status.add("Scans waiting", health.waiting);
  for (const auto& [reason, count] : health.account.skipped) {
    status.add(std::string("Scans skipped: ") + to_string(reason), count);
  }
  for (const auto& [match, count] : health.matches.statuses()) {
    status.add(std::string("Matches: ") + to_string(match), count);
  }
  status.add("Matches with a direction left to the guess", health.matches.unconstrained());
  status.add("Key scans", health.matches.key_scans());
  status.add("Local maps given up", health.matches.restarts());
  const ErrorStatistics match = statistics_of(health.matches.recent_match_seconds());
  status.addf("Match time p50 [ms]", "%.2f", 1e3 * match.median);
  status.addf("Match time p95 [ms]", "%.2f", 1e3 * match.p95);
  status.addf("Match time max [ms]", "%.2f", 1e3 * match.max);
  account_before_ = health.account;
  failed_before_ = health.matches.failed();
}

}  // namespace matchbox_slam
