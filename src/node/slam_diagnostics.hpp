#pragma once

#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/time.h>

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "matchbox_slam/slam/slam_engine.hpp"
#include "ros/scan_account.hpp"

namespace matchbox_slam {

/// What is told of one scan.
struct ScanHealth {
  double stamp = 0.0;          ///< [s]
  double lag = 0.0;            ///< [s] from its stamp to the end of its processing
  double match_seconds = 0.0;  ///< 0: it was not matched
  double score = 0.0;
  MatchStatus status = MatchStatus::kAccepted;
  std::size_t unconstrained_directions = 0;
  Certainty certainty = Certainty::kSure;
  double evidence = 0.0;  ///< of a beam; see ScanEvidence
  TrackingState state = TrackingState::kTracking;
};

/// What /diagnostics tells about the mapping.
struct SlamHealth {
  ScanAccount account;
  std::size_t waiting = 0;        ///< scans
  bool stopped = false;           ///< at a jump of time
  std::deque<ScanHealth> recent;  ///< scans, oldest first
  bool updates_map = true;
  bool paused = false;
  std::string matcher;
  std::size_t map_bytes = 0;
  std::size_t key_scans = 0;
  std::size_t loops_closed = 0;  ///< by this run, not those of a map that it went on with
  std::size_t disconnected_components = 0;
  std::size_t components_given_up = 0;        ///< of those
  std::vector<std::string> secondary_lasers;  ///< where each is, for people
  std::string robot_beams;                    ///< what to say of these; empty: there are none
  std::string few_returns;   ///< what to say of scans that are too small; empty: they are not
  std::size_t left_out = 0;  ///< scans that the map had no room for
  std::string set_aside;     ///< where a damaged map was moved; empty: none was
  std::string last_skip;     ///< why a scan was skipped last, for people
  double estimated_clock_offset = 0.0;  ///< [s] that scans should be moved by and are not
  std::string unsaved;                  ///< why saving by itself has failed; empty: it has not
  std::string rivals;  ///< who publishes tf besides the one that should; empty: nobody
};

/// Judges the mapping by what has happened since it was asked last, and by the newest scans: an
/// error when it has stopped or the robot is lost; a warning when scans were skipped or none came,
/// many do not match, or matching takes longer than there is time.
class SlamDiagnostics {
 public:
  void fill(const SlamHealth& health, diagnostic_updater::DiagnosticStatusWrapper& status);

 private:
  ScanAccount before_;
};

}  // namespace matchbox_slam
