#include <benchmark/benchmark.h>

#include "benchmark_scene.hpp"
#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"

namespace matchbox_slam {
namespace {

/// Matches one scan from a prediction that is 5 cm and 2 degrees off, with another seed each time:
/// what a match costs may hang on luck.
void match_repeatedly(const ScanMatcher& matcher, int beams, benchmark::State& state) {
  const MatchScene& scene = benchmark_scene(beams);
  const Pose2 predicted = shifted(scene.map_from_base, {0.04, -0.03, degrees_to_radians(2.0)});
  std::uint64_t seed = 0;
  for (auto _ : state) {
    const MatchResult result =
        matcher.match(scene.problem(predicted, prior_of(0.05, 0.03), ++seed));
    if (!result.accepted()) {
      state.SkipWithError("a match was rejected");
      break;
    }
  }
}

/// A matcher with its defaults, by the number of beams.
template <typename Matcher>
void match(benchmark::State& state) {
  match_repeatedly(Matcher{}, static_cast<int>(state.range(0)), state);
}

/// One line a matcher.
#define MATCHBOX_BENCHMARK_MATCHER(Matcher) \
  BENCHMARK_TEMPLATE(match, Matcher)        \
      ->ArgName("beams")                    \
      ->Arg(kFewestBeams)                   \
      ->Arg(kCommonBeams)                   \
      ->Arg(kMostBeams)                     \
      ->Unit(benchmark::kMicrosecond)

MATCHBOX_BENCHMARK_MATCHER(HoughMatcher);
MATCHBOX_BENCHMARK_MATCHER(MonteCarloMatcher);
MATCHBOX_BENCHMARK_MATCHER(OdometryOnlyMatcher);
MATCHBOX_BENCHMARK_MATCHER(OlsonMatcher);

/// By the number of poses that are drawn.
void match_monte_carlo_tries(benchmark::State& state) {
  MonteCarloOptions options;
  options.max_tries = static_cast<int>(state.range(0));
  options.enough_score = 1.0;  // all of them are spent
  match_repeatedly(MonteCarloMatcher(options), kCommonBeams, state);
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(match_monte_carlo_tries)
    ->ArgName("tries")
    ->Arg(100)
    ->Arg(1000)
    ->Arg(10000)
    ->Unit(benchmark::kMicrosecond);

/// By the columns of the Hough domain, and by their cells: the paper's O(n + n_rho n_theta).
void match_hough_cells(benchmark::State& state) {
  HoughOptions options;
  options.alignment.angles = static_cast<int>(state.range(0));
  options.alignment.rho_cell = 1e-3 * static_cast<double>(state.range(1));
  match_repeatedly(HoughMatcher(options), kCommonBeams, state);
}
BENCHMARK(match_hough_cells)
    ->ArgNames({"angles", "rho_mm"})
    ->ArgsProduct({{90, 180, 360, 720}, {30}})
    ->ArgsProduct({{180}, {10, 60}})
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace matchbox_slam
