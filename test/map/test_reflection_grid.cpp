#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <utility>
#include <vector>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/map/reflection_grid.hpp"

namespace matchbox_slam {
namespace {

using Counts = ReflectionGrid::Counts;

constexpr double kResolution = 0.05;

bool operator==(const Counts& a, const Counts& b) {
  return a.hits == b.hits && a.passes == b.passes;
}

/// Head-on, from the middle of cell (0, 0).
ScanPoint beam_to(double x, double y) {
  ScanPoint point;
  point.origin = {0.025, 0.025};
  point.position = {x, y};
  point.normal = (point.origin - point.position).normalized();
  point.weight = 0.1;
  return point;
}

PointScan scan_of_beams(std::vector<ScanPoint> points) {
  PointScan scan;
  scan.points = std::move(points);
  return scan;
}

/// Of what is in cell (40, 0), and in cell (60, 0) behind it.
PointScan wall() { return scan_of_beams({beam_to(2.025, 0.025)}); }
PointScan beyond() { return scan_of_beams({beam_to(3.025, 0.025)}); }

/// The scan some times, from the origin.
void count(const PointScan& scan, int times, ReflectionGrid& grid) {
  for (int i = 0; i < times; ++i) {
    grid.count(scan, {});
  }
}

double hit_share(const Counts& counts) {
  return static_cast<double>(counts.hits) / (counts.hits + counts.passes);
}

/// In a box around all that the tests see.
bool are_equal(const ReflectionGrid& a, const ReflectionGrid& b) {
  for (int y = -250; y < 250; ++y) {
    for (int x = -250; x < 250; ++x) {
      if (!(a.counts({x, y}) == b.counts({x, y}))) {
        return false;
      }
    }
  }
  return true;
}

PointScan random_scan(Random& random, int beams) {
  std::vector<ScanPoint> points;
  for (int i = 0; i < beams; ++i) {
    points.push_back(beam_to(random.uniform(-5.0, 5.0), random.uniform(-5.0, 5.0)));
  }
  return scan_of_beams(points);
}

TEST(ReflectionGrid, KnowsNothingAtFirst) {
  const ReflectionGrid grid(kResolution);
  EXPECT_TRUE(grid.empty());
  EXPECT_EQ(grid.geometry().resolution(), kResolution);
  EXPECT_FALSE(grid.counts({0, 0}).is_known());
}

TEST(ReflectionGrid, AnEmptyScanCountsNowhere) {
  ReflectionGrid grid(kResolution);
  grid.count(PointScan{}, {1.0, 2.0, 3.0});
  EXPECT_TRUE(grid.empty());
}

TEST(ReflectionGrid, ABeamPassesAllCellsUpToItsClearanceAndHitsItsLast) {
  for (const int scans : {1, 2, 7, 24}) {
    ReflectionGrid grid(kResolution);
    count(wall(), scans, grid);
    const int all = ReflectionGrid::kScan * scans;
    for (int x = -5; x < 50; ++x) {
      const int passes = x >= 0 && x < 38 ? all : 0;  // 0.1 m, two cells, before its end
      EXPECT_EQ(grid.counts({x, 0}).passes, passes) << x;
      EXPECT_EQ(grid.counts({x, 0}).hits, x == 40 ? all : 0) << x;
      EXPECT_FALSE(grid.counts({x, 1}).is_known()) << x;
      EXPECT_FALSE(grid.counts({x, -1}).is_known()) << x;
    }
  }
}

TEST(ReflectionGrid, PoseOfTheBaseIsApplied) {
  ReflectionGrid grid(kResolution);
  grid.count(scan_of_beams({beam_to(2.025, 0.025)}), {1.0, -0.5, 0.5 * kPi});
  EXPECT_TRUE(grid.counts({19, 30}) == (Counts{4, 0}));  // (-0.025, 2.025) from (1, -0.5)
  EXPECT_TRUE(grid.counts({19, 27}) == (Counts{0, 4}));
  EXPECT_TRUE(grid.counts({19, -10}) == (Counts{0, 4}));
  EXPECT_FALSE(grid.counts({40, 0}).is_known());
}

TEST(ReflectionGrid, AScanCountsOnceHoweverManyBeamsEndInACell) {
  for (const int beams : {1, 3, 100, 256, 359, 2000}) {
    ReflectionGrid grid(kResolution);
    grid.count(
        scan_of_beams(std::vector<ScanPoint>(static_cast<std::size_t>(beams), beam_to(2.025, 0))),
        {});
    EXPECT_TRUE(grid.counts({40, 0}) == (Counts{4, 0})) << beams;
    EXPECT_TRUE(grid.counts({0, 0}) == (Counts{0, 4})) << beams;
  }
}

TEST(ReflectionGrid, AScanCountsForBothByTheShareOfItsBeams) {
  const ScanPoint hit = beam_to(2.025, 0.025);
  const ScanPoint pass = beam_to(3.025, 0.025);
  const auto counted = [](const std::vector<ScanPoint>& points) {
    ReflectionGrid grid(kResolution);
    grid.count(scan_of_beams(points), {});
    return grid.counts({40, 0});
  };
  EXPECT_TRUE(counted({hit, pass}) == (Counts{2, 2}));
  EXPECT_TRUE(counted({pass, hit}) == (Counts{2, 2}));
  EXPECT_TRUE(counted({hit, pass, pass, pass}) == (Counts{1, 3}));
  EXPECT_TRUE(counted({hit, hit, hit, pass}) == (Counts{3, 1}));
}

TEST(ReflectionGrid, BeamsWithoutReturnCountNowhere) {
  ReflectionGrid grid(kResolution);
  PointScan scan;
  scan.free_rays.push_back({{0.0, 0.0}, {5.0, 0.0}});
  grid.count(scan, {});
  EXPECT_TRUE(grid.empty());
}

TEST(ReflectionGrid, BeamsThatGrazeAWallDoNotPassIt) {
  ReflectionGrid grid(kResolution);
  std::vector<ScanPoint> points;
  for (double x = 0.3; x < 8.0; x += 0.02) {
    points.push_back(beam_to(x, 0.625));
    points.back().normal = {0.0, -1.0};
  }
  count(scan_of_beams(points), 10, grid);
  // As far as the clearance is less than its most: 0.08 m perpendicular to the wall.
  for (int x = 8; x < 140; ++x) {
    const Counts counts = grid.counts({x, 12});
    EXPECT_EQ(counts.passes, 0) << x;
  }
}

TEST(ReflectionGrid, ARailingStaysHalfHoweverOftenItIsSeen) {
  // Fifty parallel beams, two cells apart, of which every second one passes.
  ReflectionGrid grid(kResolution);
  for (int scan = 0; scan < 50; ++scan) {
    std::vector<ScanPoint> points;
    for (int i = 0; i < 50; ++i) {
      const double y = 0.1 * (i - 25) + 0.025;
      points.push_back(beam_to((i + scan) % 2 == 0 ? 2.025 : 3.025, y));
      points.back().origin.y() = y;
      points.back().normal = {-1.0, 0.0};
    }
    grid.count(scan_of_beams(points), {});
  }
  for (int i = 0; i < 50; ++i) {
    const Counts counts = grid.counts({40, 2 * (i - 25)});
    EXPECT_EQ(counts.hits + counts.passes, ReflectionGrid::kMaxCount) << i;
    EXPECT_NEAR(hit_share(counts), 0.5, 0.1) << i;
  }
}

TEST(ReflectionGrid, CountsTheShareOfBeamsThatPassByChance) {
  Random random(5);
  for (const double passing : {0.25, 0.5, 0.75}) {
    ReflectionGrid grid(kResolution);
    double sum = 0.0;
    int looks = 0;
    for (int scan = 0; scan < 2000; ++scan) {
      grid.count(random.uniform() < passing ? beyond() : wall(), {});
      if (scan >= 50) {
        sum += hit_share(grid.counts({40, 0}));
        ++looks;
      }
    }
    EXPECT_NEAR(sum / looks, 1.0 - passing, 0.08) << passing;
  }
}

TEST(ReflectionGrid, CountsSaturateAtTheirMost) {
  ReflectionGrid grid(kResolution);
  count(wall(), 24, grid);
  EXPECT_TRUE(grid.counts({40, 0}) == (Counts{ReflectionGrid::kMaxCount, 0}));
  EXPECT_TRUE(grid.counts({20, 0}) == (Counts{0, ReflectionGrid::kMaxCount}));
  count(wall(), 200, grid);
  EXPECT_TRUE(grid.counts({40, 0}) == (Counts{ReflectionGrid::kMaxCount, 0}));
  EXPECT_TRUE(grid.counts({20, 0}) == (Counts{0, ReflectionGrid::kMaxCount}));
}

TEST(ReflectionGrid, HitsAndPassesTogetherAreNeverMoreThanTheirMost) {
  Random random(11);
  ReflectionGrid grid(kResolution);
  int known = 0;
  for (int scan = 0; scan < 300; ++scan) {
    std::vector<ScanPoint> points;
    for (int i = 0; i < 5; ++i) {
      points.push_back(beam_to(random.uniform(0.5, 3.0), 0.025));
    }
    const auto before = grid;
    grid.count(scan_of_beams(points), {});
    for (int x = 0; x < 61; ++x) {
      const Counts counts = grid.counts({x, 0});
      const Counts old = before.counts({x, 0});
      known += counts.is_known() ? 1 : 0;
      ASSERT_LE(counts.hits + counts.passes, ReflectionGrid::kMaxCount) << x;
      ASSERT_GE(counts.hits + counts.passes, old.hits + old.passes) << x;
    }
  }
  EXPECT_GT(known, 15000);
}

TEST(ReflectionGrid, AWallThatGoesIsSoonMostlyPasses) {
  ReflectionGrid grid(kResolution);
  count(wall(), 100, grid);
  int scans = 0;
  for (; hit_share(grid.counts({40, 0})) > 0.5; ++scans) {
    ASSERT_LT(scans, 100);
    count(beyond(), 1, grid);
  }
  EXPECT_GE(scans, 10) << "not by a single person that hides it";
  EXPECT_LE(scans, 24);
  count(beyond(), 100, grid);
  EXPECT_LT(hit_share(grid.counts({40, 0})), 0.02);
}

TEST(ReflectionGrid, AWallThatComesIsSoonMostlyHits) {
  ReflectionGrid grid(kResolution);
  count(beyond(), 100, grid);
  count(wall(), 24, grid);
  EXPECT_GT(hit_share(grid.counts({40, 0})), 0.5);
  count(wall(), 100, grid);
  EXPECT_GT(hit_share(grid.counts({40, 0})), 0.98);
}

TEST(ReflectionGrid, CopiesAreIndependent) {
  ReflectionGrid grid(kResolution);
  count(wall(), 2, grid);
  ReflectionGrid copy(grid);
  ReflectionGrid assigned(kResolution);
  assigned = grid;
  count(wall(), 1, grid);
  count(beyond(), 1, copy);
  EXPECT_TRUE(grid.counts({40, 0}) == (Counts{12, 0}));
  EXPECT_TRUE(copy.counts({40, 0}) == (Counts{8, 4}));
  EXPECT_TRUE(assigned.counts({40, 0}) == (Counts{8, 0}));
  EXPECT_FALSE(grid.counts({60, 0}).is_known());
}

TEST(ReflectionGrid, CountsOnWhereItWasMovedTo) {
  ReflectionGrid grid(kResolution);
  count(wall(), 2, grid);
  ReflectionGrid moved(std::move(grid));
  count(wall(), 1, moved);
  EXPECT_TRUE(moved.counts({40, 0}) == (Counts{12, 0}));
  ReflectionGrid assigned(kResolution);
  assigned = std::move(moved);
  count(wall(), 1, assigned);
  EXPECT_TRUE(assigned.counts({40, 0}) == (Counts{16, 0}));
}

TEST(ReflectionGrid, TheSameScansGiveTheSameBitsWhateverWasCountedBefore) {
  Random random(7);
  ReflectionGrid grid(kResolution);
  for (int i = 0; i < 20; ++i) {
    const PointScan scan = random_scan(random, i % 3 == 0 ? 700 : 20);
    const Pose2 pose{random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0),
                     random.uniform(-kPi, kPi)};
    ReflectionGrid copy(grid);  // without what the other one works in
    grid.count(scan, pose);
    copy.count(scan, pose);
    ASSERT_TRUE(are_equal(grid, copy)) << i;
  }
}

/// The same cell by cell, as it is said.
class CellByCell {
 public:
  void count(const PointScan& scan, const Pose2& pose) {
    const GridGeometry geometry(kResolution);
    std::map<std::pair<int, int>, std::pair<int, int>> seen;  // hits and passes
    for (const ScanPoint& point : scan.points) {
      const Eigen::Vector2d from = pose * point.origin;
      const Eigen::Vector2d to = pose * point.position;
      const double range = (to - from).norm();
      const double share = std::max(0.0, 1.0 - clearance_of(point) / range);
      walk_cells(geometry.cell_at(from), geometry.cell_at(from + share * (to - from)),
                 [&](const Cell& cell) {
                   ++seen[{cell.x, cell.y}].second;
                 });
      const Cell end = geometry.cell_at(to);
      ++seen[{end.x, end.y}].first;
    }
    for (const auto& [cell, beams] : seen) {
      take(std::min(255, beams.first), std::min(255, beams.second), counts_[cell]);
    }
  }

