#include "slam/seen_scans.hpp"

namespace matchbox_slam {
SeenScans::SeenScans(const MeasuredScan& leading, const std::map<int, FurtherScan>& further)
    : leading_(leading), further_(further), points_(project_scan(leading)) {
  if (further.empty()) {
    return;
  }
  together_ = points_;
  for (const auto& [laser, one] : further) {
    append(project_scan(one.measured), one.there_from_base, *together_);
  }
}

void SeenScans::put_right(const Pose2& motion) {
  if (motion != leading_.motion) {
    leading_.motion = motion;
    points_ = project_scan(leading_);
  }
}

}  // namespace matchbox_slam
