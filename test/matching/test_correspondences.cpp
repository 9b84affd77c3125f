#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/matching/correspondences.hpp"

namespace matchbox_slam {
namespace {

ScanPoint point_at(const Eigen::Vector2d& position, double weight) {
  ScanPoint point;
  point.position = position;
  point.origin = Eigen::Vector2d::Zero();
  point.weight = weight;
  return point;
}

/// Pieces of wall in all directions, some of unknown direction, and points around them. The number
/// of points is no multiple of anything.
struct Clutter {
  LikelihoodField field{0.05, LikelihoodFieldOptions{}};
  std::vector<ScanPoint> points;
  Pose2 map_from_base{0.4, -0.3, 0.5};

  explicit Clutter(std::uint64_t seed) {
    Random random(seed);
    std::vector<SurfaceHit> hits;
    for (int i = 0; i < 61; ++i) {
      const double angle = random.uniform(-kPi, kPi);
      const double x = random.uniform(-3.0, 3.0);
      const Eigen::Vector2d position(x, random.uniform(-3.0, 3.0));
      const bool known = i % 5 != 0;
      hits.push_back({position, known ? Eigen::Vector2d(std::cos(angle), std::sin(angle))
                                      : Eigen::Vector2d(0.0, 0.0)});
      const double off_x = random.uniform(-0.04, 0.08);
      const Eigen::Vector2d seen = position + Eigen::Vector2d(off_x, random.uniform(-0.04, 0.08));
      points.push_back(point_at(map_from_base.inverse() * seen, random.uniform(0.01, 0.1)));
    }
    field.update(hits, {});
  }
};

TEST(Correspondences, GradientIsThatOfTheCost) {
  const Clutter clutter(1);
  const Correspondences pairs(clutter.points, clutter.field, clutter.map_from_base);
  constexpr double kStep = 1e-6;
  for (const double kernel : {0.02, 0.05, 0.3}) {
    const NormalEquations equations = pairs.linearise(kernel);
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const double numeric = (pairs.cost(kernel, step) - pairs.cost(kernel, -step)) / (2.0 * kStep);
      EXPECT_NEAR(equations.gradient(i), numeric, 1e-7) << "kernel " << kernel << ", " << i;
    }
    EXPECT_GT(equations.gradient.norm(), 1e-2) << "the test shows nothing";
  }
}

TEST(Correspondences, InformationIsTheCurvatureUnderAWideKernel) {
  const Clutter clutter(2);
  const Correspondences pairs(clutter.points, clutter.field, clutter.map_from_base);
  // Under a kernel far wider than all residuals the cost is a parabola, and Gauss-Newton exact.
  constexpr double kKernel = 100.0;
  constexpr double kStep = 0.01;
  const NormalEquations equations = pairs.linearise(kKernel);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const Eigen::Vector3d a = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Vector3d b = kStep * Eigen::Vector3d::Unit(j);
      const double numeric = (pairs.cost(kKernel, a + b) - pairs.cost(kKernel, a - b) -
                              pairs.cost(kKernel, b - a) + pairs.cost(kKernel, -a - b)) /
                             (4.0 * kStep * kStep);
      EXPECT_NEAR(equations.information(i, j), numeric, 1e-4 * equations.information.norm());
    }
  }
  EXPECT_EQ(equations.information, Eigen::Matrix3d(equations.information.transpose()));
}

TEST(Correspondences, AStepThatIsTakenGivesTheClosenessForetold) {
  // One wall along y, so that every point keeps its wall whatever the step.
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  std::vector<SurfaceHit> hits;
  std::vector<ScanPoint> points;
  for (double y = -1.0; y <= 1.0; y += 0.01) {
    hits.push_back({{2.0, y}, {1.0, 0.0}});
    points.push_back(point_at({1.97, y}, 0.01));
  }
  field.update(hits, {});
  const Correspondences before(points, field, {});
  EXPECT_NEAR(before.closeness(0.03, Eigen::Vector3d::Zero()), 0.5, 1e-3) << "one kernel off";
  EXPECT_NEAR(before.closeness(0.03, {0.03, 0.0, 0.0}), 1.0, 1e-3);
  EXPECT_NEAR(before.closeness(0.03, {0.03, 0.01, 0.0}), 1.0, 1e-3) << "along the wall";
  const Correspondences after(points, field, {0.01, 0.0, 0.002});
  EXPECT_NEAR(before.closeness(0.03, {0.01, 0.0, 0.002}),
              after.closeness(0.03, Eigen::Vector3d::Zero()), 1e-3);
}