  [[nodiscard]] Counts counts(int x, int y) const {
    const auto found = counts_.find({x, y});
    return found == counts_.end() ? Counts{} : found->second;
  }

 private:
  static void take(int seen_hits, int seen_passes, Counts& counts) {
    constexpr int kScan = ReflectionGrid::kScan;
    constexpr int kMaxCount = ReflectionGrid::kMaxCount;
    const int beams = seen_hits + seen_passes;
    const int hits = (kScan * seen_hits + beams / 2) / beams;
    int all_hits = counts.hits + hits;
    int all_passes = counts.passes + kScan - hits;
    if (const int all = all_hits + all_passes; all > kMaxCount) {
      all_hits = (all_hits * kMaxCount + all / 2) / all;
      const bool keeps_hits = hits == 0 && all_hits > 0 && all_hits == counts.hits;
      const bool keeps_passes =
          hits == kScan && all_hits < kMaxCount && kMaxCount - all_hits == counts.passes;
      all_hits += (keeps_passes ? 1 : 0) - (keeps_hits ? 1 : 0);
      all_passes = kMaxCount - all_hits;
    }
    counts = {static_cast<std::uint8_t>(all_hits), static_cast<std::uint8_t>(all_passes)};
  }

  std::map<std::pair<int, int>, Counts> counts_;
};

TEST(ReflectionGrid, CountsAsCellByCell) {
  // Around one place, so that cells are full and see beams in all proportions.
  Random random(13);
  ReflectionGrid grid(kResolution);
  CellByCell oracle;
  for (int i = 0; i < 400; ++i) {
    PointScan scan = random_scan(random, 40);
    for (ScanPoint& point : scan.points) {
      point.position *= random.uniform(0.02, 1.0);
    }
    const Pose2 pose{random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2),
                     random.uniform(-kPi, kPi)};
    grid.count(scan, pose);
    oracle.count(scan, pose);
  }
  int full = 0;
  for (int y = -150; y < 150; ++y) {
    for (int x = -150; x < 150; ++x) {
      const Counts counts = grid.counts({x, y});
      ASSERT_TRUE(counts == oracle.counts(x, y)) << x << " " << y;
      full += counts.hits > 0 && counts.hits + counts.passes == ReflectionGrid::kMaxCount ? 1 : 0;
    }
  }
  EXPECT_GT(full, 900);
}

