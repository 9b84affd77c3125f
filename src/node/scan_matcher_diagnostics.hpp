#pragma once

#include <diagnostic_updater/diagnostic_updater.h>

#include <cstddef>
#include <deque>
#include <map>
#include <string>

#include "matchbox_slam/odometry/laser_odometry.hpp"
#include "ros/scan_account.hpp"

namespace matchbox_slam {

/// What became of the scans that were used, since the node's start.
class MatchRecord {
 public:
  /// @param seconds  that the match took; 0: there was none.
  void add(const LaserOdometryOutcome& outcome, double seconds);

  [[nodiscard]] const std::map<MatchStatus, std::size_t>& statuses() const { return statuses_; }
  /// Scans that the guess stood for.
  [[nodiscard]] std::size_t failed() const;
  [[nodiscard]] std::size_t key_scans() const { return key_scans_; }
  [[nodiscard]] std::size_t restarts() const { return restarts_; }
  [[nodiscard]] std::size_t unconstrained() const { return unconstrained_; }
  /// Of the last 200 matches [s].
  [[nodiscard]] std::vector<float> recent_match_seconds() const;

 private:
  std::map<MatchStatus, std::size_t> statuses_;
  std::size_t key_scans_ = 0;
  std::size_t restarts_ = 0;
  std::size_t unconstrained_ = 0;  ///< scans with a direction that the guess alone decided
  std::deque<float> match_seconds_;
};

/// What /diagnostics tells about laser odometry.
struct ScanMatcherHealth {
  ScanAccount account;
  MatchRecord matches;
  std::size_t waiting = 0;  ///< scans
  std::string matcher;
  std::string last_skip;    ///< why a scan was skipped last, for people
  std::string tf_conflict;  ///< why no tf is published; empty: it is, or is not wanted
};

/// Judges laser odometry by what has happened since it was asked last: an error when it publishes
/// no tf though it should, a warning when scans were skipped, did not fit or none came.
class ScanMatcherDiagnostics {
 public:
  void fill(const ScanMatcherHealth& health, diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  ScanAccount account_before_;
  std::size_t failed_before_ = 0;
};

}  // namespace matchbox_slam