TEST(Correspondences, MovingThereIsStartingThere) {
  Clutter clutter(4);
  for (std::size_t i = 0; i < clutter.points.size(); i += 2) {
    const auto angle = static_cast<double>(i);
    clutter.points[i].normal = {std::cos(angle), std::sin(angle)};
  }
  LikelihoodField other(0.05, LikelihoodFieldOptions{});
  other.update({{{0.5, 0.5}, {1.0, 0.0}}, {{-1.0, 0.7}, {0.0, 1.0}}}, {});
  for (const PlacedFields& fields :
       {PlacedFields{{&clutter.field, {}}},
        PlacedFields{{&clutter.field, {}}, {&other, {0.1, 0.2, 0.3}}}}) {
    Correspondences moved(clutter.points, fields, clutter.map_from_base);
    // Within cells, to other cells, to where nothing is, and back.
    for (const Pose2& pose : {Pose2{0.401, -0.3, 0.5}, Pose2{0.45, -0.26, 0.52},
                              Pose2{100.0, 0.0, 0.5}, Pose2{0.4, -0.3, 0.5}}) {
      moved.move_to(pose);
      const Correspondences started(clutter.points, fields, pose);
      EXPECT_EQ(moved.linearise(0.05).information, started.linearise(0.05).information);
      EXPECT_EQ(moved.linearise(0.05).gradient, started.linearise(0.05).gradient);
      EXPECT_EQ(moved.residuals(0.05).measurements, started.residuals(0.05).measurements);
      EXPECT_EQ(moved.closeness(0.05, {0.0, 0.0, 0.0}), started.closeness(0.05, {0.0, 0.0, 0.0}));
    }
  }
}

/// A hit of the side wall lies in the corner with a front: it is none of the front's.
TEST(Correspondences, AWallAcrossTheMapsSaysNothingOfIt) {
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  field.update({{{2.0, 0.0}, {1.0, 0.0}}}, {});
  const auto along = [&field](const Eigen::Vector2d& normal, double heading) {
    ScanPoint point = point_at(Eigen::Rotation2Dd(-heading) * Eigen::Vector2d(1.98, 0.0), 0.1);
    point.normal = Eigen::Rotation2Dd(-heading) * normal;
    const Correspondences pairs({point}, field, {0.0, 0.0, heading});
    return pairs.linearise(0.3).information(0, 0);
  };
  const double of_its_own = along({-1.0, 0.0}, 0.0);
  EXPECT_GT(of_its_own, 0.2);
  for (const double heading : {-2.0, 0.0, 0.7, 3.0}) {
    EXPECT_NEAR(along({-1.0, 0.0}, heading), of_its_own, 1e-12) << heading;
    EXPECT_NEAR(along({0.0, 0.0}, heading), of_its_own, 1e-12) << heading << ", without a wall";
    EXPECT_NEAR(along({-std::cos(0.7), std::sin(0.7)}, heading), of_its_own, 1e-12)
        << heading << ", 40 degrees off, which noise may be";
    EXPECT_LT(along({0.0, 1.0}, heading), 0.02 * of_its_own) << heading;
    EXPECT_LT(along({-std::cos(1.2), std::sin(1.2)}, heading), 0.02 * of_its_own) << heading;
  }
}

/// Nor of the scan's noise: else what lies in corners makes covariances too small.
TEST(Correspondences, AWallAcrossTheMapsSaysNothingOfTheNoise) {
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  std::vector<ScanPoint> points;
  std::vector<SurfaceHit> walls;
  for (int i = 0; i < 40; ++i) {
    const double y = 0.05 * i + 0.025;
    walls.push_back({{2.0, y}, {1.0, 0.0}});
    points.push_back(point_at({i % 2 == 0 ? 1.99 : 2.01, y}, 0.1));
    points.back().normal = {-1.0, 0.0};
  }
  field.update(walls, {});
  const auto variance = [&field](const std::vector<ScanPoint>& seen) {
    const ResidualSum sum = Correspondences(seen, field, Pose2{}).residuals(0.3);
    return sum.squares / sum.measurements;
  };
  const double shown = variance(points);
  for (int i = 0; i < 20; ++i) {
    points.push_back(point_at({2.0, 0.1 * i + 0.025}, 0.1));
    points.back().normal = {0.0, 1.0};
  }
  EXPECT_NEAR(variance(points), shown, 0.01 * shown);
}

