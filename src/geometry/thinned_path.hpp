#pragma once

#include <cstddef>
#include <vector>

#include "geometry/trajectory.hpp"

namespace matchbox_slam {

/// The way of a robot for drawing, in bounded memory however long it drives: poses that are a
/// certain distance apart, and the newest. When there are too many, every second one goes and the
/// distance doubles.
class ThinnedPath {
 public:
  /// @param spacing  [m] between poses, > 0.
  /// @param most     poses kept, at least 4.
  explicit ThinnedPath(double spacing = 0.02, std::size_t most = 20000)
      : spacing_(spacing), most_(most) {}

  void add(const StampedPose2& pose);

  /// Puts poses right that are known better now.
  template <typename Change>
  void change(const Change& change) {
    change(poses_);
  }

  /// In the order in which they came; of those with one stamp, as of two lasers, the last.
  [[nodiscard]] const std::vector<StampedPose2>& poses() const { return poses_; }

 private:
  double spacing_;
  std::size_t most_;
  /// The last one gives way to the next while it is not far from the one before.
  std::vector<StampedPose2> poses_;
};

}  // namespace matchbox_slam