TEST(ReflectionGrid, TheOrderOfTheBeamsDoesNotMatter) {
  Random random(8);
  PointScan scan = random_scan(random, 360);
  ReflectionGrid grid(kResolution);
  grid.count(scan, {0.3, 0.2, 0.1});
  std::reverse(scan.points.begin(), scan.points.end());
  ReflectionGrid reversed(kResolution);
  reversed.count(scan, {0.3, 0.2, 0.1});
  EXPECT_TRUE(are_equal(grid, reversed));
}

TEST(ReflectionGrid, CountsTheCellsOfAMapAsIfAFewScansHadSeenThem) {
  OccupancyGrid occupancy(kResolution);
  occupancy.blend({3, -2}, 1.0, 0.9);
  occupancy.blend({100, 70}, 0.0, 0.9);
  occupancy.blend({5, 5}, 0.4, 1.0);
  ReflectionGrid grid(kResolution);
  grid.count(occupancy);
  EXPECT_TRUE(grid.counts({3, -2}) == (Counts{32, 0}));
  EXPECT_TRUE(grid.counts({100, 70}) == (Counts{0, 32}));
  EXPECT_TRUE(grid.counts({5, 5}) == (Counts{0, 32}));
  EXPECT_FALSE(grid.counts({4, -2}).is_known());
  EXPECT_FALSE(grid.counts({50, 30}).is_known());
}

