#include "matchbox_slam/simulation/cramer_rao_bound.hpp"

namespace matchbox_slam {

Eigen::Matrix3d fisher_information(const std::vector<BeamTruth>& beams,
                                   const Pose2& world_from_base, double range_noise) {
  const Pose2 base_from_world = world_from_base.inverse();
  const Pose2 turn_to_base{0.0, 0.0, base_from_world.theta};
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const BeamTruth& beam : beams) {
    // Not a number, infinite or along the wall: no information.
    if (!beam.segment || !(beam.cos_incidence > 0.0)) {
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
