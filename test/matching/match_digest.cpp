// Prints the answers of the matchers to fixed problems to the last bit. Built once for each
// instruction set; see test_simd_paths.cpp.

#include <cstdio>
#include <memory>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matchbox_slam/matching/monte_carlo/monte_carlo_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"

namespace {

using namespace matchbox_slam;

/// A room with chaos in it, mapped with noise, and a scan of it.
struct Scene {
  LikelihoodField field{0.05, {}};
  PointScan scan;
  PlacedScans key_scans;
};

void add_wall(const Eigen::Vector2d& start, const Eigen::Vector2d& step, Random& random,
              std::vector<SurfaceHit>& hits, PointScan& scan) {
  const Eigen::Vector2d normal = Eigen::Vector2d(-step.y(), step.x()).normalized();
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d at = start + i * step;
    hits.push_back({at + 0.01 * random.gaussian() * normal, normal});
    scan.points.push_back({at + 0.01 * random.gaussian() * normal,
                           {0.0, 0.0},
                           normal,
                           step.norm() * random.uniform(0.5, 1.5),
                           i < 99});
  }
}

Scene make_scene(std::uint64_t seed) {
  Random random(seed);
  Scene scene;
  std::vector<SurfaceHit> hits;
  for (int wall = 0; wall < 9; ++wall) {
    const Eigen::Vector2d start(random.uniform(-5.0, 5.0), random.uniform(-5.0, 5.0));
    const Eigen::Vector2d step(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05));
    add_wall(start, step, random, hits, scene.scan);
  }
  scene.field.update(hits, {});
  PointScan key;
  for (const SurfaceHit& hit : hits) {
    key.points.push_back({hit.position, {0.0, 0.0}, hit.normal, 0.03, false});
  }
  scene.key_scans.push_back({std::make_shared<const KeyScan>(key), Pose2{}});
  return scene;
}

void print(const MatchResult& result) {
  const Pose2& pose = result.map_from_base;
  std::printf("%d %a %a %a %a %zu", static_cast<int>(result.status), pose.x, pose.y, pose.theta,
              result.score, result.candidates);
  for (Eigen::Index i = 0; i < 9; ++i) {
    std::printf(" %a", result.covariance(i));
  }
  std::printf("\n");
}

}  // namespace

int main() {
  const HoughMatcher hough;
  const MonteCarloMatcher monte_carlo;
  const OlsonMatcher olson;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Scene scene = make_scene(seed);
    const Eigen::Matrix3d prior = Eigen::Vector3d(0.02, 0.02, 0.01).asDiagonal();
    const MatchProblem problem{scene.scan,  {0.1, -0.07, 0.06}, prior,
                               scene.field, scene.key_scans,    seed};
    print(hough.match(problem));
    print(monte_carlo.match(problem));
    print(olson.match(problem));
  }
}
