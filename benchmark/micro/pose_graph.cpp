#include <benchmark/benchmark.h>

#include <vector>

#include "graph/random_graphs.hpp"
#include "matchbox_slam/graph/optimise.hpp"

namespace matchbox_slam {
namespace {

/// Laps of 1000 nodes, with as many loops to the lap before, all alike.
/// @param drift  share of the variances that is assumed, of which there is hardly any.
PoseGraph laps(std::int64_t nodes, std::int64_t loops, double drift = 0.0) {
  Random random(1);
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1e-4, 1e-4, 4e-6).asDiagonal();
  const Pose2 step{0.3, 0.0, 2.0 * kPi / 1000.0};
  PoseGraph graph;
  graph.poses.push_back({});
  for (std::size_t i = 1; i < static_cast<std::size_t>(nodes); ++i) {
    graph.edges.push_back({i - 1, i, noisy(step, (1.0 - drift) * covariance, random), covariance});
    graph.edges.back().drift = drift * covariance.diagonal();
    graph.poses.push_back(graph.poses.back() * graph.edges.back().from_to);
  }
  for (std::int64_t i = 1; i <= loops; ++i) {
    const auto to = static_cast<std::size_t>(1000 + i * (nodes - 1001) / loops);
    graph.edges.push_back({to - 1000, to, noisy({}, covariance, random), covariance,
                           EdgeKind::kLoop, LoopVerdict::kUndecided});
  }
  return graph;
}

/// All loops at once.
void decide_all(benchmark::State& state) {
  const PoseGraph graph = laps(state.range(0), state.range(1));
  for (auto _ : state) {
    benchmark::DoNotOptimize(optimise(graph));
  }
}
BENCHMARK(decide_all)->Args({2000, 40})->Unit(benchmark::kMillisecond);

/// The newest loop, the others being inliers.
void decide_one_more(benchmark::State& state, double drift) {
  PoseGraph graph = laps(state.range(0), state.range(1), drift);
  graph.edges.pop_back();
  graph = optimise(graph).graph;
  graph.edges.push_back(laps(state.range(0), state.range(1), drift).edges.back());
  for (auto _ : state) {
    benchmark::DoNotOptimize(optimise(graph));
  }
}
BENCHMARK_CAPTURE(decide_one_more, without_drift, 0.0)
    ->Args({2000, 40})
    ->Args({10000, 200})
    ->Args({33000, 600})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(decide_one_more, with_drift, 0.999)
    ->Args({2000, 40})
    ->Args({10000, 200})
    ->Args({33000, 600})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace matchbox_slam
