#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "simulation/scan_faults.hpp"

namespace matchbox_slam {
namespace {

LaserScan wall_at(float range, std::size_t beams) {
  LaserScan scan;
  scan.ranges.assign(beams, range);
  return scan;
}

std::ptrdiff_t count_changed(const LaserScan& scan, float range) {
  return std::count_if(scan.ranges.begin(), scan.ranges.end(), [&](float r) { return r != range; });
}

TEST(ScanFaults, AScanIsLostOnlyDuringADropout) {
  const std::vector<Fault> faults = {parse_fault("dropout:10:2"), parse_fault("covered:20:2")};
  EXPECT_FALSE(is_any_on(FaultKind::kDropout, 9.99, faults));
  EXPECT_TRUE(is_any_on(FaultKind::kDropout, 10.0, faults));
  EXPECT_TRUE(is_any_on(FaultKind::kDropout, 11.99, faults));
  EXPECT_FALSE(is_any_on(FaultKind::kDropout, 12.0, faults));
  EXPECT_FALSE(is_any_on(FaultKind::kDropout, 21.0, faults));
}

TEST(ScanFaults, ACoverHidesItsShareSideBySide) {
  LaserScan scan = wall_at(4.0F, 1000);
  add_scan_faults(10.5, {parse_fault("covered:10:1:0.3")}, 5, scan);
  EXPECT_EQ(count_changed(scan, 4.0F), 300);
  int edges = 0;
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    edges += scan.ranges[i] != scan.ranges[(i + 1) % scan.ranges.size()] ? 1 : 0;
  }
  EXPECT_EQ(edges, 2);
  EXPECT_FLOAT_EQ(*std::min_element(scan.ranges.begin(), scan.ranges.end()), 0.05F);
}

TEST(ScanFaults, OutsideOfTheirTimeNothingChanges) {
  LaserScan scan = wall_at(4.0F, 1000);
  add_scan_faults(9.0, {parse_fault("covered:10:1"), parse_fault("people:11:1")}, 5, scan);
  EXPECT_EQ(count_changed(scan, 4.0F), 0);
}

TEST(ScanFaults, PeopleHideAboutTheirShareAndMove) {
  const std::vector<Fault> faults = {parse_fault("people:10:20:0.3")};
  LaserScan first = wall_at(4.0F, 1000);
  LaserScan later = first;
  double hidden = 0.0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    LaserScan scan = wall_at(4.0F, 1000);
    add_scan_faults(15.0, faults, seed, scan);
    hidden += static_cast<double>(count_changed(scan, 4.0F)) / 50.0;
    for (const float range : scan.ranges) {
      EXPECT_TRUE(range == 4.0F || (range >= 0.0F && range <= 3.6F)) << range;
    }
  }
  // They hide each other at times.
  EXPECT_GT(hidden, 230.0);
  EXPECT_LE(hidden, 300.0);
  add_scan_faults(12.0, faults, 3, first);
  add_scan_faults(16.0, faults, 3, later);
  EXPECT_NE(first.ranges, later.ranges);
}

TEST(ScanFaults, ReadingsThatAreNoneStayNone) {
  LaserScan scan = wall_at(std::numeric_limits<float>::quiet_NaN(), 100);
  add_scan_faults(12.0, {parse_fault("people:10:20:1")}, 3, scan);
  EXPECT_TRUE(std::all_of(scan.ranges.begin(), scan.ranges.end(),
                          [](float range) { return std::isnan(range); }));
  LaserScan too_close = wall_at(-std::numeric_limits<float>::infinity(), 100);
  add_scan_faults(12.0, {parse_fault("people:10:20:1")}, 3, too_close);
  EXPECT_EQ(count_changed(too_close, -std::numeric_limits<float>::infinity()), 0);
  LaserScan empty;
  add_scan_faults(12.0, {parse_fault("people:10:20:1"), parse_fault("covered:10:20")}, 3, empty);
  EXPECT_TRUE(empty.ranges.empty());
}

}  // namespace
}  // namespace matchbox_slam
