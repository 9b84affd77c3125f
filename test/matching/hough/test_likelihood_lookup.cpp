#include <gtest/gtest.h>

#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/geometry/pose2.hpp"
#include "matching/hough/likelihood_lookup.hpp"

namespace matchbox_slam {
namespace {

LikelihoodField random_walls(Random& random) {
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  std::vector<SurfaceHit> hits;
  for (int i = 0; i < 5000; ++i) {
    // In two heaps, so that tiles between them are missing.
    const double side = i % 2 == 0 ? -12.0 : 9.0;
    hits.push_back({{side + random.uniform(-4.0, 4.0), random.uniform(-5.0, 5.0)}, {1.0, 0.0}});
  }
  field.update(hits, {});
  return field;
}

HoughPoints random_points(Random& random, int count) {
  HoughPoints points;
  for (int i = 0; i < count; ++i) {
    points.x.push_back(static_cast<float>(random.uniform(-15.0, 15.0)));
    points.y.push_back(static_cast<float>(random.uniform(-6.0, 6.0)));
    points.weight.push_back(static_cast<float>(random.uniform(0.01, 0.3)));
  }
  return points;
}

double mean_point_by_point(const HoughPoints& points, const LikelihoodField& field,
                           const Pose2& field_from_points) {
  double sum = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d point(static_cast<double>(points.x[i]), static_cast<double>(points.y[i]));
    const auto weight = static_cast<double>(points.weight[i]);
    const Cell cell = field.geometry().cell_at(field_from_points * point);
    sum += weight * field.likelihood(cell) / 255.0;
    total += weight;
  }
  return sum / total;
}

TEST(LikelihoodLookup, IsTheMeanPointByPointWhereverThePointsLie) {
  Random random(7);
  const LikelihoodField field = random_walls(random);
  LikelihoodLookup lookup(field);
  int likely = 0;
  for (int i = 0; i < 200; ++i) {
    const HoughPoints points = random_points(random, 1 + i % 67);
    // Some lie far outside of the field's tiles.
    const double reach = i % 10 == 0 ? 1e4 : (i % 2 == 0 ? 30.0 : 8.0);
    const double theta = random.uniform(-kPi, kPi);
    lookup.turn(points, theta);
    for (int k = 0; k < 5; ++k) {
      const Pose2 pose{random.uniform(-reach, reach), random.uniform(-reach, reach), theta};
      const double mean = mean_point_by_point(points, field, pose);
      // A point on the edge of a cell may be in the next one, by rounding.
      EXPECT_NEAR(lookup.mean_at(pose.translation()), mean, 1e-9);
      likely += mean > 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(likely, 500);
}

TEST(LikelihoodLookup, OfAnEmptyFieldOrOfNoPointsIsNothing) {
  const LikelihoodField empty(0.05, LikelihoodFieldOptions{});
  Random random(8);
  LikelihoodLookup in_empty(empty);
  in_empty.turn(random_points(random, 20), 0.3);
  EXPECT_EQ(in_empty.mean_at({1.0, 2.0}), 0.0);
  const LikelihoodField field = random_walls(random);
  LikelihoodLookup lookup(field);
  lookup.turn(HoughPoints{}, 0.3);
  EXPECT_EQ(lookup.mean_at({1.0, 2.0}), 0.0);
}

}  // namespace
}  // namespace matchbox_slam
