#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "map/scan_drawing.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/map/scan_inserter.hpp"

namespace matchbox_slam {
namespace {

/// Numbers that are easy to follow, apart from the defaults, which may be tuned.
MapOptions tidy_options() {
  MapOptions options;
  options.resolution = 0.1;
  options.quality = 0.5;
  options.no_return_quality = 0.2;
  options.hole_width = 0.4;
  options.occupied_threshold = 0.5;
  return options;
}

ScanPoint hit(double x, double y) {
  ScanPoint point;
  point.position = {x, y};
  point.origin = Eigen::Vector2d::Zero();
  point.normal = -point.position.normalized();
  point.weight = 0.1;
  return point;
}

PointScan scan_of(std::vector<ScanPoint> points, std::vector<FreeRay> free_rays = {}) {
  PointScan scan;
  scan.points = std::move(points);
  scan.free_rays = std::move(free_rays);
  return scan;
}

SlamMap make_map(const MapOptions& options = tidy_options()) {
  return {options, LikelihoodFieldOptions{}};
}

double occupancy_at(const SlamMap& map, double x, double y) {
  return map.occupancy.occupancy(map.occupancy.geometry().cell_at({x, y}));
}

bool has_surface_at(const SlamMap& map, double x, double y) {
  return map.field.has_surface(map.field.geometry().cell_at({x, y}));
}

TEST(ScanInserter, FreeAlongTheBeamOccupiedAtTheHitUnknownBehind) {
  SlamMap map = make_map();
  insert_scan(scan_of({hit(1.05, 0.05)}), {}, tidy_options(), map);
  for (double x = 0.05; x < 0.8; x += 0.1) {
    EXPECT_NEAR(occupancy_at(map, x, 0.05), 0.25, 1e-4) << x;  // half-way from 0.5 to 0
  }
  EXPECT_NEAR(occupancy_at(map, 1.05, 0.05), 0.75, 1e-4);
  for (double x = 1.25; x < 2.0; x += 0.1) {
    EXPECT_FALSE(map.occupancy.is_known(map.occupancy.geometry().cell_at({x, 0.05}))) << x;
  }
  EXPECT_TRUE(has_surface_at(map, 1.05, 0.05));
  EXPECT_EQ(map.field.surface_cells().size(), 1U);
}

TEST(ScanInserter, DrawsTheSameWhateverWasDrawnBefore) {
  Random random(9);
  SlamMap map = make_map();
  for (int i = 0; i < 20; ++i) {
    const double size = i % 3 == 0 ? 60.0 : 4.0;  // more tiles, then fewer, elsewhere
    std::vector<ScanPoint> points;
    std::vector<FreeRay> rays;
    for (int k = 0; k < 50; ++k) {
      points.push_back(hit(random.uniform(-size, size), random.uniform(-size, size)));
      rays.push_back({{0.0, 0.0}, {random.uniform(-size, size), random.uniform(-size, size)}});
    }
    const PointScan scan = scan_of(points, rays);
    const Pose2 pose{random.uniform(-30.0, 30.0), random.uniform(-30.0, 30.0),
                     random.uniform(-kPi, kPi)};
    SlamMap copy = map;  // without what the other one works in
    insert_scan(scan, pose, tidy_options(), map);
    insert_scan(scan, pose, tidy_options(), copy);
    const CellBox known = map.occupancy.known_bounds();
    ASSERT_EQ(known.min, copy.occupancy.known_bounds().min);
    ASSERT_EQ(known.max, copy.occupancy.known_bounds().max);
    for (int y = known.min.y; y < known.max.y; ++y) {
      for (int x = known.min.x; x < known.max.x; ++x) {
        ASSERT_EQ(map.occupancy.occupancy({x, y}), copy.occupancy.occupancy({x, y}));
        ASSERT_EQ(map.field.likelihood({x, y}), copy.field.likelihood({x, y}));
      }
    }
  }
}

TEST(ScanInserter, TheHoleRisesTowardsTheHit) {
  MapOptions options = tidy_options();
  options.resolution = 0.02;
  options.quality = 1.0;  // so that the map shows what was observed
  SlamMap map = make_map(options);
  insert_scan(scan_of({hit(1.01, 0.01)}), {}, options, map);
  // Half a hole, 0.2 m, in front of the hit it says free; then it rises linearly, within a cell.
  for (double x = 0.01; x < 1.02; x += 0.02) {
    const double expected = std::max(0.0, 1.0 - (1.01 - x) / 0.2);
    EXPECT_NEAR(occupancy_at(map, x, 0.01), expected, 0.11) << x;
  }
  // Behind the hit it falls and stops where it says rather free than occupied.
  EXPECT_GT(occupancy_at(map, 1.07, 0.01), 0.55);
  EXPECT_FALSE(map.occupancy.is_known(map.occupancy.geometry().cell_at({1.15, 0.01})));
}

TEST(ScanInserter, WithoutAHoleOnlyTheHitIsOccupied) {
  MapOptions options = tidy_options();
  options.hole_width = 0.0;
  SlamMap map = make_map(options);
  insert_scan(scan_of({hit(1.05, 0.05)}), {}, options, map);
  EXPECT_NEAR(occupancy_at(map, 0.95, 0.05), 0.25, 1e-4);
  EXPECT_NEAR(occupancy_at(map, 1.05, 0.05), 0.75, 1e-4);
  EXPECT_FALSE(map.occupancy.is_known(map.occupancy.geometry().cell_at({1.15, 0.05})));
}

TEST(ScanInserter, ABeamIsFreeInTheCellsThatItCrossesAndInNoOther) {
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    SlamMap map = make_map();
    ScanPoint point = hit(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0));
    point.origin = {random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)};
    insert_scan(scan_of({point}), {}, tidy_options(), map);
    // Sampled densely, the free part of the beam never leaves the cells that were drawn.
    const double range = (point.position - point.origin).norm();
    const double free_part = range - 0.5 * tidy_options().hole_width;
    for (double way = 0.0; way <= free_part; way += 0.002) {
      const Eigen::Vector2d at = point.origin + way / range * (point.position - point.origin);
      const GridGeometry& geometry = map.occupancy.geometry();
      const Eigen::Vector2d off = at - geometry.center(geometry.cell_at(at));
      if (off.cwiseAbs().maxCoeff() < 0.049) {  // on the edge of two cells either will do
        ASSERT_LT(map.occupancy.occupancy(geometry.cell_at(at)), 0.5);
      }
    }
    // Nor does it leave the line, along x, along y or across.
    const CellBox bounds = map.occupancy.known_bounds();
    const Eigen::Vector2d direction = (point.position - point.origin) / range;
    for (int y = bounds.min.y; y < bounds.max.y; ++y) {
      for (int x = bounds.min.x; x < bounds.max.x; ++x) {
        const Eigen::Vector2d off = map.occupancy.geometry().center({x, y}) - point.origin;
        const double beside = std::abs(off.x() * direction.y() - off.y() * direction.x());
        const double half_cell = 0.05 * direction.cwiseAbs().sum();
        ASSERT_TRUE(!map.occupancy.is_known({x, y}) || beside < half_cell + 1e-9);
      }
    }
  }
}

