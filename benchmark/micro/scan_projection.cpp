#include <benchmark/benchmark.h>

#include "benchmark_scene.hpp"

namespace matchbox_slam {
namespace {

/// Ranges to points in the base frame, each with its surface normal.
void scan_projection(benchmark::State& state) {
  const int beams = static_cast<int>(state.range(0));
  const LaserScan scan = benchmark_scan(beams);
  const Eigen::Isometry3d base_from_laser = laser_of(beams).base_from_laser();
  for (auto _ : state) {
    benchmark::DoNotOptimize(project_scan(scan, base_from_laser, {}, {}));
  }
  state.SetItemsProcessed(state.iterations() * beams);
}
BENCHMARK(scan_projection)->ArgName("beams")->Arg(kFewestBeams)->Arg(kCommonBeams)->Arg(kMostBeams);

}  // namespace
}  // namespace matchbox_slam