TEST(ReflectionGrid, AnEmptyMapCountsNowhere) {
  ReflectionGrid grid(kResolution);
  grid.count(OccupancyGrid(kResolution));
  EXPECT_TRUE(grid.empty());
}

TEST(ReflectionGrid, ScansGoOnFromAMap) {
  OccupancyGrid occupancy(kResolution);
  occupancy.blend({40, 0}, 1.0, 1.0);
  ReflectionGrid grid(kResolution);
  grid.count(occupancy);
  count(beyond(), 8, grid);
  EXPECT_TRUE(grid.counts({40, 0}) == (Counts{32, 32}));
}

ScanPoint beam_at_angle(double off_normal, double range = 5.0) {
  ScanPoint point;
  point.origin = {1.0, 2.0};
  point.position = point.origin + range * Eigen::Vector2d(1.0, 0.0);
  point.normal = {-std::cos(off_normal), std::sin(off_normal)};
  return point;
}

TEST(ClearanceOf, IsLeastHeadOnAndGrowsTheMoreABeamGrazes) {
  EXPECT_NEAR(clearance_of(beam_at_angle(0.0)), 0.1, 1e-12);
  EXPECT_NEAR(clearance_of(beam_at_angle(degrees_to_radians(60.0))), 0.16, 1e-12);
  EXPECT_NEAR(clearance_of(beam_at_angle(-degrees_to_radians(60.0))), 0.16, 1e-12);
  EXPECT_NEAR(clearance_of(beam_at_angle(std::acos(0.1))), 0.8, 1e-12);
  EXPECT_NEAR(clearance_of(beam_at_angle(degrees_to_radians(89.0))), 1.0, 1e-12);
  double before = 0.0;
  for (double angle = 0.0; angle < 0.5 * kPi; angle += 0.01) {
    const double clearance = clearance_of(beam_at_angle(angle));
    EXPECT_GE(clearance, before) << angle;
    EXPECT_LE(clearance, 1.0) << angle;
    before = clearance;
  }
}

