#include "simulation/cramer_rao_bound.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace matchbox_slam {
namespace {

/// Calls `use` with each beam that was measured and tells something.
template <typename Use>
void for_each_measured(const std::vector<BeamTruth>& beams, const LaserScan& scan, Use&& use) {
  for (std::size_t k = 0; k < std::min(beams.size(), scan.ranges.size()); ++k) {
    const double range = scan.ranges[k];
    const bool is_measured = range >= scan.range_min && range < scan.range_max;
    if (is_measured && beams[k].segment && beams[k].cos_incidence > 0.0) {
      use(beams[k]);
    }
  }
}

/// One side of a wall, and what two scans tell of its line: information about the line's offset
/// along the normal at `origin` [m] and its direction [rad], with a range noise of 1 m.
struct Wall {
  Eigen::Vector2d origin;
  Eigen::Vector2d normal;
  Eigen::Matrix2d from_reference = Eigen::Matrix2d::Zero();
  Eigen::Matrix2d from_scan = Eigen::Matrix2d::Zero();

  [[nodiscard]] Eigen::Matrix2d told_by(const BeamTruth& beam) const {
    const Eigen::Vector2d along(-normal.y(), normal.x());
    const Eigen::Vector2d gradient(1.0, along.dot(beam.end - origin));
    return gradient * gradient.transpose() / (beam.cos_incidence * beam.cos_incidence);
  }

  /// About the difference of the two lines: variances add.
  [[nodiscard]] Eigen::Matrix2d of_difference() const {
    const Eigen::Matrix2d sum = from_reference + from_scan;
    return from_reference * sum.completeOrthogonalDecomposition().pseudoInverse() * from_scan;
  }
};

/// By the wall's number and the direction of its normal.
using Walls = std::map<std::tuple<std::size_t, double, double>, Wall>;

Wall& wall_of(const BeamTruth& beam, Walls& walls) {
  const auto key = std::make_tuple(*beam.segment, beam.normal.x(), beam.normal.y());
  return walls.try_emplace(key, Wall{beam.end, beam.normal}).first->second;
}

}  // namespace

Eigen::Matrix3d fisher_information(const std::vector<BeamTruth>& beams, const LaserScan& scan,
                                   const Pose2& world_from_base, double range_noise) {
  const Pose2 base_from_world = world_from_base.inverse();
  const Pose2 turn_to_base{0.0, 0.0, base_from_world.theta};
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for_each_measured(beams, scan, [&](const BeamTruth& beam) {
    const Eigen::Vector2d normal = turn_to_base * beam.normal;
    const Eigen::Vector2d end = base_from_world * beam.end;
    const double turning = normal.y() * end.x() - normal.x() * end.y();
    const Eigen::Vector3d gradient =
        Eigen::Vector3d(normal.x(), normal.y(), turning) / beam.cos_incidence;
    sum += gradient * gradient.transpose();
  });
  return sum / (range_noise * range_noise);
}

Eigen::Matrix3d fisher_information_of_pair(const std::vector<BeamTruth>& reference_beams,
                                           const LaserScan& reference_scan,
                                           const std::vector<BeamTruth>& beams,
                                           const LaserScan& scan, const Pose2& world_from_base,
                                           double range_noise) {
  Walls walls;
  for_each_measured(reference_beams, reference_scan, [&](const BeamTruth& beam) {
    Wall& wall = wall_of(beam, walls);
    wall.from_reference += wall.told_by(beam);
  });
  for_each_measured(beams, scan, [&](const BeamTruth& beam) {
    Wall& wall = wall_of(beam, walls);
    wall.from_scan += wall.told_by(beam);
  });
  const Pose2 base_from_world = world_from_base.inverse();
  const Pose2 turn_to_base{0.0, 0.0, base_from_world.theta};
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& [key, wall] : walls) {
    const Eigen::Vector2d normal = turn_to_base * wall.normal;
    const Eigen::Vector2d origin = base_from_world * wall.origin;
    Eigen::Matrix<double, 2, 3> line_by_motion;
    // Turned as `told_by` has it, a point farther along the wall goes back.
    line_by_motion << normal.x(), normal.y(), normal.y() * origin.x() - normal.x() * origin.y(),
        0.0, 0.0, -1.0;
    sum += line_by_motion.transpose() * wall.of_difference() * line_by_motion;
  }
  return (0.5 / (range_noise * range_noise)) * (sum + sum.transpose());
}

}  // namespace matchbox_slam