TEST(Correspondences, AFieldMayLieAnywhere) {
  const Clutter clutter(5);
  const Pose2 there{3.0, -1.0, 2.0};
  const Correspondences here(clutter.points, clutter.field, clutter.map_from_base);
  const Correspondences moved(clutter.points, PlacedFields{{&clutter.field, there}},
                              there * clutter.map_from_base);
  EXPECT_NEAR(moved.closeness(0.05, {0.0, 0.0, 0.0}), here.closeness(0.05, {0.0, 0.0, 0.0}), 1e-9);
  const Eigen::Vector3d gradient = here.linearise(0.05).gradient;
  const Eigen::Vector2d turned = Pose2{0.0, 0.0, there.theta} * Eigen::Vector2d(gradient.head<2>());
  EXPECT_TRUE(moved.linearise(0.05).gradient.isApprox(
      Eigen::Vector3d(turned.x(), turned.y(), gradient.z()), 1e-9));
  EXPECT_NEAR(moved.residuals(0.05).squares, here.residuals(0.05).squares, 1e-9);
}

TEST(Correspondences, PointsWithoutAWallCountAsUnexplained) {
  Clutter clutter(3);
  const Correspondences near(clutter.points, clutter.field, clutter.map_from_base);
  const std::size_t count = clutter.points.size();
  for (std::size_t i = 0; i < count; ++i) {
    clutter.points.push_back(clutter.points[i]);
    clutter.points.back().position += Eigen::Vector2d(100.0, 0.0);
  }
  const Correspondences half(clutter.points, clutter.field, clutter.map_from_base);
  EXPECT_NEAR(half.closeness(0.05, Eigen::Vector3d::Zero()),
              0.5 * near.closeness(0.05, Eigen::Vector3d::Zero()), 1e-12);
  EXPECT_TRUE(half.linearise(0.05).information.isApprox(near.linearise(0.05).information, 1e-12));
}

/// Points at one piece of wall that faces along x, which was hit several times before.
Correspondences points_at_one_surface(int points, int hits, bool directed = true) {
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  const Eigen::Vector2d middle(2.02, 0.02);
  const Eigen::Vector2d normal(directed ? 1.0 : 0.0, 0.0);
  field.update(std::vector<SurfaceHit>(static_cast<std::size_t>(hits), {middle, normal}), {});
  const std::vector<ScanPoint> scan(static_cast<std::size_t>(points), point_at(middle, 0.01));
  return {scan, field, {}};
}

double information_along_x(const Correspondences& pairs) {
  return pairs.linearise(0.05).information(0, 0);
}

TEST(Correspondences, PointsAtOneSurfaceShareItsError) {
  EXPECT_NEAR(information_along_x(points_at_one_surface(1, 1)), 1.0 / 2.25, 1e-3);
  EXPECT_NEAR(information_along_x(points_at_one_surface(1, 4)), 1.0 / 1.5, 1e-3);
  EXPECT_NEAR(information_along_x(points_at_one_surface(20, 4)), 20.0 / 11.0, 1e-3);
  // Many points at a surface are worth what the surface is known to, and no more.
  EXPECT_NEAR(information_along_x(points_at_one_surface(10000, 4)), 2.0, 1e-3);
}

TEST(Correspondences, ASurfaceSharesItsErrorOnlyWithItsOwnPoints) {
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  field.update({{{2.02, 0.02}, {1.0, 0.0}}, {{2.02, 1.02}, {1.0, 0.0}}}, {});
  const ScanPoint a = point_at({2.02, 0.02}, 0.01);
  const ScanPoint b = point_at({2.02, 1.02}, 0.01);
  const double expected = 3.0 / (1.0 + 3.0 * 1.25) + 1.0 / 2.25;
  EXPECT_NEAR(information_along_x({{a, a, a, b}, field, {}}), expected, 1e-3);
  EXPECT_NEAR(information_along_x({{a, b, a, a}, field, {}}), expected, 1e-3)
      << "noise makes points jump to the next surface and back";
}

TEST(Correspondences, ASurfaceWithoutDirectionHoldsLess) {
  const NormalEquations blunt = points_at_one_surface(1, 4, false).linearise(0.05);
  EXPECT_NEAR(blunt.information(0, 0), 0.5 / 5.5, 1e-3);
  EXPECT_NEAR(blunt.information(1, 1), 0.5 / 5.5, 1e-3);
}

