#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/pose_prior.hpp"
#include "matching/olson/correlative_search.hpp"

namespace matchbox_slam {
namespace {

struct Scene {
  LikelihoodField field{0.05, {}};
  std::vector<SearchPoint> points;
  SearchLattice lattice;
  SearchScoring scoring;
};

/// Of any rank, so that some directions may cost nothing.
Eigen::Matrix3d random_penalty(Random& random) {
  const int rank = 1 + static_cast<int>(random.uniform() * 3.0);
  Eigen::Matrix3d root = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3 * rank; ++i) {
    root(i % 3, i / 3) = random.uniform(-1.0, 1.0);
  }
  const double strength = random.uniform() < 0.3 ? 0.0 : std::exp(random.uniform(0.0, 14.0));
  return strength * (root * root.transpose());
}

std::array<std::uint8_t, 256> random_values(Random& random) {
  std::array<std::uint8_t, 256> values{};
  const double power = random.uniform(0.3, 3.0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<std::uint8_t>(
        std::lround(255.0 * std::pow(static_cast<double>(i) / 255.0, power)));
  }
  return values;
}

/// Walls and chaos, a map that grew in several updates and lost some cells again, and a scan that
/// saw some of it.
Scene make_scene(std::uint64_t seed) {
  Random random(seed);
  Scene scene;
  const double size = random.uniform(0.3, 4.0);
  std::vector<Eigen::Vector2d> seen;
  for (int update = 0; update < 3; ++update) {
    std::vector<SurfaceHit> hits;
    std::vector<Cell> cleared;
    const Eigen::Vector2d start(random.uniform(-size, size), random.uniform(-size, size));
    const Eigen::Vector2d step(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05));
    const bool is_wall = random.uniform() < 0.6;
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector2d hit =
          is_wall ? Eigen::Vector2d(start + i * step)
                  : Eigen::Vector2d(random.uniform(-size, size), random.uniform(-size, size));
      hits.push_back({hit, Eigen::Vector2d::Zero()});
      seen.push_back(hit);
    }
    for (const Cell& cell : scene.field.surface_cells()) {
      if (random.uniform() < 0.2) {
        cleared.push_back(cell);
      }
    }
    scene.field.update(hits, cleared);
  }
  const Pose2 truth{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                    random.uniform(-kPi, kPi)};
  const int count = 1 + static_cast<int>(random.uniform(0.0, 80.0));
  for (int i = 0; i < count; ++i) {
    Eigen::Vector2d point =
        truth.inverse() * seen[static_cast<std::size_t>(random.uniform() * 180.0)];
    if (random.uniform() < 0.1) {
      point *= random.uniform(1.0, 30.0);  // far outside the map
    }
    scene.points.push_back({point, 1 + static_cast<int>(random.uniform() * kMaxSearchWeight)});
  }
  SearchLattice& lattice = scene.lattice;
  lattice.center = {truth.x + random.uniform(-0.3, 0.3), truth.y + random.uniform(-0.3, 0.3),
                    wrap_angle(truth.theta + random.uniform(-0.2, 0.2))};
  lattice.steps_per_cell = 1 + static_cast<int>(random.uniform() * 6.0);
  lattice.half_xy = static_cast<int>(random.uniform() * 25.0);
  lattice.half_theta = static_cast<int>(random.uniform() * 8.0);
  lattice.step_theta = random.uniform(0.002, 0.1);
  // From where all poses are within the prior's word to where hardly any is.
  scene.scoring.prior_weight = std::exp(random.uniform(-2.0, 10.0));
  scene.scoring.prior_information = random_penalty(random) / scene.scoring.prior_weight;
  scene.scoring.value_of_likelihood = random_values(random);
  return scene;
}

std::int64_t floor_div(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(std::floor(static_cast<double>(a) / static_cast<double>(b)));
}

struct Found {
  LatticePose pose;
  std::int64_t score = 0;
  bool is_set = false;
};