TEST(ScanInserter, ABeamAlongAnEdgeOfCellsStaysInItsCells) {
  // By rounding 0.3 lies in cell 3, and yet below its edge.
  SlamMap map = make_map();
  const double edge = map.occupancy.geometry().corner({3, 3}).x();
  const double below = 0.3;
  ASSERT_EQ(map.occupancy.geometry().cell_at({edge, below}), (Cell{3, 3}));
  ASSERT_LT(below, edge);
  insert_scan(scan_of({}, {{{edge, edge}, {below, 20.0}}, {{edge, edge}, {20.0, below}}}), {},
              tidy_options(), map);
  EXPECT_EQ(map.occupancy.known_bounds().min, (Cell{3, 3}));
  for (int i = 3; i < 199; ++i) {
    EXPECT_TRUE(map.occupancy.is_known({i, 3})) << i;
    EXPECT_TRUE(map.occupancy.is_known({3, i})) << i;
  }
}

TEST(ScanInserter, ARayWithoutReturnClearsButMarksNothing) {
  SlamMap map = make_map();
  insert_scan(scan_of({}, {{{0.05, 0.05}, {2.05, 0.05}}}), {}, tidy_options(), map);
  for (double x = 0.05; x < 2.1; x += 0.1) {
    EXPECT_NEAR(occupancy_at(map, x, 0.05), 0.4, 1e-4) << x;  // a fifth of the way from 0.5 to 0
  }
  EXPECT_FALSE(map.occupancy.is_known({21, 0}));
  EXPECT_TRUE(map.field.empty());
}

