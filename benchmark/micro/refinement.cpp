#include "matchbox_slam/matching/refinement.hpp"

#include <benchmark/benchmark.h>

#include "benchmark_scene.hpp"

namespace matchbox_slam {
namespace {

/// From half a cell off, as a search leaves it.
void refinement(benchmark::State& state) {
  const MatchScene& scene = benchmark_scene(static_cast<int>(state.range(0)));
  const Pose2 start = shifted(scene.map_from_base, {0.02, -0.015, degrees_to_radians(0.5)});
  const PosePrior prior{start, prior_of(0.05, 0.03)};
  for (auto _ : state) {
    benchmark::DoNotOptimize(refine(scene.scan.points, scene.map.field, start, prior, {}));
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(refinement)->ArgName("beams")->Arg(kFewestBeams)->Arg(kCommonBeams)->Arg(kMostBeams);

}  // namespace
}  // namespace matchbox_slam
