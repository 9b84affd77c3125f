#include "geometry/thinned_path.hpp"

namespace matchbox_slam {

void ThinnedPath::add(const StampedPose2& pose) {
  const std::size_t count = poses_.size();
  const bool newest_is_near =
      count >= 2 &&
      (poses_[count - 1].pose.translation() - poses_[count - 2].pose.translation()).norm() <
          spacing_;
  const bool is_of_one_moment = count >= 1 && poses_.back().stamp == pose.stamp;
  if (newest_is_near || is_of_one_moment) {
    poses_.back() = pose;
    return;
  }
  poses_.push_back(pose);
  if (poses_.size() <= most_) {
    return;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i + 1 < poses_.size(); i += 2) {
    poses_[kept++] = poses_[i];
  }
  poses_[kept++] = pose;
  poses_.resize(kept);
  spacing_ *= 2.0;
}

}  // namespace matchbox_slam
