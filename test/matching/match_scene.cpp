#include "matching/match_scene.hpp"

#include <Eigen/LU>

#include "matchbox_slam/common/random.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"

namespace matchbox_slam {

PointScan look_around(const World& world, const LaserOptions& laser, const Pose2& world_from_base,
                      std::uint64_t seed) {
  const PoseAtTime at_rest = [&](double /*stamp*/) { return world_from_base; };
  return project_scan(simulate_scan(world, laser, at_rest, 0.0, seed).scan, laser.base_from_laser(),
                      {}, ProjectionOptions{});
}

MatchScene make_match_scene(const World& world, const LaserOptions& laser, double time,
                            std::uint64_t seed) {
  const RobotMotion motion = drive(world.route(), {});
  const auto look = [&](double stamp, std::uint64_t number) {
    return look_around(world, laser, motion.pose(stamp), mix_seed(seed, number));
  };
  MatchScene scene;
  for (int i = 0; i < 8; ++i) {
    const double stamp = time - 2.0 + 0.5 * i + (i < 4 ? 0.0 : 0.5);  // not at `time` itself
    scene.key_scans.push_back(
        placed(look(stamp, static_cast<std::uint64_t>(i) + 1), motion.pose(stamp)));
    const PlacedScan& key = scene.key_scans.back();
    insert_scan(*key.scan->points(), key.map_from_base, MapOptions{}, scene.map);
  }
  scene.scan = look(time, 0);
  scene.map_from_base = motion.pose(time);
  return scene;
}

const MatchScene& rooms_scene() {
  static const MatchScene kRooms = make_match_scene(make_rooms_world(7), LaserOptions{}, 15.0, 1);
  return kRooms;
}

Pose2 shifted(const Pose2& pose, const Eigen::Vector3d& by) {
  return {pose.x + by.x(), pose.y + by.y(), wrap_angle(pose.theta + by.z())};
}

Eigen::Vector3d shift_between(const Pose2& from, const Pose2& pose) {
  return {pose.x - from.x, pose.y - from.y, wrap_angle(pose.theta - from.theta)};
}

Eigen::Matrix3d prior_of(double sigma_xy, double sigma_theta) {
  return Eigen::Vector3d(sigma_xy * sigma_xy, sigma_xy * sigma_xy, sigma_theta * sigma_theta)
      .asDiagonal();
}

double normalised_error_square(const MatchResult& result, const Pose2& truth) {
  const Eigen::Vector3d error = shift_between(truth, result.map_from_base);
  return error.dot(result.covariance.inverse() * error);
}

}  // namespace matchbox_slam
