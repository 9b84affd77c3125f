#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "matchbox_slam/geometry/angles.hpp"
#include "sensor/scan_joiner.hpp"

namespace matchbox_slam {
namespace {

constexpr double kTurnPeriod = 0.1;  // s, of a turn

/// A scan that reads the number of each beam.
LaserScan turn_of(std::size_t beams, double field, double stamp, double direction = 1.0) {
  LaserScan scan;
  scan.stamp = stamp;
  scan.angle_min = -direction * field / 2.0;
  scan.angle_increment = direction * field / static_cast<double>(beams);
  scan.time_increment = kTurnPeriod * (field / (2.0 * kPi)) / static_cast<double>(beams);
  scan.range_max = 1e6;
  for (std::size_t k = 0; k < beams; ++k) {
    scan.ranges.push_back(static_cast<float>(k));
  }
  return scan;
}

/// One after the other, by angle and by time.
std::vector<LaserScan> parts_of(const LaserScan& turn, std::size_t count) {
  std::vector<LaserScan> parts;
  const std::size_t beams = turn.ranges.size() / count;
  for (std::size_t first = 0; first < turn.ranges.size(); first += beams) {
    LaserScan part = turn;
    part.stamp = turn.stamp + static_cast<double>(first) * turn.time_increment;
    part.angle_min = wrap_angle(turn.angle_min + static_cast<double>(first) * turn.angle_increment);
    const auto begin = turn.ranges.begin() + static_cast<std::ptrdiff_t>(first);
    part.ranges.assign(begin, begin + static_cast<std::ptrdiff_t>(beams));
    parts.push_back(part);
  }
  return parts;
}

/// `count` turns in parts, one after the other.
std::vector<LaserScan> parts_of_turns(int turns, double field, std::size_t count,
                                      double direction = 1.0) {
  std::vector<LaserScan> parts;
  for (int turn = 0; turn < turns; ++turn) {
    for (const LaserScan& part :
         parts_of(turn_of(360, field, 10.0 + kTurnPeriod * turn, direction), count)) {
      parts.push_back(part);
    }
  }
  return parts;
}

std::vector<LaserScan> joined(ScanJoiner& joiner, const std::vector<LaserScan>& scans) {
  std::vector<LaserScan> whole;
  for (const LaserScan& scan : scans) {
    if (joiner.add(scan)) {
      whole.pop_back();
    }
    for (LaserScan& one : joiner.take()) {
      whole.push_back(one);
    }
  }
  return whole;
}

void expect_same(const LaserScan& scan, const LaserScan& turn) {
  EXPECT_EQ(scan.stamp, turn.stamp);
  EXPECT_NEAR(wrap_angle(scan.angle_min - turn.angle_min), 0.0, 1e-12);
  EXPECT_EQ(scan.angle_increment, turn.angle_increment);
  EXPECT_NEAR(scan.time_increment, turn.time_increment, 1e-9);
  EXPECT_EQ(scan.ranges, turn.ranges);
}

void expect_turns(double field, std::size_t count, double direction) {
  ScanJoiner joiner(std::nullopt);
  std::vector<LaserScan> parts = parts_of_turns(2, field, count, direction);
  parts.push_back(
      turn_of(360, field, 10.0 + 2.0 * kTurnPeriod, direction));  // which ends the second
  parts.back().ranges.resize(360U / count);
  const std::vector<LaserScan> whole = joined(joiner, parts);
  EXPECT_NE(joiner.take_news(), "");
  ASSERT_EQ(whole.size(), 2U);
  expect_same(whole[0], turn_of(360, field, 10.0, direction));
  expect_same(whole[1], turn_of(360, field, 10.0 + kTurnPeriod, direction));
  joined(joiner, parts_of(turn_of(360, field, 10.0 + 3.0 * kTurnPeriod, direction), count));
  EXPECT_EQ(joiner.take_news(), "") << "once";
}

TEST(ScanJoiner, MakesOfPartsTheTurnThatTheyAreOf) {
  ScanJoiner joiner(10);
  const LaserScan turn = turn_of(360, 2.0 * kPi, 10.0);
  const std::vector<LaserScan> whole = joined(joiner, parts_of(turn, 10));
  ASSERT_EQ(whole.size(), 1U);
  expect_same(whole.front(), turn);
  EXPECT_FALSE(joiner.holds_parts());
}

TEST(ScanJoiner, SeesThatTurnsComeInParts) {
  for (const double direction : {1.0, -1.0}) {
    SCOPED_TRACE(direction);
    expect_turns(2.0 * kPi, 10, direction);
    expect_turns(degrees_to_radians(276.0), 4, direction);
  }
}

TEST(ScanJoiner, TakesWholeTurnsFromAnyPartOn) {
  ScanJoiner joiner(std::nullopt);
  std::vector<LaserScan> parts = parts_of_turns(2, 2.0 * kPi, 10);
  parts.erase(parts.begin());
  const std::vector<LaserScan> whole = joined(joiner, parts);
  ASSERT_EQ(whole.size(), 1U);
  EXPECT_EQ(whole[0].stamp, parts[0].stamp);
  ASSERT_EQ(whole[0].ranges.size(), 360U);
  EXPECT_EQ(whole[0].ranges.front(), 36.0F);
  EXPECT_EQ(whole[0].ranges.back(), 35.0F);
}

TEST(ScanJoiner, LeavesBeamsOfAPartThatIsMissingUnknown) {
  ScanJoiner joiner(std::nullopt);
  std::vector<LaserScan> parts = parts_of_turns(2, 2.0 * kPi, 10);
  parts.erase(parts.begin() + 4);
  const std::vector<LaserScan> whole = joined(joiner, parts);
  ASSERT_EQ(whole.size(), 2U);
  for (const std::size_t turn : {0U, 1U}) {
    ASSERT_EQ(whole[turn].ranges.size(), 360U);
    for (std::size_t beam = 0; beam < 360; ++beam) {
      EXPECT_EQ(std::isnan(whole[turn].ranges[beam]), turn == 0 && beam >= 144 && beam < 180)
          << beam;
    }
  }
}

TEST(ScanJoiner, BeginsAnewWhereTheLastPartsOfATurnAreMissing) {
  ScanJoiner joiner(10);
  std::vector<LaserScan> parts = parts_of(turn_of(360, 2.0 * kPi, 10.0), 10);
  parts.pop_back();
  const LaserScan next = turn_of(360, 2.0 * kPi, 10.1);
  for (const LaserScan& part : parts_of(next, 10)) {
    parts.push_back(part);
  }
  const std::vector<LaserScan> whole = joined(joiner, parts);
  ASSERT_EQ(whole.size(), 2U);
  EXPECT_EQ(whole[0].ranges.size(), 324U);
  expect_same(whole[1], next);
}

TEST(ScanJoiner, LeavesWholeScansAlone) {
  for (const double field : {2.0 * kPi, degrees_to_radians(270.0), degrees_to_radians(57.0)}) {
    ScanJoiner joiner(std::nullopt);
    const std::vector<LaserScan> scans = {turn_of(360, field, 10.0), turn_of(360, field, 10.1),
                                          turn_of(360, field, 10.2)};
    const std::vector<LaserScan> whole = joined(joiner, scans);
    ASSERT_EQ(whole.size(), 3U);
    for (const std::size_t k : {0U, 1U, 2U}) {
      expect_same(whole[k], scans[k]);
    }
    EXPECT_EQ(joiner.take_news(), "");
  }
}

TEST(ScanJoiner, IsUndecidedBetweenTheFirstAndTheSecond) {
  const LaserScan scan = turn_of(360, degrees_to_radians(270.0), 10.0);
  ScanJoiner joiner(std::nullopt);
  EXPECT_FALSE(joiner.is_undecided());
  EXPECT_EQ(joined(joiner, {scan}).size(), 1U);
  EXPECT_TRUE(joiner.is_undecided());
  EXPECT_EQ(joined(joiner, {turn_of(360, degrees_to_radians(270.0), 10.1)}).size(), 1U);
  EXPECT_FALSE(joiner.is_undecided());
  ScanJoiner of_turns(std::nullopt);
  EXPECT_EQ(joined(of_turns, {turn_of(360, 2.0 * kPi, 10.0)}).size(), 1U);
  EXPECT_FALSE(of_turns.is_undecided()) << "a full circle is no part";
  ScanJoiner told(1);
  EXPECT_EQ(joined(told, {scan}).size(), 1U);
  EXPECT_FALSE(told.is_undecided());
}

TEST(ScanJoiner, SeesPartsAfterAGapBehindTheFirstScan) {
  ScanJoiner joiner(std::nullopt);
  std::vector<LaserScan> scans = {parts_of(turn_of(360, 2.0 * kPi, 9.0), 4).front()};
  const std::vector<LaserScan> parts = parts_of_turns(3, 2.0 * kPi, 4);
  scans.insert(scans.end(), parts.begin(), parts.end());
  const std::vector<LaserScan> whole = joined(joiner, scans);
  ASSERT_EQ(whole.size(), 4U);
  EXPECT_EQ(whole.front().ranges.size(), 90U);
  expect_same(whole.back(), turn_of(360, 2.0 * kPi, 10.0 + 2.0 * kTurnPeriod));
}

TEST(ScanJoiner, ASlowLaserIsWatchedForTwoScansMore) {
  ScanJoiner joiner(std::nullopt);
  for (int k = 0; k < 4; ++k) {
    static_cast<void>(joiner.add(turn_of(180, kPi, 10.0 + k)));
    EXPECT_EQ(joiner.is_undecided(), k < 2) << k;
    EXPECT_EQ(joiner.take().size(), 1U);
  }
}

TEST(ScanJoiner, SaysOnceThatScansDoNotGoOnAsPartsDo) {
  ScanJoiner joiner(4);
  for (int k = 0; k < 30; ++k) {
    static_cast<void>(joiner.add(turn_of(180, kPi, 10.0 + 0.1 * k)));
    EXPECT_EQ(joiner.take_news().find("scan/join_parts is 4") == 0, k == 10) << k;
  }
}

TEST(ScanJoiner, JoinsNoneOfOne) {
  ScanJoiner joiner(1);
  EXPECT_EQ(joined(joiner, parts_of(turn_of(360, 2.0 * kPi, 10.0), 10)).size(), 10U);
}

TEST(ScanJoiner, GivesWhatThereIsAtTheEnd) {
  ScanJoiner joiner(10);
  std::vector<LaserScan> parts = parts_of(turn_of(360, 2.0 * kPi, 10.0), 10);
  parts.resize(3);
  EXPECT_EQ(joined(joiner, parts).size(), 0U);
  EXPECT_TRUE(joiner.holds_parts());
  joiner.finish();
  const std::vector<LaserScan> rest = joiner.take();
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_EQ(rest.front().ranges.size(), 108U);
}

TEST(ScanJoiner, BegunAnewItSeesWhetherPartsComeAsAtFirst) {
  ScanJoiner joiner(std::nullopt);
  const std::vector<LaserScan> parts = parts_of_turns(2, 2.0 * kPi, 10);
  joined(joiner, parts);
  joiner.begin_anew();
  EXPECT_FALSE(joiner.holds_parts());
  EXPECT_TRUE(joiner.take().empty());
  EXPECT_EQ(joiner.take_news(), "");
  ScanJoiner first(std::nullopt);
  EXPECT_EQ(joined(joiner, parts).size(), joined(first, parts).size());
  EXPECT_EQ(joiner.take_news(), first.take_news());
}

}  // namespace
}  // namespace matchbox_slam