std::int64_t score_of(const Scene& scene, const LatticePose& pose) {
  const double resolution = scene.field.geometry().resolution();
  const double angle = scene.lattice.center.theta + scene.lattice.step_theta * pose.theta;
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const int n = scene.lattice.steps_per_cell;
  const double steps_per_metre = n / resolution;
  std::int64_t fit = 0;
  for (const SearchPoint& point : scene.points) {
    const double qx = (c * point.position.x() - s * point.position.y()) + scene.lattice.center.x;
    const double qy = (s * point.position.x() + c * point.position.y()) + scene.lattice.center.y;
    const auto ux = static_cast<std::int64_t>(std::floor(qx * steps_per_metre));
    const auto uy = static_cast<std::int64_t>(std::floor(qy * steps_per_metre));
    const Cell cell{static_cast<int>(floor_div(ux + pose.x, n)),
                    static_cast<int>(floor_div(uy + pose.y, n))};
    const std::int64_t value = scene.scoring.value_of_likelihood[scene.field.likelihood(cell)];
    fit += point.weight * value;
  }
  const double step = resolution / n;
  const Eigen::Vector3d d(step * pose.x, step * pose.y, scene.lattice.step_theta * pose.theta);
  const double penalty =
      scene.scoring.prior_weight * prior_penalty(d.dot(scene.scoring.prior_information * d));
  return fit - (penalty < static_cast<double>(kMaxPenalty) ? std::llround(penalty) : kMaxPenalty);
}

/// Tries every pose, but for those that are within some steps of one.
Found search_all(const Scene& scene, const LatticePose& not_near = {}, int not_within_xy = -1,
                 int not_within_theta = -1) {
  Found best;
  const auto is_near = [&](const LatticePose& p) {
    return std::abs(p.x - not_near.x) <= not_within_xy &&
           std::abs(p.y - not_near.y) <= not_within_xy &&
           std::abs(p.theta - not_near.theta) <= not_within_theta;
  };
  const auto order = [](const LatticePose& p) {
    return std::make_tuple(std::abs(p.theta), std::abs(p.x) + std::abs(p.y), p.theta, p.y, p.x);
  };
  const SearchLattice& lattice = scene.lattice;
  for (int theta = -lattice.half_theta; theta <= lattice.half_theta; ++theta) {
    for (int y = -lattice.half_xy; y <= lattice.half_xy; ++y) {
      for (int x = -lattice.half_xy; x <= lattice.half_xy; ++x) {
        const LatticePose pose{x, y, theta};
        if (is_near(pose)) {
          continue;
        }
        const std::int64_t score = score_of(scene, pose);
        if (!best.is_set || score > best.score ||
            (score == best.score && order(pose) < order(best.pose))) {
          best = {pose, score, true};
        }
      }
    }
  }
  return best;
}

void expect_the_optimum(const Scene& scene) {
  const Found best = search_all(scene);
  const SearchResult found =
      search_lattice(scene.points, scene.field, scene.lattice, scene.scoring);
  EXPECT_EQ(found.score, best.score);
  EXPECT_EQ(found.bound, found.score);
  EXPECT_EQ(found.best.x, best.pose.x);
  EXPECT_EQ(found.best.y, best.pose.y);
  EXPECT_EQ(found.best.theta, best.pose.theta);
}

class RandomScenes : public testing::TestWithParam<int> {};

