#include "benchmark_scene.hpp"

#include <map>

#include "matchbox_slam/common/random.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"

namespace matchbox_slam {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr double kTime = 30.0;  ///< [s] since the start of the route

}  // namespace

const World& benchmark_world() {
  static const World kWorld = make_rooms_world(kSeed);
  return kWorld;
}

LaserOptions laser_of(int beams) {
  LaserOptions laser;
  laser.beams = beams;
  return laser;
}

const MatchScene& benchmark_scene(int beams) {
  static std::map<int, MatchScene> scenes;
  const auto found = scenes.find(beams);
  return found != scenes.end()
             ? found->second
             : scenes
                   .emplace(beams,
                            make_match_scene(benchmark_world(), laser_of(beams), kTime, kSeed))
                   .first->second;
}

LaserScan benchmark_scan(int beams) {
  const Pose2 pose = benchmark_scene(beams).map_from_base;
  const PoseAtTime at_rest = [&pose](double /*stamp*/) { return pose; };
  return simulate_scan(benchmark_world(), laser_of(beams), at_rest, 0.0, kSeed).scan;
}

std::vector<LocatedPoints> scans_along_route(int beams, double duration, int count) {
  const RobotMotion motion = drive(benchmark_world().route(), {});
  std::vector<LocatedPoints> scans;
  for (int i = 0; i < count; ++i) {
    const Pose2 pose = motion.pose(duration * i / count);
    const std::uint64_t seed = mix_seed(kSeed, static_cast<std::uint64_t>(i));
    scans.push_back({look_around(benchmark_world(), laser_of(beams), pose, seed), pose});
  }
  return scans;
}

}  // namespace matchbox_slam
