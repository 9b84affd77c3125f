#include "matchbox_slam/simulation/cramer_rao_bound.hpp"

#include <algorithm>

namespace matchbox_slam {

Eigen::Matrix3d fisher_information(const std::vector<BeamTruth>& beams, const LaserScan& scan,
                                   const Pose2& world_from_base, double range_noise) {
  const Pose2 base_from_world = world_from_base.inverse();
  const Pose2 turn_to_base{0.0, 0.0, base_from_world.theta};
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < std::min(beams.size(), scan.ranges.size()); ++k) {
    const BeamTruth& beam = beams[k];
    const double range = scan.ranges[k];
    const bool is_measured = range >= scan.range_min && range < scan.range_max;
    if (!is_measured || !beam.segment || !(beam.cos_incidence > 0.0)) {
      continue;
    }
    const Eigen::Vector2d normal = turn_to_base * beam.normal;
    const Eigen::Vector2d end = base_from_world * beam.end;
    const double turning = normal.y() * end.x() - normal.x() * end.y();
    const Eigen::Vector3d gradient =
        Eigen::Vector3d(normal.x(), normal.y(), turning) / beam.cos_incidence;
    sum += gradient * gradient.transpose();
  }
  return sum / (range_noise * range_noise);
}

}  // namespace matchbox_slam