/// Between sparse beams it may lie anywhere: within a cell its variance is 4 times the noise's.
TEST(Correspondences, APointBetweenSparseBeamsHoldsLess) {
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  const Eigen::Vector2d middle(2.02, 0.02);
  field.update(std::vector<SurfaceHit>(4, {middle, {0.0, 0.0}}), {});
  const auto information = [&](const Eigen::Vector2d& normal, double spacing) {
    ScanPoint point = point_at(middle, 0.01);
    point.normal = normal;
    point.spacing = spacing;
    return Correspondences({point}, field, {}).linearise(0.05).information;
  };
  EXPECT_NEAR(information({0.0, 0.0}, 0.05)(0, 0), 0.5 / (1.5 + 4.0), 1e-3);
  EXPECT_NEAR(information({0.0, 0.0}, 0.5)(0, 0), 0.5 / (1.5 + 400.0), 1e-5);
  EXPECT_NEAR(information({-1.0, 0.0}, 0.5)(0, 0), 1.0 / (1.5 + 4.0), 1e-3) << "a wall goes on";
}

/// Where the map does not know how a surface runs: across the point's own wall, not along it.
TEST(Correspondences, ThePointsOwnNormalTellsWhatTheMapDoesNotKnow) {
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  field.update({{{2.02, 0.02}, {0.0, 0.0}}}, {});
  for (const double heading : {0.0, 0.7, -2.5}) {
    const Eigen::Rotation2Dd base_from_map(-heading);
    ScanPoint point = point_at(base_from_map * Eigen::Vector2d(2.02, 0.02), 0.01);
    point.normal = base_from_map * Eigen::Vector2d(-1.0, 0.0);
    const NormalEquations pair =
        Correspondences({point}, field, {0.0, 0.0, heading}).linearise(0.05);
    EXPECT_GT(pair.information(0, 0), 0.1) << heading;
    EXPECT_LT(pair.information(1, 1), 1e-3 * pair.information(0, 0)) << heading;
  }
}

/// A wall along x, one hit a cell, with a point on each; normals are off by as much in the map and
/// in the scan [rad], or there are none.
class WallOfNormals {
 public:
  WallOfNormals(std::optional<double> in_map, std::optional<double> in_scan) {
    Random random(7);
    const auto normal = [&random](const std::optional<double>& noise) {
      return noise ? Eigen::Vector2d(Eigen::Rotation2Dd(*noise * random.gaussian()) *
                                     Eigen::Vector2d::UnitY())
                   : Eigen::Vector2d(Eigen::Vector2d::Zero());
    };
    std::vector<SurfaceHit> hits;
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector2d position(0.05 * i + 0.025, 0.025);
      hits.push_back({position, normal(in_map)});
      ScanPoint point = point_at(position, 0.05);
      point.normal = normal(in_scan);
      points_.push_back(point);
    }
    field_.update(hits, {});
    pairs_ = Correspondences(points_, field_, Pose2{});
  }

  [[nodiscard]] double told(const Eigen::Vector3d& motion) const {
    return motion.dot(pairs_.linearise(kKernel).information * motion);
  }
  [[nodiscard]] double confirmed(const Eigen::Vector3d& motion) const {
    return pairs_.confirmed_information(kKernel, motion);
  }

 private:
  static constexpr double kKernel = 0.03;
  LikelihoodField field_{0.05, LikelihoodFieldOptions{}};
  std::vector<ScanPoint> points_;
  Correspondences pairs_;
};

const Eigen::Vector3d kAlong = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kAcross(0.3, 0.8, 0.001);  // and along, and with a turn

TEST(Correspondences, MapAndScanConfirmWhatBothSay) {
  const WallOfNormals wall(0.0, 0.0);
  EXPECT_NEAR(wall.confirmed(kAcross), wall.told(kAcross), 1e-5 * wall.told(kAcross));
  EXPECT_NEAR(wall.confirmed(kAlong), 0.0, 1e-5 * wall.told(kAcross));
}

TEST(Correspondences, NoiseOfNormalsIsNotConfirmed) {
  constexpr double kNoise = 0.2;
  const WallOfNormals wall(kNoise, kNoise);
  const double of_noise = wall.told(kAlong);
  EXPECT_GT(of_noise, 0.02 * wall.told(kAcross)) << "the test shows nothing";
  EXPECT_LT(std::abs(wall.confirmed(kAlong)), 0.1 * of_noise);
  EXPECT_NEAR(wall.confirmed(kAcross), wall.told(kAcross), 0.1 * wall.told(kAcross));
}

