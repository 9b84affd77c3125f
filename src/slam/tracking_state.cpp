#include "matchbox_slam/slam/tracking_state.hpp"

namespace matchbox_slam {

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

}  // namespace matchbox_slam
