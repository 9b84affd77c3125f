#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/pose2.hpp"
#include "matchbox_slam/map/likelihood_field.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"

namespace matchbox_slam {

/// What the scan says about the pose, to second order. In units of weight: one metre of wall seen
/// with unit variance.
struct NormalEquations {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< over (x, y, theta) in the map frame
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// The points of a scan at one pose, each with the piece of wall next to it. A point's residual is
/// its distance to the line through that wall, or to its middle where the wall tells no direction.
///
/// The robust kernel is Geman and McClure's (1985): a residual r has the closeness k^2 / (k^2 +
/// r^2), 1 on the wall and 1/2 at the kernel's width k. It is shaped like a Gaussian, but made of
/// basic arithmetic, so that it is fast and yields the same bits everywhere.
class Correspondences {
 public:
  /// Points without a wall in reach take part with closeness 0. Cost: one look-up a point.
  Correspondences(const std::vector<ScanPoint>& points, const LikelihoodField& field,
                  const Pose2& map_from_base);

  /// The sum of squared residuals under the kernel, linearised for Gauss-Newton.
  [[nodiscard]] NormalEquations linearise(double kernel) const;

  /// Mean closeness, weighted by the walls' lengths, after a small step of the pose that leaves
  /// each point at its wall; `step` is (x, y, theta) in the map frame.
  [[nodiscard]] double closeness(double kernel, const Eigen::Vector3d& step) const;

  /// Length of wall that all points stand for [m].
  [[nodiscard]] double total_weight() const { return total_weight_; }

 private:
  /// Padded with points of no weight to a whole number of lanes.
  struct Arrays {
    std::vector<double> rotated_x, rotated_y;  ///< point minus the base's position, map axes [m]
    std::vector<double> offset_x, offset_y;    ///< point minus the wall's middle [m]
    /// The matrix [1 + c, s; s, 1 - c] / 2 projects on the wall's normal; with c = s = 0 it is half
    /// the identity, so that point to line and point to point are one formula.
    std::vector<double> c, s;
    std::vector<double> weight;
  };

  Arrays arrays_;
  double total_weight_ = 0.0;
};

}  // namespace matchbox_slam