TEST(Correspondences, WhereOneKnowsNoDirectionHalfIsConfirmed) {
  for (const WallOfNormals& wall : {WallOfNormals(0.0, {}), WallOfNormals({}, 0.0)}) {
    EXPECT_NEAR(wall.confirmed(kAcross), 0.5 * wall.told(kAcross), 1e-5 * wall.told(kAcross));
  }
}

TEST(Correspondences, TheResidualsTellTheNoise) {
  for (const double noise : {0.003, 0.01, 0.03}) {
    Random random(5);
    LikelihoodField field(0.05, LikelihoodFieldOptions{});
    std::vector<ScanPoint> points;
    for (int i = 0; i < 2000; ++i) {
      const double y = 0.025 + 0.05 * i;
      field.update(std::vector<SurfaceHit>(4, {{2.025, y}, {1.0, 0.0}}), {});
      points.push_back(point_at({2.025 + noise * random.gaussian(), y}, 0.05));
    }
    // Corners and the like, which miss by centimetres however little noise there is.
    for (int i = 0; i < 500; ++i) {
      const double y = 1.025 + 0.2 * i;
      field.update({{{-3.025, y}, {0.0, 0.0}}}, {});
      points.push_back(point_at({-3.005, y}, 0.05));
    }
    // Half a unit of variance on top of a point's own is the surface's: 1 / 4 + 1 / 4.
    const Correspondences pairs(points, field, {});
    const ResidualSum wide = pairs.residuals(1.0);
    EXPECT_NEAR(std::sqrt(1.5 * wide.squares / wide.measurements), noise, 0.05 * noise);
    EXPECT_NEAR(wide.measurements, 2000.0, 10.0);
    const ResidualSum narrow = pairs.residuals(0.03);
    EXPECT_LT(narrow.squares / narrow.measurements, wide.squares / wide.measurements);
  }
}

TEST(Correspondences, ResidualsAreThoseOfThePointsAsTheyWereMeasured) {
  const Pose2 map_from_base{0.4, -0.3, 0.7};
  const Pose2 base_from_map = map_from_base.inverse();
  const Eigen::Vector2d laser(0.3, 0.1);  // in the base
  LikelihoodField field(0.05, LikelihoodFieldOptions{});
  std::vector<ScanPoint> measured;
  std::vector<ScanPoint> moved;
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector2d wall(2.025, 0.025 + 0.05 * i);
    field.update({{wall, {1.0, 0.0}}}, {});
    const double off = 0.005 * random.gaussian();
    const Eigen::Vector2d seen = base_from_map * wall;
    moved.push_back(point_at(seen, 0.05));
    moved.back().origin = laser;
    moved.back().moved = -off;
    measured.push_back(point_at(seen + off * (seen - laser).normalized(), 0.05));
  }
  const ResidualSum as_measured = Correspondences(measured, field, map_from_base).residuals(0.05);
  const ResidualSum as_moved = Correspondences(moved, field, map_from_base).residuals(0.05);
  EXPECT_GT(as_measured.squares, 0.0);
  EXPECT_NEAR(as_moved.squares, as_measured.squares, 1e-3 * as_measured.squares);
  EXPECT_NEAR(as_moved.measurements, as_measured.measurements, 1e-9);
}

TEST(Correspondences, NothingSaysNothing) {
  const Clutter clutter(4);
  const LikelihoodField no_map(0.05, LikelihoodFieldOptions{});
  for (const Correspondences& pairs :
       {Correspondences({}, clutter.field, {}), Correspondences(clutter.points, no_map, {})}) {
    EXPECT_EQ(pairs.closeness(0.05, Eigen::Vector3d::Zero()), 0.0);
    EXPECT_TRUE(pairs.linearise(0.05).information.isZero(0.0));
    EXPECT_TRUE(pairs.linearise(0.05).gradient.isZero(0.0));
    EXPECT_EQ(pairs.cost(0.05, {0.01, 0.0, 0.0}), 0.0);
    EXPECT_EQ(pairs.residuals(0.05).measurements, 0.0);
  }
}

}  // namespace
}  // namespace matchbox_slam
