#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/sensor/point_scan.hpp"
#include "sensor/scan_of_room.hpp"

namespace matchbox_slam {
namespace {

TEST(ScanProjector, ProjectsTheSameWhateverItProjectedBefore) {
  ScanProjector projector;
  PointScan points;
  for (const std::size_t beams : {500, 180, 180, 1000, 180}) {
    for (const double field_of_view : {4.5, 3.0}) {
      for (const bool straighten : {false, true}) {
        ProjectionOptions options = plain();
        options.straighten_walls = straighten;
        const Eigen::Isometry3d base_from_laser = mount(0.2, 0.1, 0.0, 0.0, 0.3 * field_of_view);
        LaserScan scan = sweep(beams, field_of_view);
        measure(scan, base_from_laser);
        for (std::size_t k = 0; k < beams; ++k) {
          scan.ranges[k] += 0.01F * static_cast<float>(std::sin(17.0 * static_cast<double>(k * k)));
        }
        scan.ranges[beams / 3] = std::numeric_limits<float>::infinity();
        const Pose2 motion{0.02, 0.0, 0.01 * static_cast<double>(beams % 7)};
        const PointScan alone = project(scan, options, base_from_laser, motion);
        projector.project(scan, base_from_laser, motion, options, Eigen::Isometry3d::Identity(),
                          points);
        ASSERT_EQ(points.points.size(), alone.points.size());
        ASSERT_EQ(points.free_rays.size(), alone.free_rays.size());
        EXPECT_EQ(points.free_rays.front().end, alone.free_rays.front().end);
        for (std::size_t i = 0; i < alone.points.size(); ++i) {
          EXPECT_EQ(points.points[i].position, alone.points[i].position);
          EXPECT_EQ(points.points[i].normal, alone.points[i].normal);
          EXPECT_EQ(points.points[i].weight, alone.points[i].weight);
          EXPECT_EQ(points.points[i].moved, alone.points[i].moved);
          EXPECT_EQ(points.points[i].joined_to_next, alone.points[i].joined_to_next);
        }
      }
    }
  }
}

// --- which readings count ---

struct Reading {
  std::string name;
  float range;
  double option_min;
  double option_max;
  double option_free;
  std::size_t points;
  std::size_t free_rays;
  double length;  ///< of the point or the ray
};

std::ostream& operator<<(std::ostream& out, const Reading& reading) { return out << reading.name; }

class Readings : public testing::TestWithParam<Reading> {};

/// The scan's own limits are 0.1 m to 10 m.
TEST_P(Readings, AreSortedByRep117) {
  const Reading& reading = GetParam();
  LaserScan scan = sweep(1, 0.0);
  scan.range_min = 0.1F;
  scan.range_max = 10.0;
  scan.angle_min = 0.5;
  scan.ranges = {reading.range};
  ProjectionOptions options;
  options.min_range = reading.option_min;
  options.max_range = reading.option_max;
  options.free_range = reading.option_free;
  const PointScan projected = project(scan, options);
  ASSERT_EQ(projected.points.size(), reading.points);
  ASSERT_EQ(projected.free_rays.size(), reading.free_rays);
  const Eigen::Vector2d expected(reading.length * std::cos(0.5), reading.length * std::sin(0.5));
  for (const ScanPoint& point : projected.points) {
    EXPECT_LT((point.position - expected).norm(), 1e-6);
    EXPECT_EQ(point.origin, Eigen::Vector2d::Zero());
  }
  for (const FreeRay& ray : projected.free_rays) {
    EXPECT_LT((ray.end - expected).norm(), 1e-6);
    EXPECT_EQ(ray.origin, Eigen::Vector2d::Zero());
  }
}

INSTANTIATE_TEST_SUITE_P(
    PointScan, Readings,
    testing::Values(  //        range    min   max  free  points rays length
        Reading{"a_hit", 2.0F, 0.0, 100, 5.0, 1, 0, 2.0},
        Reading{"not_a_number", kNan, 0.0, 100, 5.0, 0, 0, 0},
        Reading{"too_close_to_measure", -kInf, 0.0, 100, 5.0, 0, 0, 0},
        Reading{"zero", 0.0F, 0.0, 100, 5.0, 0, 0, 0},
        Reading{"negative", -1.0F, 0.0, 100, 5.0, 0, 0, 0},
        Reading{"below_range_min", 0.0999F, 0.0, 100, 5.0, 0, 0, 0},
        Reading{"at_range_min", 0.1F, 0.0, 100, 5.0, 1, 0, 0.1},
        Reading{"no_return", kInf, 0.0, 100, 5.0, 0, 1, 5.0},
        Reading{"just_below_range_max", 9.99F, 0.0, 100, 5.0, 1, 0, 9.99},
        Reading{"at_range_max", 10.0F, 0.0, 100, 5.0, 0, 1, 5.0},
        Reading{"above_range_max", 11.0F, 0.0, 100, 5.0, 0, 1, 5.0},
        Reading{"the_largest_number", std::numeric_limits<float>::max(), 0.0, 100, 5.0, 0, 1, 5.0},
        Reading{"below_the_option_min", 0.49F, 0.5, 100, 5.0, 0, 0, 0},
        Reading{"at_the_option_min", 0.5F, 0.5, 100, 5.0, 1, 0, 0.5},
        Reading{"above_the_option_max", 7.0F, 0.0, 6.0, 5.0, 0, 1, 5.0},
        Reading{"free_not_beyond_the_max", kInf, 0.0, 3.0, 5.0, 0, 1, 3.0},
        Reading{"free_not_beyond_range_max", kInf, 0.0, 100, 50.0, 0, 1, 10.0},
        Reading{"free_switched_off", kInf, 0.0, 100, 0.0, 0, 0, 0}),
    [](const testing::TestParamInfo<Reading>& test) { return test.param.name; });

TEST(PointScan, KeepsStampAndOrder) {
  const PointScan scan = scan_of_room(101);
  EXPECT_EQ(scan.stamp, 17.25);
  ASSERT_EQ(scan.points.size(), 101U);
  double last = -kPi;
  for (const ScanPoint& point : scan.points) {
    const double angle = std::atan2(point.position.y(), point.position.x());
    EXPECT_GT(angle, last);
    last = angle;
  }
}

TEST(PointScan, ScansOfFewBeamsAreFine) {
  for (const std::size_t beams : {0U, 1U, 2U}) {
    LaserScan scan = sweep(beams, 1.0);
    measure(scan, Eigen::Isometry3d::Identity());
    const PointScan projected =
        project(scan, plain(), mount(0.1, 0.2, kPi, 0.0, 0.3), {0.1, 0, 0.2});
    ASSERT_EQ(projected.points.size(), beams);
    for (const ScanPoint& point : projected.points) {
      EXPECT_TRUE(point.position.allFinite());
      EXPECT_TRUE(point.normal.isZero()) << "two points may be any line";
      EXPECT_FALSE(point.joined_to_next);
      EXPECT_GT(point.weight, 0.0);
    }
  }
}

TEST(PointScan, OneLostBeamChangesNothingElse) {
  LaserScan scan = sweep(200, 4.5);
  measure(scan, Eigen::Isometry3d::Identity());
  const PointScan whole = project(scan);
  scan.ranges[90] = kNan;
  const PointScan without = project(scan);
  ASSERT_EQ(without.points.size(), 199U);
  EXPECT_TRUE(without.free_rays.empty());
  for (std::size_t i = 0; i < 199; ++i) {
    const ScanPoint& before = whole.points[i < 90 ? i : i + 1];
    EXPECT_EQ(without.points[i].position, before.position);
    if (i < 85 || i > 95) {  // next to it, a wall may be less certain
      EXPECT_LT((without.points[i].normal - before.normal).norm(), 1e-6);
    }
  }
}

TEST(PointScan, AllBeamsLostIsAnEmptyScan) {
  const PointScan scan = project(sweep(1000, 4.5));
  EXPECT_TRUE(scan.points.empty());
  EXPECT_TRUE(scan.free_rays.empty());
}

/// What covers a laser moves along with it.
TEST(ACoveredLaser, IsReadBesideTheCoverAlone) {
  LaserScan scan = sweep(100, 4.5);
  scan.ranges.assign(100, 2.0F);
  const auto covered = [&](std::size_t count, float range) {
    LaserScan result = scan;
    std::fill_n(result.ranges.begin(), count, range);
    return project(result).points.size();
  };
  EXPECT_EQ(covered(60, 0.15F), 40U);
  EXPECT_EQ(covered(100, 0.15F), 0U);
  EXPECT_EQ(covered(40, 0.15F), 100U);  // a wall close by
  EXPECT_EQ(covered(60, 0.25F), 100U);
}

// --- masked angles ---

struct Mask {
  std::string name;
  std::vector<double> sectors;
  std::vector<double> kept;  ///< of the beams at -2, -1, 0, 1, 2 rad
};

std::ostream& operator<<(std::ostream& out, const Mask& mask) { return out << mask.name; }

class MaskedAngles : public testing::TestWithParam<Mask> {};

TEST_P(MaskedAngles, AreIgnoredWhateverTheBeamsSay) {
  LaserScan scan = sweep(5, 4.0);
  scan.ranges = {1.0F, 2.0F, 3.0F, 4.0F, 5.0F};
  LaserScan empty = scan;
  empty.ranges.assign(5, kInf);
  ProjectionOptions options = plain();
  options.masked_angles = GetParam().sectors;
  std::vector<double> angles;
  for (const ScanPoint& point : project(scan, options).points) {
    angles.push_back(std::round(std::atan2(point.position.y(), point.position.x())));
  }
  EXPECT_EQ(angles, GetParam().kept);
  EXPECT_EQ(project(empty, options).free_rays.size(), GetParam().kept.size());
}

INSTANTIATE_TEST_SUITE_P(Sectors, MaskedAngles,
                         testing::Values(Mask{"none", {}, {-2, -1, 0, 1, 2}},
                                         Mask{"middle", {-1.1, 0.5}, {-2, 1, 2}},
                                         Mask{"edges_belong_to_it", {0.0, 1.0}, {-2, -1, 2}},
                                         Mask{"across_the_back", {1.5, -1.5}, {-1, 0, 1}},
                                         Mask{"another_turn", {1.5, 4.8}, {-1, 0, 1}},
                                         Mask{"two", {-2.1, -1.9, 0.9, 1.1}, {-1, 0, 2}},
                                         Mask{"everything", {-3.1, 3.1}, {}}),
                         [](const auto& mask) { return mask.param.name; });

TEST(ProjectionOptions, AnglesToMaskComeInPairs) {
  ProjectionOptions options;
  options.masked_angles = {0.5, 1.0};
  EXPECT_NO_THROW(check_projection_options(options));
  options.masked_angles = {0.5, 1.0, 2.0};
  EXPECT_THROW(check_projection_options(options), ConfigurationError);
}

TEST(ProjectionOptions, TheShortestRangeIsBelowTheLongest) {
  ProjectionOptions options;
  options.min_range = 0.5;
  options.max_range = 0.6;
  EXPECT_NO_THROW(check_projection_options(options));
  options.max_range = 0.5;
  EXPECT_EQ(error_text<ConfigurationError>([&] { check_projection_options(options); }),
            "scan/min_range: 0.5 m is not allowed with a scan/max_range of 0.5 m, since no reading "
            "would be left; allowed: less than that");
}

TEST(ProjectionOptions, NoSectorOfAMaskIsAWholeTurn) {
  ProjectionOptions options;
  options.masked_angles = {-3.0, 3.2};
  EXPECT_NO_THROW(check_projection_options(options));
  options.masked_angles = {0.5, 1.0, -kPi, kPi};
  EXPECT_THROW(check_projection_options(options), ConfigurationError);
}

// --- where the points are ---

TEST(PointScan, SweepingClockwiseGivesTheSamePointsInMirroredOrder) {
  LaserScan scan = sweep(300, 4.5);
  measure(scan, Eigen::Isometry3d::Identity());
  LaserScan clockwise = scan;
  clockwise.angle_min = angle_of(scan, 299);
  clockwise.angle_increment = -scan.angle_increment;
  std::reverse(clockwise.ranges.begin(), clockwise.ranges.end());
  const PointScan a = project(scan);
  const PointScan b = project(clockwise);
  ASSERT_EQ(b.points.size(), 300U);
  for (std::size_t i = 0; i < 300; ++i) {
    const ScanPoint& mirrored = b.points[299 - i];
    EXPECT_LT((a.points[i].position - mirrored.position).norm(), 1e-12);
    EXPECT_LT((a.points[i].normal - mirrored.normal).norm(), 1e-4);
    EXPECT_NEAR(a.points[i].weight, mirrored.weight, 1e-12);
  }
}

TEST(PointScan, UpsideDownMirrorsTheBeams) {
  LaserScan upright = sweep(300, 4.5);
  measure(upright, mount(0.2, -0.1, 0.0, 0.0, 0.4));
  // Beam k of the laser on its head points where beam 299 - k of the upright one does.
  LaserScan rolled = upright;
  std::reverse(rolled.ranges.begin(), rolled.ranges.end());
  const PointScan a = project(upright, plain(), mount(0.2, -0.1, 0.0, 0.0, 0.4));
  const PointScan b = project(rolled, plain(), mount(0.2, -0.1, kPi, 0.0, 0.4));
  ASSERT_EQ(b.points.size(), 300U);
  for (std::size_t i = 0; i < 300; ++i) {
    EXPECT_LT((a.points[i].position - b.points[299 - i].position).norm(), 1e-6);
    EXPECT_LT((a.points[i].normal - b.points[299 - i].normal).norm(), 1e-4);
  }
}

TEST(PointScan, PointsLieOnTheWallsHoweverTheLaserIsMounted) {
  for (const Eigen::Isometry3d& base_from_laser :
       {mount(0.0, 0.0, 0.0, 0.0, 0.0), mount(0.275, 0.0, 0.0, 0.0, 0.0),
        mount(-0.3, 0.4, 0.0, 0.0, 2.5), mount(0.1, 0.2, kPi, 0.0, -1.0),
        mount(0.1, 0.0, 0.0, 0.3, 0.0), mount(0.0, -0.1, 0.2, -0.4, 1.2),
        mount(0.0, -0.1, kPi - 0.1, 0.1, 3.1)}) {
    LaserScan scan = sweep(400, 4.5);
    measure(scan, base_from_laser);
    ProjectionOptions options = plain();
    options.free_range = 0.5;
    options.max_drop = options.max_rise = 100.0;
    scan.ranges[7] = kInf;
    const PointScan projected = project(scan, options, base_from_laser);
    ASSERT_EQ(projected.points.size(), 399U);
    for (const ScanPoint& point : projected.points) {
      EXPECT_LT(distance_to_walls(point.position), 2e-6);
      EXPECT_EQ(point.origin, Eigen::Vector2d(base_from_laser.translation().head<2>()));
    }
    ASSERT_EQ(projected.free_rays.size(), 1U);
    const Eigen::Vector2d ray = projected.free_rays[0].end - projected.free_rays[0].origin;
    const Eigen::Vector3d direction =
        base_from_laser.linear() *
        Eigen::Vector3d(std::cos(angle_of(scan, 7)), std::sin(angle_of(scan, 7)), 0.0);
    EXPECT_LT((ray - 0.5 * direction.head<2>()).norm(), 1e-12);
  }
}

TEST(PointScan, MotionDuringTheScanIsTakenOut) {
  const Pose2 motion{0.12, -0.03, 0.25};
  const Eigen::Isometry3d base_from_laser = mount(0.275, 0.05, kPi, 0.0, 0.1);
  LaserScan scan = sweep(500, 4.5);
  measure(scan, base_from_laser, motion);
  scan.ranges[3] = kNan;  // what is left out must not shift the time of those after it
  scan.ranges[499] = kInf;
  const PointScan projected = project(scan, plain(), base_from_laser, motion);
  ASSERT_EQ(projected.points.size(), 498U);
  for (const ScanPoint& point : projected.points) {
    EXPECT_LT(distance_to_walls(point.position), 2e-6);
  }
  const Eigen::Vector2d laser(base_from_laser.translation().head<2>());
  EXPECT_LT((projected.points.front().origin - laser).norm(), 1e-12);
  ASSERT_EQ(projected.free_rays.size(), 1U);
  EXPECT_LT((projected.free_rays[0].origin - motion * laser).norm(), 1e-12);
  // Without it, the scan is bent by centimetres.
  const PointScan bent = project(scan, plain(), base_from_laser);
  EXPECT_GT(distance_to_walls(bent.points[400].position), 0.01);
}

// --- heights ---

/// Beams ahead, to the left, back and to the right of a laser that looks down.
PointScan look_down(double pitch, double range, const ProjectionOptions& options) {
  LaserScan scan = sweep(4, 1.5 * kPi);
  scan.angle_min = 0.0;
  std::fill(scan.ranges.begin(), scan.ranges.end(), static_cast<float>(range));
  return project(scan, options, mount(0.0, 0.0, 0.0, pitch, 0.0));
}

TEST(Heights, ABeamCountsUpToWhereItLeavesTheBand) {
  ProjectionOptions options = plain();
  options.max_drop = 0.2;
  options.max_rise = 0.5;
  // 0.5 m along: 0.05 m down and up. All within the band.
  EXPECT_EQ(look_down(0.1, 0.5, options).points.size(), 4U);
  // 3 m: 0.3 m. The one ahead has left it at 2 m, as a ray that met nothing.
  const PointScan cut = look_down(0.1, 3.0, options);
  EXPECT_EQ(cut.points.size(), 3U);
  ASSERT_EQ(cut.free_rays.size(), 1U);
  EXPECT_NEAR(cut.free_rays[0].end.x(), 0.2 / std::tan(0.1), 1e-9);
  // 6 m: the one back is too high, and clears no more than other rays do.
  const PointScan both = look_down(0.1, 6.0, options);
  EXPECT_EQ(both.points.size(), 2U);
  ASSERT_EQ(both.free_rays.size(), 2U);
  EXPECT_NEAR(both.free_rays[1].end.x(), -5.0 * std::cos(0.1), 1e-9);
  // What meets nothing clears no more.
  const PointScan nothing = look_down(0.1, static_cast<double>(kInf), options);
  ASSERT_EQ(nothing.free_rays.size(), 4U);
  EXPECT_NEAR(nothing.free_rays[0].end.x(), 0.2 / std::tan(0.1), 1e-9);
  EXPECT_NEAR(nothing.free_rays[1].end.y(), 5.0, 1e-9);
  options.free_range = 0.0;
  EXPECT_TRUE(look_down(0.1, 3.0, options).free_rays.empty());
}

TEST(Heights, ADoorThroughWhichBeamsAreCutStaysOpen) {
  LaserScan scan = sweep(400, 2.5);
  measure(scan, mount(0.0, 0.0, 0.0, 0.1, 0.0));
  for (std::size_t k = 190; k < 210; ++k) {
    scan.ranges[k] = 10.0F;
  }
  ProjectionOptions options = plain();
  options.max_drop = 0.6;  // the wall is 4 m ahead
  const PointScan projected = project(scan, options, mount(0.0, 0.0, 0.0, 0.1, 0.0));
  ASSERT_EQ(projected.points.size(), 380U);
  EXPECT_TRUE(projected.points[188].joined_to_next);
  EXPECT_FALSE(projected.points[189].joined_to_next);
  EXPECT_TRUE(projected.points[190].joined_to_next);
}

TEST(Heights, ALevelLaserIsNotCut) {
  ProjectionOptions options = plain();
  options.max_drop = options.max_rise = 1e-3;
  EXPECT_EQ(look_down(0.0, 19.0, options).points.size(), 4U);
}

TEST(Heights, TheLasersOwnMotionIsTakenOut) {
  const Eigen::Isometry3d first = mount(0.2, 0.0, 0.05, -0.3, 0.1);
  const Eigen::Isometry3d last = mount(0.22, 0.01, 0.05, 0.3, 0.1);
  const Eigen::Isometry3d motion = first.inverse() * last;
  LaserScan scan = sweep(200, 4.5);
  for (std::size_t k = 0; k < 200; ++k) {
    LaserScan one = scan;
    const double fraction = static_cast<double>(k) / 199.0;
    Eigen::Isometry3d here = first * Eigen::Translation3d(fraction * motion.translation());
    here.rotate(
        Eigen::Quaterniond::Identity().slerp(fraction, Eigen::Quaterniond(motion.linear())));
    measure(one, here);
    scan.ranges[k] = one.ranges[k];
  }
  ProjectionOptions options = plain();
  options.max_drop = options.max_rise = 100.0;
  const PointScan projected = project_scan(scan, first, {}, options, motion);
  ASSERT_EQ(projected.points.size(), 200U);
  for (const ScanPoint& point : projected.points) {
    EXPECT_LT(distance_to_walls(point.position), 2e-6);
  }
  EXPECT_NEAR(tilt_of(first), std::acos(std::cos(0.05) * std::cos(0.3)), 1e-12);
  EXPECT_NEAR(tilt_of(mount(0.0, 0.0, kPi - 0.1, 0.0, 2.0)), 0.1, 1e-12);
}

TEST(PointScan, AppendedIsWhatALaserMountedThereSees) {
  const Pose2 base_from_other{0.7, -0.4, 2.1};
  LaserScan scan = sweep(300, 4.5);
  measure(scan, mount(base_from_other.x, base_from_other.y, 0.0, 0.0, base_from_other.theta));
  for (std::size_t k = 100; k < 140; ++k) {
    scan.ranges[k] = kInf;
  }
  const PointScan there = project(
      scan, plain(), mount(base_from_other.x, base_from_other.y, 0.0, 0.0, base_from_other.theta));
  PointScan both = scan_of_room(50);
  append(project(scan), base_from_other, both);
  ASSERT_EQ(both.points.size(), 50 + there.points.size());
  ASSERT_EQ(both.free_rays.size(), there.free_rays.size());
  for (std::size_t i = 0; i < there.points.size(); ++i) {
    const ScanPoint& point = both.points[50 + i];
    EXPECT_LT((point.position - there.points[i].position).norm(), 1e-9);
    EXPECT_LT((point.origin - there.points[i].origin).norm(), 1e-9);
    EXPECT_LT((point.normal - there.points[i].normal).norm(), 1e-6);
  }
  for (std::size_t i = 0; i < there.free_rays.size(); ++i) {
    EXPECT_LT((both.free_rays[i].origin - there.free_rays[i].origin).norm(), 1e-9);
    EXPECT_LT((both.free_rays[i].end - there.free_rays[i].end).norm(), 1e-9);
  }
}

/// Sets the option of a number to another value.
struct ChangeOption {
  template <typename Value, typename... Rest>
  void operator()(Value& value, const Rest&... /*rest*/) {
    if (number++ == changed) {
      change(value);
    }
  }
  static void change(double& value) { value += 0.25; }
  static void change(bool& value) { value = !value; }
  static void change(std::vector<double>& value) { value.push_back(1.0); }

  int changed;
  int number = 0;
};

TEST(ProjectionOptions, AreEqualWhenAllOfThemAre) {
  ChangeOption none{-1};
  ProjectionOptions same;
  ProjectionOptions::visit(same, none);
  EXPECT_TRUE(same == ProjectionOptions{});
  ASSERT_GT(none.number, 10);
  for (int i = 0; i < none.number; ++i) {
    ProjectionOptions other;
    ChangeOption one{i};
    ProjectionOptions::visit(other, one);
    EXPECT_FALSE(other == ProjectionOptions{}) << i;
  }
}

}  // namespace
}  // namespace matchbox_slam
