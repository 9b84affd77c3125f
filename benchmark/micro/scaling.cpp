// What each part of a scan's way costs by the number of beams, by the width of the search, by the
// size of the map and by the size of its cells, one at a time; see run_scaling.py.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "benchmark_scene.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "simulation/robot.hpp"

namespace matchbox_slam {
namespace {

constexpr int kCommonCell = 5;  // [cm]

MapOptions map_of(int cell) {
  MapOptions options;
  options.resolution = 0.01 * cell;
  return options;
}

/// A drive of 4 s through the office, mapped with cells of another size.
SlamMap map_around(int cell) {
  SlamMap map(map_of(cell), LikelihoodFieldOptions{});
  const RobotMotion motion = drive(benchmark_world().route(), {});
  for (int i = 0; i < 8; ++i) {
    const Pose2 pose = motion.pose(28.0 + 0.5 * i + (i < 4 ? 0.0 : 0.5));
    const std::uint64_t seed = mix_seed(2, static_cast<std::uint64_t>(i));
    insert_scan(look_around(benchmark_world(), laser_of(kCommonBeams), pose, seed), pose,
                map_of(cell), map);
  }
  return map;
}

/// The office's map again and again along a line of so many metres.
SlamMap map_as_long_as(int metres) {
  constexpr int kApart = 15;  // [m]
  const MatchScene& scene = benchmark_scene(kCommonBeams);
  SlamMap map = scene.map;
  for (int x = kApart; x < metres; x += kApart) {
    for (const PlacedScan& key : scene.key_scans) {
      insert_scan(*key.scan->points(),
                  shifted(key.map_from_base, {static_cast<double>(x), 0.0, 0.0}), {}, map);
    }
  }
  return map;
}

void match_in(const SlamMap& map, int beams, double half_window, benchmark::State& state) {
  const MatchScene& scene = benchmark_scene(beams);
  OlsonOptions options;
  options.window_xy = half_window;
  options.max_window_xy = std::max(options.max_window_xy, half_window);
  const OlsonMatcher matcher(options);
  const Pose2 predicted = shifted(scene.map_from_base, {0.04, -0.03, degrees_to_radians(2.0)});
  const double sigma = half_window > 0.0 ? half_window / 3.0 : 0.05;
  const MatchProblem problem{scene.scan, predicted,       prior_of(sigma, 0.03),
                             map.field,  scene.key_scans, 1};
  for (auto _ : state) {
    if (!matcher.match(problem).accepted()) {
      state.SkipWithError("a match was rejected");
      break;
    }
  }
}

void insert_into(SlamMap map, int beams, int cell, benchmark::State& state) {
  const MatchScene& scene = benchmark_scene(beams);
  for (auto _ : state) {
    insert_scan(scene.scan, scene.map_from_base, map_of(cell), map);
  }
}

void scaling_beams_project(benchmark::State& state) {
  const auto beams = static_cast<int>(state.range(0));
  const LaserScan scan = benchmark_scan(beams);
  const Eigen::Isometry3d base_from_laser = laser_of(beams).base_from_laser();
  ScanProjector projector;
  PointScan points;
  for (auto _ : state) {
    projector.project(scan, base_from_laser, {}, {}, Eigen::Isometry3d::Identity(), points);
  }
}

void scaling_beams_match(benchmark::State& state) {
  const auto beams = static_cast<int>(state.range(0));
  match_in(benchmark_scene(beams).map, beams, 0.0, state);
}

void scaling_beams_insert(benchmark::State& state) {
  const auto beams = static_cast<int>(state.range(0));
  insert_into(benchmark_scene(beams).map, beams, kCommonCell, state);
}

/// @param range  half the window [cm].
void scaling_window_match(benchmark::State& state) {
  match_in(benchmark_scene(kCommonBeams).map, kCommonBeams,
           0.01 * static_cast<double>(state.range(0)), state);
}

/// @param range  length [m].
void scaling_map_match(benchmark::State& state) {
  match_in(map_as_long_as(static_cast<int>(state.range(0))), kCommonBeams, 0.0, state);
}

void scaling_map_insert(benchmark::State& state) {
  insert_into(map_as_long_as(static_cast<int>(state.range(0))), kCommonBeams, kCommonCell, state);
}

/// @param range  edge of a cell [cm].
void scaling_cells_match(benchmark::State& state) {
  match_in(map_around(static_cast<int>(state.range(0))), kCommonBeams, 0.0, state);
}

void scaling_cells_insert(benchmark::State& state) {
  const auto cell = static_cast<int>(state.range(0));
  insert_into(map_around(cell), kCommonBeams, cell, state);
}

const std::vector<std::int64_t> kBeams{kFewestBeams, 300, kCommonBeams, 3000, kMostBeams};
const std::vector<std::int64_t> kMetres{10, 30, 100, 300, 1000};
const std::vector<std::int64_t> kCells{1, 2, 3, 5, 10};

#define MATCHBOX_SCALING(function, name, values) \
  BENCHMARK(function)->ArgName(name)->ArgsProduct({values})->Unit(benchmark::kMicrosecond)

MATCHBOX_SCALING(scaling_beams_project, "beams", kBeams);
MATCHBOX_SCALING(scaling_beams_match, "beams", kBeams);
MATCHBOX_SCALING(scaling_beams_insert, "beams", kBeams);
MATCHBOX_SCALING(scaling_window_match, "cm",
                 (std::vector<std::int64_t>{20, 50, 100, 200, 500, 1000}));
MATCHBOX_SCALING(scaling_map_match, "m", kMetres);
MATCHBOX_SCALING(scaling_map_insert, "m", kMetres);
MATCHBOX_SCALING(scaling_cells_match, "cm", kCells);
MATCHBOX_SCALING(scaling_cells_insert, "cm", kCells);

}  // namespace
}  // namespace matchbox_slam