TEST_P(RandomScenes, HaveTheOptimumOfBruteForce) {
  for (int i = 0; i < 120; ++i) {
    const int seed = 120 * GetParam() + i;
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_the_optimum(make_scene(static_cast<std::uint64_t>(seed)));
    if (HasFailure()) {
      return;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomScenes, testing::Range(0, 10));

TEST(CorrelativeSearch, FindsTheOptimumOfWideWindowsOnEveryLevel) {
  // 7 blocks of 4 cells, 38 of 16: the second and the third level.
  for (const int half_xy : {12, 300}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      Scene scene = make_scene(seed);
      scene.lattice.steps_per_cell = 1;
      scene.lattice.half_xy = half_xy;
      scene.lattice.half_theta = 1;
      scene.points.resize(std::min<std::size_t>(scene.points.size(), 10));
      SCOPED_TRACE("half_xy " + std::to_string(half_xy) + ", seed " + std::to_string(seed));
      expect_the_optimum(scene);
    }
  }
}

/// The scan in the order of its beams and the rotation in fine steps, so that neighbours and turns
/// are taken together; walls that are many cells away; cells of 1 to 30 cm and up to 16 steps in
/// one.
Scene scene_of_beams(std::uint64_t seed) {
  Random random(seed);
  Scene scene;
  const double resolution = random.uniform(0.01, 0.3);
  scene.field = LikelihoodField(resolution, {});
  const Pose2 truth{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                    random.uniform(-kPi, kPi)};
  const double size = resolution * random.uniform(20.0, 60.0);
  std::vector<SurfaceHit> hits;
  constexpr int kBeams = 60;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = random.uniform(-0.001, 0.001) + 2.0 * kPi * i / kBeams;
    const double range = size * (1.0 + 0.4 * std::sin(2.0 * angle) + 0.1 * std::cos(5.0 * angle));
    const Eigen::Vector2d point = range * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    hits.push_back({truth * point, Eigen::Vector2d::Zero()});
    scene.points.push_back({point, 1 + static_cast<int>(random.uniform() * kMaxSearchWeight)});
  }
  scene.field.update(hits, {});
  SearchLattice& lattice = scene.lattice;
  lattice.center = {truth.x + resolution * random.uniform(-2.0, 2.0),
                    truth.y + resolution * random.uniform(-2.0, 2.0),
                    wrap_angle(truth.theta + random.uniform(-0.1, 0.1))};
  lattice.steps_per_cell = 1 + static_cast<int>(random.uniform() * 16.0);
  lattice.half_xy = static_cast<int>(random.uniform() * 20.0);
  lattice.step_theta = resolution / lattice.steps_per_cell / size;
  lattice.half_theta = 1 + static_cast<int>(random.uniform() * 20.0);
  scene.scoring.prior_weight = std::exp(random.uniform(-2.0, 10.0));
  scene.scoring.prior_information = random_penalty(random) / scene.scoring.prior_weight;
  scene.scoring.value_of_likelihood = random_values(random);
  if (seed % 2 == 0) {  // sharp, so that no bound may miss a cell
    for (std::size_t i = 0; i < 256; ++i) {
      scene.scoring.value_of_likelihood[i] = i < 250 ? 0 : 255;
    }
    scene.points.resize(4 + seed % 16);
  }
  return scene;
}

TEST(CorrelativeSearch, FindsTheOptimumAmongNeighboursAndTurns) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_the_optimum(scene_of_beams(seed));
  }
}

TEST(CorrelativeSearch, FindsTheOptimumOfEveryHeading) {
  for (std::uint64_t seed = 100; seed < 104; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene = scene_of_beams(seed);
    scene.lattice.steps_per_cell = 1;
    scene.lattice.half_xy = seed % 2 == 0 ? 5 : 25;  // in blocks of one cell, and of four
    scene.lattice.step_theta = 0.02 * (1 + static_cast<double>(seed % 2));
    scene.lattice.half_theta = static_cast<int>(kPi / scene.lattice.step_theta);
    scene.lattice.center.theta += 3.0;
    if (seed % 2 == 1) {
      scene.points.resize(20);
    }
    expect_the_optimum(scene);
  }
}

TEST(CorrelativeSearch, FindsTheRivalOfBruteForce) {
  int found_some = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = seed % 4 == 0 ? scene_of_beams(seed) : make_scene(seed);
    const RivalSearch rivals{static_cast<int>(seed % 7), static_cast<int>(seed % 3),
                             0.25 * static_cast<double>(seed % 4)};
    const SearchResult found =
        search_lattice(scene.points, scene.field, scene.lattice, scene.scoring, rivals);
    const Found rival = search_all(scene, found.best, rivals.xy, rivals.theta);
    const auto least = static_cast<std::int64_t>(rivals.least * static_cast<double>(found.score));
    ASSERT_EQ(found.rival.has_value(), found.score > 0 && rival.is_set && rival.score > least);
    if (found.rival) {
      ++found_some;
      EXPECT_EQ(found.rival->score, rival.score);
      EXPECT_EQ(score_of(scene, found.rival->pose), rival.score);
    }
  }
  EXPECT_GT(found_some, 50);
}

/// For so few open blocks that a search goes deep at once, and for no sums that are kept.
SearchMemory little_memory() {
  SearchLimits limits;
  limits.open = 3;
  limits.sums = 0;
  return SearchMemory(limits);
}

