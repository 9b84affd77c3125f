#include "matchbox_slam/ros/slam_diagnostics.hpp"

#include <diagnostic_msgs/DiagnosticStatus.h>

#include "matchbox_slam/ros/run_report.hpp"

namespace matchbox_slam {

namespace {

using diagnostic_msgs::DiagnosticStatus;

void summarize(const SlamHealth& health, const ScanAccount& before,
               diagnostic_updater::DiagnosticStatusWrapper& status) {
  const std::size_t received = health.account.received - before.received;
  const std::size_t skipped = health.account.skipped_total() - before.skipped_total();
  if (health.stopped) {
    status.summary(DiagnosticStatus::ERROR, "stopped, as time has jumped back");
  } else if (skipped > 0) {
    status.summary(DiagnosticStatus::WARN,
                   std::to_string(skipped) + " scans skipped; the last: " + health.last_skip);
  } else if (received == 0) {
    status.summary(DiagnosticStatus::WARN, "no scans are coming in");
  } else {
    status.summary(DiagnosticStatus::OK, "mapping");
  }
}

}  // namespace

void SlamDiagnostics::fill(const SlamHealth& health,
                           diagnostic_updater::DiagnosticStatusWrapper& status) {
  summarize(health, before_, status);
  status.add("Matcher", health.matcher);
  status.add("Scans received", health.account.received);
  status.add("Scans used", health.account.delivered);
  status.add("Scans waiting", health.waiting);
  for (const auto& [reason, count] : health.account.skipped) {
    status.add(std::string("Scans skipped: ") + to_string(reason), count);
  }
  const ErrorStatistics match = statistics_of(health.recent_match_seconds);
  status.addf("Match time p50 [ms]", "%.2f", 1e3 * match.median);
  status.addf("Match time p95 [ms]", "%.2f", 1e3 * match.p95);
  status.addf("Match time max [ms]", "%.2f", 1e3 * match.max);
  status.addf("Map memory [MB]", "%.1f", static_cast<double>(health.map_bytes) / (1024.0 * 1024.0));
  before_ = health.account;
}

}  // namespace matchbox_slam
