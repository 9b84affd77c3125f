// Of sensor/point_scan.hpp, matching/refinement.hpp and what else sees every scan: how often memory
// is asked for, scan after scan. `new` is replaced here for all that this program links, hence it
// is one of its own.

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#include "matchbox_slam/matching/free_space_violation.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matchbox_slam/matching/refinement.hpp"
#include "matchbox_slam/slam/slam_engine.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"

namespace {

std::atomic<std::size_t> allocations{0};

void* counted(void* memory) {
  ++allocations;
  if (memory == nullptr) {
    throw std::bad_alloc();
  }
  return memory;
}

}  // namespace

// Where one of them is inlined and its counterpart is not, the compiler takes them for mismatched.
[[gnu::noinline]] void* operator new(std::size_t bytes) { return counted(std::malloc(bytes + 1)); }
[[gnu::noinline]] void* operator new(std::size_t bytes, std::align_val_t alignment) {
  const auto unit = static_cast<std::size_t>(alignment);
  return counted(std::aligned_alloc(unit, (bytes / unit + 1) * unit));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t /*bytes*/) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t /*unit*/) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t /*bytes*/,
                                       std::align_val_t /*unit*/) noexcept {
  std::free(memory);
}

namespace matchbox_slam {
namespace {

LaserScan scan_in(const World& world, const LaserOptions& laser) {
  return simulate_scan(
             world, laser,
             [](double /*stamp*/) {
               return Pose2{1.0, 1.0, 0.0};
             },
             0.0, 1)
      .scan;
}

LaserOptions laser_with(int beams) {
  LaserOptions laser;
  laser.beams = beams;
  return laser;
}

template <typename Work>
std::size_t allocations_of(const Work& work) {
  work();  // what is kept for good is there then
  const std::size_t before = allocations;
  work();
  return allocations - before;
}

TEST(Allocations, NoneOfAProjectorButAtFirst) {
  const World world = make_rooms_world(1);
  ScanProjector projector;
  PointScan points;
  for (const int beams : {10000, 1040}) {
    const LaserOptions laser = laser_with(beams);
    const LaserScan scan = scan_in(world, laser);
    const auto project = [&] {
      projector.project(scan, laser.base_from_laser(), {}, {}, Eigen::Isometry3d::Identity(),
                        points);
    };
    EXPECT_EQ(allocations_of(project), 0U) << beams << " beams";
  }
}

TEST(Allocations, NoneOfARefinementWithItsCovarianceButAtFirst) {
  Correspondences pairs;
  std::vector<std::array<double, 2>> costs;
  for (const int beams : {10000, 1040}) {
    const MatchScene scene = make_match_scene(make_rooms_world(1), laser_with(beams), 30.0, 1);
    const Pose2 start = shifted(scene.map_from_base, {0.04, -0.03, 0.02});
    const PosePrior prior{start, prior_of(0.05, 0.03)};
    const std::vector<Eigen::Vector3d> steps(62, Eigen::Vector3d(0.01, 0.01, 0.01));
    const auto refine_once = [&] {
      pairs.assign(scene.scan.points, scene.map.field, start);
      const RefinedPose refined = refine(pairs, start, prior, {});
      LocalPosterior(pairs, refined.map_from_base, prior, {}).costs_of_both(steps, costs);
    };
    EXPECT_EQ(allocations_of(refine_once), 0U) << beams << " beams";
  }
}

TEST(Allocations, NoneOfAMatchOfOlsonButAtFirst) {
  const MatchScene scene = make_match_scene(make_rooms_world(1), LaserOptions{}, 30.0, 1);
  const OlsonMatcher matcher;
  const MatchProblem problem =
      scene.problem(shifted(scene.map_from_base, {0.04, -0.03, 0.02}), prior_of(0.05, 0.03), 1);
  EXPECT_EQ(allocations_of([&] { EXPECT_TRUE(matcher.match(problem).accepted()); }), 0U);
}

TEST(Allocations, NoneToFindAContradiction) {
  const MatchScene scene = make_match_scene(make_rooms_world(1), LaserOptions{}, 30.0, 1);
  EXPECT_EQ(allocations_of([&] {
              return free_space_violation(scene.scan, scene.map_from_base, scene.map.field);
            }),
            0U);
}

TEST(Allocations, NoneOfAScanInAMapThatStays) {
  EngineOptions options;
  SlamEngine engine(options, std::make_shared<OlsonMatcher>(), 1);
  ScanInput input;
  input.scan = scan_in(make_rooms_world(1), LaserOptions{});
  input.base_from_laser = LaserOptions{}.base_from_laser();
  ASSERT_TRUE(engine.process(input).inserted);
  options.slam.update_map = false;
  engine.set_options(options);
  const auto process_next = [&] {
    input.scan.stamp += 0.1;
    EXPECT_TRUE(engine.process(input).match.accepted());
  };
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(allocations_of(process_next), 0U);
  }
}

}  // namespace
}  // namespace matchbox_slam
