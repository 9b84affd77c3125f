#include "ros/scan_account.hpp"

#include <fmt/core.h>

#include <array>

namespace matchbox_slam {

const char* to_string(SkipReason reason) {
  // In the order of SkipReason.
  constexpr std::array kNames = {"no_transform", "duplicate_stamp", "out_of_order", "invalid",
                                 "empty",        "queue_full",      "too_late",     "time_jump",
                                 "stopped",      "paused",          "before_reset", "interrupted",
                                 "tilted"};
  return kNames.at(static_cast<std::size_t>(reason));
}

std::size_t ScanAccount::skipped_total() const {
  std::size_t total = 0;
  for (const auto& [reason, count] : skipped) {
    total += count;
  }
  return total;
}

std::string to_string(const ScanAccount& account) {
  std::string reasons;
  for (const auto& [reason, count] : account.skipped) {
    reasons += fmt::format("{}{}: {}", reasons.empty() ? " (" : ", ", to_string(reason), count);
  }
  return fmt::format("{} scans received, {} used, {} skipped{}", account.received,
                     account.delivered, account.skipped_total(),
                     reasons.empty() ? "" : reasons + ")");
}

}  // namespace matchbox_slam