TEST(CorrelativeSearch, FindsTheSameInMemoryOfOthersAndInLittle) {
  SearchMemory used;
  SearchMemory little = little_memory();
  int with_rival = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene = seed % 4 == 0 ? scene_of_beams(seed) : make_scene(seed);
    scene.lattice.half_xy *= seed % 3 == 0 ? 10 : 1;
    const RivalSearch rivals{static_cast<int>(seed % 7), static_cast<int>(seed % 3),
                             0.25 * static_cast<double>(seed % 4)};
    const SearchResult alone =
        search_lattice(scene.points, scene.field, scene.lattice, scene.scoring, rivals);
    with_rival += alone.rival ? 1 : 0;
    for (SearchMemory* memory : {&used, &little}) {
      const SearchResult found = search_lattice(scene.points, scene.field, scene.lattice,
                                                scene.scoring, rivals, {}, *memory);
      EXPECT_EQ(found.is_found, alone.is_found);
      EXPECT_EQ(found.score, alone.score);
      EXPECT_EQ(found.bound, alone.bound);
      EXPECT_EQ(std::tie(found.best.x, found.best.y, found.best.theta),
                std::tie(alone.best.x, alone.best.y, alone.best.theta));
      ASSERT_EQ(found.rival.has_value(), alone.rival.has_value());
      if (found.rival) {
        const LatticePose& rival = alone.rival->pose;
        EXPECT_EQ(found.rival->score, alone.rival->score);
        EXPECT_EQ(std::tie(found.rival->pose.x, found.rival->pose.y, found.rival->pose.theta),
                  std::tie(rival.x, rival.y, rival.theta));
      }
      if (memory == &used) {
        EXPECT_EQ(found.candidates, alone.candidates);
        EXPECT_EQ(found.bounded, alone.bounded);
      }
    }
  }
  EXPECT_GT(with_rival, 50);
}

TEST(CorrelativeSearch, FindsWhatIsAboveTheFloorAndNothingElse) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene = make_scene(seed);
    const SearchResult any =
        search_lattice(scene.points, scene.field, scene.lattice, scene.scoring);
    ASSERT_TRUE(any.is_found);
    scene.scoring.floor = any.score - 1;
    const SearchResult same =
        search_lattice(scene.points, scene.field, scene.lattice, scene.scoring);
    EXPECT_TRUE(same.is_found);
    EXPECT_EQ(same.score, any.score);
    EXPECT_EQ(std::tie(same.best.x, same.best.y, same.best.theta),
              std::tie(any.best.x, any.best.y, any.best.theta));
    EXPECT_LE(same.candidates, any.candidates);
    scene.scoring.floor = any.score;
    const SearchResult none =
        search_lattice(scene.points, scene.field, scene.lattice, scene.scoring, RivalSearch{});
    EXPECT_FALSE(none.is_found);
    EXPECT_GE(none.bound, any.score);
    EXPECT_FALSE(none.rival);
  }
}

TEST(CorrelativeSearch, SeesNothingWhereStepsCannotBeCounted) {
  Scene scene = make_scene(3);
  for (const double far : {4e6, 1e8, 1e12}) {
    scene.lattice.center = {far, -far, 1.0};
    const SearchResult found =
        search_lattice(scene.points, scene.field, scene.lattice, scene.scoring);
    EXPECT_EQ(found.score, 0);
    EXPECT_EQ(found.best.theta, 0);
  }
}

TEST(CorrelativeSearch, LooksAtFarFewerPosesThanThereAre) {
  Scene scene = make_scene(8);
  scene.lattice.steps_per_cell = 5;
  scene.lattice.half_xy = 100;
  scene.lattice.half_theta = 100;
  scene.lattice.step_theta = 0.005;
  const SearchResult found =
      search_lattice(scene.points, scene.field, scene.lattice, scene.scoring);
  EXPECT_LT(found.candidates, 201U * 201U * 201U / 50U);
}

TEST(CorrelativeSearch, StaysAtTheCenterWhereThereIsNothing) {
  Scene scene = make_scene(3);
  scene.lattice.center = {1e4, -1e4, 1.0};
  const SearchResult found =
      search_lattice(scene.points, scene.field, scene.lattice, scene.scoring);
  EXPECT_EQ(found.score, 0);
  EXPECT_EQ(found.best.x, 0);
  EXPECT_EQ(found.best.y, 0);
  EXPECT_EQ(found.best.theta, 0);
}

