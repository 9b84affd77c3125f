#include "simulation/walk.hpp"

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace matchbox_slam {

Walk::Walk(std::vector<Eigen::Vector2d> corners, double speed, double ahead)
    : corners_(std::move(corners)), speed_(speed), ahead_(ahead) {
  if (!corners_.empty()) {
    corners_.push_back(corners_.front());
  }
  for (std::size_t i = 1; i < corners_.size(); ++i) {
    length_ += (corners_[i] - corners_[i - 1]).norm();
  }
  if (!(length_ > 0.0) || !std::isfinite(length_)) {
    throw std::invalid_argument("a walk has length " + std::to_string(length_) +
                                "; it must be finite and above 0");
  }
}

Eigen::Vector2d Walk::at(double time) const {
  const double along = std::fmod(ahead_ + speed_ * time, length_);
  double left = along < 0.0 ? along + length_ : along;
  for (std::size_t i = 1; i < corners_.size(); ++i) {
    const double step = (corners_[i] - corners_[i - 1]).norm();
    if (left < step) {
      return corners_[i - 1] + left / step * (corners_[i] - corners_[i - 1]);
    }
    left -= step;
  }
  return corners_.back();
}

}  // namespace matchbox_slam
