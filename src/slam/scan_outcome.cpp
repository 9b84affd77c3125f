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

}  // namespace matchbox_slam
