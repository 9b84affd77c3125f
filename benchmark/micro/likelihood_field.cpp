#include <benchmark/benchmark.h>

#include "benchmark_scene.hpp"

namespace matchbox_slam {
namespace {

std::vector<SurfaceHit> hits_of(const MatchScene& scene) {
  std::vector<SurfaceHit> hits;
  for (const ScanPoint& point : scene.scan.points) {
    const Pose2 rotation{0.0, 0.0, scene.map_from_base.theta};
    hits.push_back({scene.map_from_base * point.position, rotation * point.normal});
  }
  return hits;
}

/// A scan's hits into an empty field: every block is rendered.
void field_update(benchmark::State& state) {
  const MatchScene& scene = benchmark_scene(static_cast<int>(state.range(0)));
  const std::vector<SurfaceHit> hits = hits_of(scene);
  for (auto _ : state) {
    LikelihoodField field(MapOptions{}.resolution, {});
    field.update(hits, {});
    benchmark::DoNotOptimize(field.empty());
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(field_update)->ArgName("beams")->Arg(kFewestBeams)->Arg(kCommonBeams)->Arg(kMostBeams);

/// A scan's points, looked up at one pose.
void field_look_up(benchmark::State& state) {
  const MatchScene& scene = benchmark_scene(static_cast<int>(state.range(0)));
  const LikelihoodField& field = scene.map.field;
  const std::vector<SurfaceHit> hits = hits_of(scene);
  for (auto _ : state) {
    int sum = 0;
    for (const SurfaceHit& hit : hits) {
      sum += field.likelihood(field.geometry().cell_at(hit.position));
    }
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(hits.size()));
}
BENCHMARK(field_look_up)->ArgName("beams")->Arg(kFewestBeams)->Arg(kCommonBeams)->Arg(kMostBeams);

}  // namespace
}  // namespace matchbox_slam