TEST(CorrelativeSearch, TellsWhatIsLeftWhenItIsLate) {
  for (std::uint64_t seed = 10; seed < 30; ++seed) {
    Scene scene = make_scene(seed);
    scene.lattice.half_xy = 20;
    scene.lattice.half_theta = 5;
    const SearchDeadline passed{std::chrono::steady_clock::now()};
    const SearchResult late =
        search_lattice(scene.points, scene.field, scene.lattice, scene.scoring, {}, passed);
    const std::int64_t best = search_all(scene).score;
    EXPECT_LE(late.score, best);
    EXPECT_GE(late.bound, best);
    EXPECT_GT(late.bound, late.score);
    EXPECT_EQ(late.score, score_of(scene, late.best));
    SearchLimits limits;
    limits.open = 2;
    SearchMemory little(limits);
    const SearchResult less =
        search_lattice(scene.points, scene.field, scene.lattice, scene.scoring, {}, passed, little);
    EXPECT_GE(less.bound, best);
  }
}

TEST(CorrelativeSearch, EndsAfterSoManyLookUpsAndTellsWhatIsLeft) {
  for (std::uint64_t seed = 10; seed < 30; ++seed) {
    Scene scene = make_scene(seed);
    scene.lattice.half_xy = 20;
    scene.lattice.half_theta = 5;
    const auto search = [&](std::size_t look_ups) {
      return search_lattice(scene.points, scene.field, scene.lattice, scene.scoring,
                            RivalSearch{3, 1, 0.5}, SearchDeadline{{}, look_ups});
    };
    const SearchResult whole = search(std::numeric_limits<std::size_t>::max());
    EXPECT_EQ(whole.bound, whole.score);
    EXPECT_EQ(whole.rivals_left, 0);
    EXPECT_EQ(search(whole.look_ups).score, whole.score) << "as many as it takes";
    const SearchResult late = search(1);
    EXPECT_LT(late.look_ups, whole.look_ups);
    EXPECT_LE(late.score, whole.score);
    EXPECT_GE(late.bound, whole.score);
    EXPECT_EQ(late.score, score_of(scene, late.best));
    const SearchResult without_rivals =
        search_lattice(scene.points, scene.field, scene.lattice, scene.scoring);
    const SearchResult no_time_for_rivals = search(without_rivals.look_ups);
    EXPECT_EQ(no_time_for_rivals.score, whole.score);
    if (whole.rival && !no_time_for_rivals.rival) {
      EXPECT_GE(no_time_for_rivals.rivals_left, whole.rival->score);
    }
  }
}

TEST(CorrelativeSearch, TellsWhatIsLeftInLittleMemory) {
  SearchMemory little = little_memory();
  int without_time_for_rivals = 0;
  for (std::uint64_t seed = 10; seed < 60; ++seed) {
    Scene scene = make_scene(seed);
    scene.lattice.half_xy = 20;
    scene.lattice.half_theta = 5;
    const auto search = [&](std::size_t look_ups) {
      return search_lattice(scene.points, scene.field, scene.lattice, scene.scoring,
                            RivalSearch{3, 1, 0.5}, SearchDeadline{{}, look_ups}, little);
    };
    const SearchResult whole = search(std::numeric_limits<std::size_t>::max());
    EXPECT_EQ(whole.bound, whole.score);
    EXPECT_EQ(whole.rivals_left, 0);
    for (std::size_t part = 1; part < 20; ++part) {
      const SearchResult late = search(whole.look_ups * part / 20);
      EXPECT_GE(late.bound, whole.score);
      EXPECT_EQ(late.score, score_of(scene, late.best));
      if (late.bound == late.score && whole.rival) {
        EXPECT_EQ(late.score, whole.score);
        without_time_for_rivals += late.rivals_left > 0 ? 1 : 0;
        EXPECT_GE(std::max(late.rivals_left, late.rival ? late.rival->score : 0),
                  whole.rival->score);
      }
    }
  }
  EXPECT_GT(without_time_for_rivals, 20);
}

}  // namespace
}  // namespace matchbox_slam