TEST(ScanInserter, PoseOfTheBaseIsApplied) {
  SlamMap map = make_map();
  insert_scan(scan_of({hit(1.0, 0.0)}), {5.05, -2.95, 0.5 * kPi}, tidy_options(), map);
  EXPECT_GT(occupancy_at(map, 5.05, -1.95), 0.7);
  EXPECT_LT(occupancy_at(map, 5.05, -2.75), 0.3);
  Surface surface;
  ASSERT_TRUE(map.field.nearest_surface(map.field.geometry().cell_at({5.05, -1.95}), surface));
  EXPECT_LT((surface.position - Eigen::Vector2d(5.05, -1.95)).norm(), 1e-4);
  EXPECT_LT((surface.double_angle - Eigen::Vector2d(-1.0, 0.0)).norm(), 1e-3) << "normal along y";
}

/// A wall 0.6 m to the left, seen from the middle: many beams graze along it.
PointScan grazing_scan(double spacing, bool joined) {
  std::vector<ScanPoint> points;
  for (double x = 8.0; x > 0.0; x -= spacing) {
    points.push_back(hit(x, 0.62));
    points.back().normal = {0.0, -1.0};
    points.back().joined_to_next = joined && x - spacing > 0.0;
  }
  return scan_of(std::move(points));
}

TEST(ScanInserter, GrazingBeamsDoNotEraseAWall) {
  SlamMap map = make_map();
  for (int i = 0; i < 10; ++i) {
    insert_scan(grazing_scan(0.05, false), {}, tidy_options(), map);
  }
  for (double x = 0.2; x < 8.0; x += 0.1) {
    EXPECT_GT(occupancy_at(map, x, 0.62), 0.9) << x;
    EXPECT_TRUE(has_surface_at(map, x, 0.62)) << x;
  }
}

TEST(ScanInserter, JoinedHitsAreAWallWithoutHoles) {
  for (const bool joined : {true, false}) {
    SlamMap map = make_map();
    for (int i = 0; i < 10; ++i) {
      insert_scan(grazing_scan(0.5, joined), {}, tidy_options(), map);
    }
    int walls = 0;
    for (double x = 1.05; x < 7.9; x += 0.1) {
      walls += has_surface_at(map, x, 0.62) && occupancy_at(map, x, 0.62) > 0.9 ? 1 : 0;
    }
    if (joined) {
      EXPECT_EQ(walls, 69);
    } else {
      EXPECT_LT(walls, 20);
    }
  }
}

TEST(ScanInserter, TheOrderOfTheBeamsDoesNotMatter) {
  Random random(8);
  PointScan scan = grazing_scan(0.05, false);
  for (int i = 0; i < 50; ++i) {
    scan.points.push_back(hit(random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)));
    scan.free_rays.push_back({{0.0, 0.0}, {random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)}});
  }
  SlamMap map = make_map();
  insert_scan(scan, {0.3, 0.2, 0.1}, tidy_options(), map);
  std::reverse(scan.points.begin(), scan.points.end());
  std::reverse(scan.free_rays.begin(), scan.free_rays.end());
  SlamMap reversed = make_map();
  insert_scan(scan, {0.3, 0.2, 0.1}, tidy_options(), reversed);
  const CellBox bounds = map.occupancy.known_bounds();
  EXPECT_EQ(reversed.occupancy.known_bounds().min, bounds.min);
  EXPECT_EQ(reversed.occupancy.known_bounds().max, bounds.max);
  for (int y = bounds.min.y; y < bounds.max.y; ++y) {
    for (int x = bounds.min.x; x < bounds.max.x; ++x) {
      ASSERT_EQ(map.occupancy.stored({x, y}), reversed.occupancy.stored({x, y}));
      ASSERT_EQ(map.field.has_surface({x, y}), reversed.field.has_surface({x, y}));
    }
  }
}

TEST(ScanInserter, TheMostOccupiedObservationOfACellWins) {
  SlamMap map = make_map();
  // One beam ends where another passes and a third without return does.
  insert_scan(scan_of({hit(1.05, 0.05), hit(3.05, 0.05)}, {{{0.0, 0.05}, {4.0, 0.05}}}), {},
              tidy_options(), map);
  EXPECT_NEAR(occupancy_at(map, 1.05, 0.05), 0.75, 1e-4);
  EXPECT_NEAR(occupancy_at(map, 2.05, 0.05), 0.25, 1e-4);
  EXPECT_NEAR(occupancy_at(map, 3.55, 0.05), 0.4, 1e-4);
}

