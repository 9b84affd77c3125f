#pragma once

#include <Eigen/Core>
#include <vector>

namespace matchbox_slam {

/// The way of a thing that moves: round and round at one speed, without turning.
class Walk {
 public:
  /// @param corners  in order; from the last it goes on to the first.
  /// @param speed    [m/s]
  /// @param ahead    [m], how far along it is at time 0.
  /// Throws std::invalid_argument for a way of no length.
  Walk(std::vector<Eigen::Vector2d> corners, double speed, double ahead);

  /// Where it is [m] at a time [s], which may be any.
  [[nodiscard]] Eigen::Vector2d at(double time) const;

 private:
  std::vector<Eigen::Vector2d> corners_;  ///< the first again at the end
  double length_ = 0.0;
  double speed_;
  double ahead_;
};

}  // namespace matchbox_slam