TEST(ClearanceOf, DoesNotDependOnTheRange) {
  for (const double range : {0.5, 2.0, 30.0}) {
    EXPECT_NEAR(clearance_of(beam_at_angle(1.2, range)), 0.08 / std::cos(1.2), 1e-12) << range;
  }
}

TEST(ClearanceOf, IsInBetweenWhereNoSurfaceIsKnown) {
  ScanPoint point = beam_at_angle(0.0);
  point.normal.setZero();
  EXPECT_EQ(clearance_of(point), 0.3);
  point.position = point.origin;
  EXPECT_EQ(clearance_of(point), 0.3);
}

std::vector<Cell> walked(const Cell& from, const Cell& to) {
  std::vector<Cell> cells;
  walk_cells(from, to, [&](const Cell& cell) { cells.push_back(cell); });
  return cells;
}

TEST(WalkCells, NowhereVisitsNothing) { EXPECT_TRUE(walked({3, -4}, {3, -4}).empty()); }

TEST(WalkCells, VisitsALineOfNeighboursFromTheFirstCellUpToTheLast) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const auto any = [&] { return static_cast<int>(random.uniform(-30.0, 31.0)); };
    const Cell from{any(), any()};
    const Cell to{any(), any()};
    const std::vector<Cell> cells = walked(from, to);
    const int dx = to.x - from.x;
    const int dy = to.y - from.y;
    const int length = std::max(std::abs(dx), std::abs(dy));
    ASSERT_EQ(cells.size(), static_cast<std::size_t>(length));
    for (int k = 0; k < length; ++k) {
      const Cell& cell = cells[static_cast<std::size_t>(k)];
      // A step a cell along the longer side, and beside the line by half a cell at most.
      const double share = static_cast<double>(k) / length;
      ASSERT_LE(std::abs(cell.x - from.x - share * dx), 0.5 + 1e-9);
      ASSERT_LE(std::abs(cell.y - from.y - share * dy), 0.5 + 1e-9);
      ASSERT_EQ(std::max(std::abs(cell.x - from.x), std::abs(cell.y - from.y)), k);
      const Cell& next = k + 1 < length ? cells[static_cast<std::size_t>(k) + 1] : to;
      ASSERT_EQ(std::max(std::abs(next.x - cell.x), std::abs(next.y - cell.y)), 1);
    }
  }
}

TEST(WalkCells, GoesStraightAlongRowsColumnsAndDiagonals) {
  EXPECT_EQ(walked({0, 0}, {3, 0}), (std::vector<Cell>{{0, 0}, {1, 0}, {2, 0}}));
  EXPECT_EQ(walked({0, 0}, {0, -2}), (std::vector<Cell>{{0, 0}, {0, -1}}));
  EXPECT_EQ(walked({1, 1}, {-1, 3}), (std::vector<Cell>{{1, 1}, {0, 2}}));
}

}  // namespace
}  // namespace matchbox_slam