TEST(ScanInserter, ACellSeenFreeLosesItsSurface) {
  SlamMap map = make_map();
  insert_scan(scan_of({hit(1.05, 0.05)}), {}, tidy_options(), map);
  ASSERT_TRUE(has_surface_at(map, 1.05, 0.05));
  insert_scan(scan_of({hit(3.05, 0.05)}), {}, tidy_options(), map);  // 0.75 becomes 0.375
  EXPECT_LT(occupancy_at(map, 1.05, 0.05), 0.5);
  EXPECT_FALSE(has_surface_at(map, 1.05, 0.05));
  EXPECT_TRUE(has_surface_at(map, 3.05, 0.05));
  // And gains it back when the obstacle stands there again.
  insert_scan(scan_of({hit(1.05, 0.05)}), {}, tidy_options(), map);
  EXPECT_TRUE(has_surface_at(map, 1.05, 0.05));
}

TEST(ScanInserter, AHitInACellKnownToBeFreeIsNoSurfaceYet) {
  SlamMap map = make_map();
  for (int i = 0; i < 5; ++i) {
    insert_scan(scan_of({hit(3.05, 0.05)}), {}, tidy_options(), map);
  }
  MapOptions slow = tidy_options();
  slow.quality = 0.3;
  insert_scan(scan_of({hit(1.05, 0.05)}), {}, slow, map);
  EXPECT_FALSE(has_surface_at(map, 1.05, 0.05));
  insert_scan(scan_of({hit(1.05, 0.05)}), {}, slow, map);
  EXPECT_TRUE(has_surface_at(map, 1.05, 0.05));
}

TEST(ScanInserter, AMapThatNobodyLooksAtHasTheSameHitsAndSomeOfTheBeams) {
  PointScan scan;
  constexpr int kBeams = 1440;
  for (int i = 0; i < kBeams; ++i) {
    const double angle = 2.0 * kPi * i / kBeams;
    scan.points.push_back(hit(12.0 * std::cos(angle), 12.0 * std::sin(angle)));
  }
  SlamMap shown = make_map();
  SlamMap matched = make_map();
  insert_unrendered(scan, {}, tidy_options(), MapUse::kShown, shown);
  insert_unrendered(scan, {}, tidy_options(), MapUse::kMatched, matched);
  int free_shown = 0;
  int free_matched = 0;
  for (int y = -130; y < 130; ++y) {
    for (int x = -130; x < 130; ++x) {
      const Cell cell{x, y};
      const bool is_hit = shown.occupancy.occupancy(cell) > 0.5;
      ASSERT_EQ(is_hit, matched.occupancy.occupancy(cell) > 0.5) << x << " " << y;
      ASSERT_TRUE(shown.occupancy.is_known(cell) || !matched.occupancy.is_known(cell));
      free_shown += shown.occupancy.occupancy(cell) < 0.5 ? 1 : 0;
      free_matched += matched.occupancy.occupancy(cell) < 0.5 ? 1 : 0;
    }
  }
  // At 12 m 360 beams are two cells apart.
  EXPECT_LT(free_matched, 0.9 * free_shown);
  EXPECT_GT(free_matched, 0.7 * free_shown);
}

/// Of a map with a wall.
void expect_no_change(const PointScan& scan, const Pose2& pose) {
  SlamMap map = make_map();
  insert_scan(scan_of({hit(1.05, 0.05), hit(1.05, 0.15)}), {}, tidy_options(), map);
  const CellBox known = map.occupancy.known_bounds();
  const std::size_t bytes = map.occupancy.bytes() + map.field.bytes() + map.reflection.bytes();
  EXPECT_FALSE(has_room(scan, pose, tidy_options(), map));
  insert_scan(scan, pose, tidy_options(), map);
  insert_unrendered(scan, pose, tidy_options(), MapUse::kMatched, map);
  EXPECT_EQ(map.occupancy.known_bounds().min, known.min);
  EXPECT_EQ(map.occupancy.known_bounds().max, known.max);
  EXPECT_EQ(map.occupancy.bytes() + map.field.bytes() + map.reflection.bytes(), bytes);
}

TEST(ScanInserter, AScanThatNoMapHasRoomForChangesNothing) {
  for (const double far : {1e7, 1e9, 4e25}) {  // [m]
    SCOPED_TRACE(far);
    expect_no_change(scan_of({hit(1.05, 0.05), hit(far, 0.01)}), {});
    expect_no_change(scan_of({hit(1.05, 0.05), hit(far, -far)}), {});
    expect_no_change(scan_of({hit(1.05, 0.05), hit(1.05, 1.05)}), {far, 0.0, 0.0});
  }
}

