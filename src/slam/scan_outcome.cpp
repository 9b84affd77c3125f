#include "matchbox_slam/slam/scan_outcome.hpp"

namespace matchbox_slam {

const char* to_string(Certainty certainty) {
  switch (certainty) {
    case Certainty::kSure:
      return "sure";
    case Certainty::kOvertaken:
      return "overtaken";
    case Certainty::kNewGround:
      return "new_ground";
    case Certainty::kUnmatched:
      return "unmatched";
  }
  return "unknown";
}

const char* to_string(TrackingState state) {
  switch (state) {
    case TrackingState::kTracking:
      return "tracking";
    case TrackingState::kDoubt:
      return "doubt";
    case TrackingState::kLost:
      return "lost";
    case TrackingState::kRecovered:
      return "recovered";
  }
  return "unknown";
}

const char* status_text(const ScanOutcome& outcome) {
  return outcome.is_of_secondary_laser ? "of_further_laser" : to_string(outcome.match.status);
}

}  // namespace matchbox_slam
