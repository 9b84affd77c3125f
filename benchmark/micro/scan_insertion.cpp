#include <benchmark/benchmark.h>

#include "benchmark_scene.hpp"

namespace matchbox_slam {
namespace {

/// A scan into a map of its surroundings, the likelihood field included.
void scan_insertion(benchmark::State& state) {
  const int beams = static_cast<int>(state.range(0));
  const MatchScene& scene = benchmark_scene(beams);
  SlamMap map = scene.map;
  for (auto _ : state) {
    insert_scan(scene.scan, scene.map_from_base, {}, map);
  }
  state.SetItemsProcessed(state.iterations() * beams);
}
BENCHMARK(scan_insertion)->ArgName("beams")->Arg(kFewestBeams)->Arg(kCommonBeams)->Arg(kMostBeams);

/// The same scan into maps of so many scans along the route: what it costs must not grow with them.
void scan_insertion_into_map(benchmark::State& state) {
  const int scans = static_cast<int>(state.range(0));
  constexpr double kSecondsPerScan = 0.6;  // a key scan every 0.3 m
  SlamMap map{MapOptions{}, LikelihoodFieldOptions{}};
  for (const LocatedPoints& key : scans_along_route(kCommonBeams, kSecondsPerScan * scans, scans)) {
    insert_scan(key.scan, key.map_from_base, {}, map);
  }
  const MatchScene& scene = benchmark_scene(kCommonBeams);
  for (auto _ : state) {
    insert_scan(scene.scan, scene.map_from_base, {}, map);
  }
  state.SetItemsProcessed(state.iterations() * kCommonBeams);
}
BENCHMARK(scan_insertion_into_map)->ArgName("scans")->Arg(1)->Arg(30)->Arg(300);

}  // namespace
}  // namespace matchbox_slam
