#include <gtest/gtest.h>
#include <malloc.h>

#include <stdexcept>

#include "matchbox_slam/slam/key_scans.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulated_run.hpp"

namespace matchbox_slam {
namespace {

MeasuredScan scan_of(int beams) {
  LaserOptions laser;
  laser.beams = beams;
  const World world = make_rooms_world(7);
  const Pose2 pose = drive(world.route(), {}).pose(15.0);
  const PoseAtTime at_rest = [&](double /*stamp*/) { return pose; };
  return {simulate_scan(world, laser, at_rest, 0.0, 1).scan, laser.base_from_laser(), {}, {}};
}

TEST(KeyScans, AreNumberedAndCanBeMoved) {
  KeyScans scans;
  for (int i = 0; i < 5; ++i) {
    scans.add(scan_of(100), i % 2, {1.0 * i, 0.0, 0.0});
  }
  const KeyScans before = scans;
  scans.move(3, {7.0, 8.0, 0.5});
  ASSERT_EQ(scans.size(), 5U);
  EXPECT_EQ(scans.all()[3].scan->id(), 3U);
  EXPECT_EQ(scans.all()[3].scan->laser(), 1);
  EXPECT_EQ(scans.all()[3].map_from_base, (Pose2{7.0, 8.0, 0.5}));
  EXPECT_EQ(before.all()[3].map_from_base, (Pose2{3.0, 0.0, 0.0})) << "a copy has its own poses";
  EXPECT_EQ(before.all()[3].scan, scans.all()[3].scan);
  EXPECT_THROW(scans.move(5, {}), std::out_of_range);
}

TEST(KeyScans, AreNumberedAnewWhereSomeAreTakenOut) {
  KeyScans scans;
  for (int i = 0; i < 5; ++i) {
    scans.add(scan_of(100), i, {1.0 * i, 0.0, 0.0});
  }
  const KeyScans before = scans;
  scans.take_out({false, true, false, true, false});
  ASSERT_EQ(scans.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(scans.all()[i].scan->id(), i);
    EXPECT_EQ(scans.all()[i].scan->laser(), static_cast<int>(2 * i));
    EXPECT_EQ(scans.all()[i].map_from_base, before.all()[2 * i].map_from_base);
    EXPECT_EQ(scans.all()[i].scan->points()->points.size(),
              before.all()[2 * i].scan->points()->points.size());
  }
  EXPECT_EQ(before.all()[4].scan->id(), 4U) << "a copy has its own numbers";
  EXPECT_THROW(scans.take_out({false}), std::out_of_range);
}

TEST(KeyScans, TellTheNewestOldestFirst) {
  KeyScans scans;
  const auto newest = [&scans](std::size_t most) {
    PlacedScans some(7);  // of before
    scans.copy_newest(most, some);
    return some;
  };
  EXPECT_TRUE(newest(3).empty());
  for (int i = 0; i < 5; ++i) {
    scans.add(scan_of(100), 0, {});
  }
  ASSERT_EQ(newest(3).size(), 3U);
  EXPECT_EQ(newest(3).front().scan->id(), 2U);
  EXPECT_EQ(newest(100).size(), 5U);
}

/// [byte]
std::size_t heap_in_use() {
#if __GLIBC_PREREQ(2, 33)
  const auto heap = mallinfo2();
#else
  const auto heap = mallinfo();  // counts to 2 GB
#endif
  return static_cast<std::size_t>(heap.uordblks) + static_cast<std::size_t>(heap.hblkhd);
}

TEST(KeyScans, TakeAtMostSixKilobytesEach) {
  constexpr std::size_t kScans = 500;
  const MeasuredScan measured = scan_of(1040);
  KeyScans scans;
  const std::size_t before = heap_in_use();
  for (std::size_t i = 0; i < kScans; ++i) {
    scans.add(measured, 0, {});
  }
  const std::size_t each = (heap_in_use() - before) / kScans;
  RecordProperty("bytes", static_cast<int>(each));
  EXPECT_GT(each, sizeof(float) * 1040 / 2);
  EXPECT_LT(each, 3500U);  // 3.4 kB measured, of 6 allowed
  // With what is derived from them, not more than the bound of the cache.
  for (const PlacedScan& placed : scans.all()) {
    ASSERT_FALSE(placed.scan->field()->empty());
  }
  const std::size_t all = heap_in_use() - before;
  EXPECT_LT(all, kScans * each + (std::size_t{80} << 20U));
}

}  // namespace
}  // namespace matchbox_slam
