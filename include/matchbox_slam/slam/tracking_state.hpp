#pragma once

namespace matchbox_slam {

/// How sure it is where the robot is in the map: a reading of the odds, see PoseHypotheses.
enum class TrackingState {
  kTracking,   ///< one hypothesis is far ahead
  kDoubt,      ///< another one may be right; what is seen goes on being mapped
  kLost,       ///< the robot may be anywhere: it maps a component, and searches for the map
  kRecovered,  ///< it was found; its component is being joined to the map
};

/// A word for logs and reports, such as "tracking".
[[nodiscard]] const char* to_string(TrackingState state);

}  // namespace matchbox_slam