TEST(ScanInserter, AMapMayBeAsFarAwayAsCellsAreCounted) {
  SlamMap map = make_map();
  const Pose2 pose{2.6e7, -2.6e7, 0.0};
  insert_scan(scan_of({hit(1.05, 0.05)}), pose, tidy_options(), map);
  EXPECT_TRUE(
      map.occupancy.is_known(map.occupancy.geometry().cell_at(pose * Eigen::Vector2d(1.05, 0.05))));
  EXPECT_FALSE(has_room(scan_of({hit(1.05, 0.05)}), {2.7e7, 0.0, 0.0}, tidy_options(), make_map()));
}

TEST(ScanInserter, AKeyScanIsDrawnAgainThoughFewerCellsAreAllowedByNow) {
  MapOptions options = tidy_options();
  options.max_cells = 1e5;  // 300 x 300
  const PointScan scan = scan_of({hit(30.0, 30.0), hit(-30.0, -30.0)});
  SlamMap map = make_map();
  EXPECT_FALSE(has_room(scan, {}, options, map));
  insert_unrendered(scan, {}, options, MapUse::kMatched, map);
  EXPECT_TRUE(map.occupancy.is_known(map.occupancy.geometry().cell_at({30.0, 30.0})));
}

TEST(ScanInserter, ItsPartsDrawWhatTheWholeDraws) {
  Random random(3);
  SlamMap whole = make_map();
  SlamMap unrendered = make_map();
  OccupancyGrid occupancy(tidy_options().resolution);
  InsertionMemory memory;
  for (int i = 0; i < 20; ++i) {
    PointScan scan;
    for (int k = 0; k < 50; ++k) {
      scan.points.push_back(hit(random.uniform(-4.0, 4.0), random.uniform(-4.0, 4.0)));
    }
    const Pose2 pose{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform()};
    insert_scan(scan, pose, tidy_options(), whole);
    insert_unrendered(scan, pose, tidy_options(), MapUse::kShown, unrendered);
    draw_occupancy(scan, pose, tidy_options(), MapUse::kShown, memory, occupancy);
  }
  unrendered.field.render();
  EXPECT_FALSE(whole.reflection.empty());
  EXPECT_FALSE(whole.field.empty());
  for (int y = -60; y < 60; ++y) {
    for (int x = -60; x < 60; ++x) {
      ASSERT_EQ(whole.occupancy.stored({x, y}), occupancy.stored({x, y})) << x << " " << y;
      ASSERT_EQ(whole.occupancy.stored({x, y}), unrendered.occupancy.stored({x, y}));
      ASSERT_EQ(whole.field.likelihood({x, y}), unrendered.field.likelihood({x, y}));
      const ReflectionGrid::Counts counts = whole.reflection.counts({x, y});
      ASSERT_EQ(counts.hits, unrendered.reflection.counts({x, y}).hits);
      ASSERT_EQ(counts.passes, unrendered.reflection.counts({x, y}).passes);
    }
  }
}

TEST(ScanInserter, AnEmptyScanChangesNothing) {
  SlamMap map = make_map();
  insert_scan({}, {1.0, 2.0, 3.0}, tidy_options(), map);
  EXPECT_TRUE(map.occupancy.known_bounds().empty());
  EXPECT_TRUE(map.field.empty());
}

TEST(ScanInserter, AHitAtTheLaserItselfIsFine) {
  SlamMap map = make_map();
  insert_scan(scan_of({hit(0.0, 0.0), hit(0.05, 0.0)}), {0.05, 0.05, 0.0}, tidy_options(), map);
  EXPECT_TRUE(map.occupancy.is_known({0, 0}));
}

TEST(ScanInserter, AMapOf100MetresSquareTakes100MegabytesAtMost) {
  // The worst building there is: clutter every 40 cm, so that nothing of the map stays unused.
  MapOptions options = tidy_options();
  options.resolution = 0.05;
  SlamMap map(options, LikelihoodFieldOptions{});
  PointScan scan;
  for (double y = -1.8; y < 2.0; y += 0.4) {
    for (double x = -1.8; x < 2.0; x += 0.4) {
      scan.points.push_back(hit(x, y));
    }
  }
  for (double y = 2.0; y < 100.0; y += 4.0) {
    for (double x = 2.0; x < 100.0; x += 4.0) {
      insert_scan(scan, {x, y, 0.0}, options, map);
    }
  }
  const CellBox bounds = map.occupancy.known_bounds();
  EXPECT_GE(bounds.width(), 1990);
  EXPECT_GE(bounds.height(), 1990);
  const double megabytes = static_cast<double>(map.occupancy.bytes() + map.field.bytes()) / 1e6;
  EXPECT_LE(megabytes, 100.0);
  EXPECT_GE(megabytes, 40.0) << "the test no longer fills the map";
}

}  // namespace
}  // namespace matchbox_slam
