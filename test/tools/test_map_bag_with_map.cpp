// Of tools/bag_mapper.hpp: maps that are gone on with, and that the robot is searched in.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>

#include "bag/simulated_bag.hpp"
#include "common/error_text.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "ros/messages.hpp"
#include "ros/scan_types.hpp"
#include "simulation/make_world.hpp"
#include "tools/map_bag_run.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

std::string last_lines(const std::string& text, std::size_t lines) {
  std::size_t at = text.size();
  for (; lines > 0; --lines) {
    at = text.rfind('\n', at - 2) + 1;
  }
  return text.substr(at);
}

TEST_F(MapBag, OfTheMapOfAnotherBuildingItSaysThatTheRobotWasNotFoundThere) {
  const auto simulate = [this](const std::string& world) {
    std::string bag = folder_ / "drive.bag";
    const std::string options = " --duration 20 --scan-rate 5 --beams 360 --bag " + bag;
    EXPECT_EQ(run_command(MATCHBOX_SIMULATE,
                          "--world " + world + options + " --truth " + (folder_ / "truth.tum"))
                  .exit_code,
              0);
    return bag;
  };
  const std::string there = folder_ / "there";
  ASSERT_EQ(run_command(MATCHBOX_MAP_BAG, simulate("atrium") + " --out " + there).exit_code, 0);
  const std::string drive = simulate("rooms");
  const Outcome outcome =
      run_command(MATCHBOX_MAP_BAG, drive + " --out " + out_ + " --map " + there + "/map.slam");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "the robot lost at 10")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "the robot was hardly ever found in " + there + "/map.slam"))
      << outcome.output;
}

TEST_F(MapBag, GoesOnWithItsMapAsIfItHadNeverStopped) {
  const std::string every = " --set slam/insert_distance=0 --set slam/insert_angle=0";
  for (const std::string matcher : {"olson", "hough", "monte_carlo"}) {
    for (const std::string odometry : {"", " --no-odom"}) {
      const std::string options = "--matcher " + matcher + odometry + every;
      ASSERT_EQ(run_small({}, options).exit_code, 0);
      const std::string whole = read_file(out_ + "/trajectory.tum");
      const std::string map = read_file(out_ + "/map.pgm");
      const std::string saved = read_file(out_ + "/map.slam");
      SmallBag half;
      half.scans = 25;
      ASSERT_EQ(run_small(half, options).exit_code, 0);
      const std::string old = folder_ / "old.slam";
      std::filesystem::copy_file(out_ + "/map.slam", old,
                                 std::filesystem::copy_options::overwrite_existing);
      SmallBag rest;
      rest.first_scan = 25;
      const Outcome outcome = run_small(rest, options + " --map " + old);
      ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
      EXPECT_TRUE(contains(outcome.output, "whose drive goes on")) << outcome.output;
      EXPECT_TRUE(contains(outcome.output, "25 of 25 scans used, 25 matched")) << outcome.output;
      EXPECT_EQ(last_lines(read_file(out_ + "/trajectory.tum"), 25), last_lines(whole, 25))
          << options;
      EXPECT_TRUE(read_file(out_ + "/map.pgm") == map) << options;
      EXPECT_TRUE(read_file(out_ + "/map.slam") == saved) << options;
    }
  }
}

TEST_F(MapBag, TheFolderOfTheMapIsNotWrittenOverUnasked) {
  write_small_bag(bag_);
  ASSERT_EQ(run("--duration 2").exit_code, 0);
  const std::string map = read_file(out_ + "/map.slam");
  const Outcome refused = run("--start 2.1 --map " + out_ + "/map.slam");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_TRUE(contains(refused.output, "--out: '" + out_ + "' is the folder of " + out_ +
                                           "/map.slam, which would be written over; give another "
                                           "--out, or --overwrite"))
      << refused.output;
  EXPECT_EQ(read_file(out_ + "/map.slam"), map);
  const Outcome asked = run("--start 2.1 --overwrite --map " + out_ + "/map.slam");
  EXPECT_EQ(asked.exit_code, 0) << asked.output;
  const std::string first_line =
      "# Of this drive alone, in the frame of the map that it went on "
      "with: " +
      out_ + "/map.slam\n";
  EXPECT_EQ(read_file(out_ + "/trajectory.tum").substr(0, first_line.size()), first_line);
  EXPECT_EQ(read_file(out_ + "/odometry.tum").substr(0, 1), "1") << "which is in no map";
  EXPECT_TRUE(contains(read_file(out_ + "/key_scans.tum"), "# Of the whole map"));
}

TEST_F(MapBag, ARobotAtRestGetsFreeGround) {
  SmallBag recipe;
  write_small_bag(bag_, recipe);
  ASSERT_EQ(run("").exit_code, 0);
  const MapImage map = read_map(out_ + "/map.yaml");
  int free = 0;
  int occupied = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      free += map.state({x, y}) == CellState::kFree ? 1 : 0;
      occupied += map.state({x, y}) == CellState::kOccupied ? 1 : 0;
    }
  }
  EXPECT_GT(free, 1000);  // of 16 m^2 with a blind sector
  EXPECT_GT(occupied, 100);
}

TEST_F(MapBag, ScansThatANodeHadNoTimeForAreLeftOutAgain) {
  write_small_bag(bag_);
  const std::string events = folder_ / "events.yaml";
  replace_file(events,
               "- scan: 1001.0\n  leave_out: true\n- scan: 1001.05\n  leave_out: true\n"
               "- scan: 1002.0\n  leave_out: true\n");
  const Outcome outcome = run("--events " + events);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(poses(), 48U) << "that of 1001.05 was never there";
  EXPECT_EQ(report("scans/skipped/too_late"), 2.0);
  const Trajectory trajectory = read_tum(out_ + "/trajectory.tum");
  for (const StampedPose2& pose : trajectory.poses()) {
    EXPECT_NE(pose.stamp, 1001.0);
    EXPECT_NE(pose.stamp, 1002.0);
  }
}

TEST_F(MapBag, LocalisesInItsMapWithoutChangingIt) {
  const std::string every = "--set slam/insert_distance=0 --set slam/insert_angle=0 ";
  ASSERT_EQ(run_small({}, every).exit_code, 0);
  const std::vector<StampedPose2> whole = read_tum(out_ + "/trajectory.tum").poses();
  SmallBag half;
  half.scans = 25;
  ASSERT_EQ(run_small(half, every).exit_code, 0);
  const std::string old = folder_ / "old.slam";
  std::filesystem::copy_file(out_ + "/map.slam", old);
  const std::string map = read_file(out_ + "/map.pgm");
  SmallBag rest;
  rest.first_scan = 25;
  const Outcome outcome = run_small(rest, every + "--set slam/update_map=false --map " + old);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "25 of 25 scans used, 25 matched")) << outcome.output;
  EXPECT_TRUE(read_file(out_ + "/map.pgm") == map);
  EXPECT_TRUE(std::filesystem::exists(out_ + "/map.slam"));
  const std::vector<StampedPose2> located = read_tum(out_ + "/trajectory.tum").poses();
  ASSERT_EQ(located.size(), 25U);
  for (std::size_t i = 0; i < located.size(); ++i) {
    EXPECT_LT(difference(located[i].pose, whole[25 + i].pose).norm(), 0.01) << i;
  }
}

TEST_F(MapBag, ARobotOfAnotherDriveIsLostUntilItMoves) {
  ASSERT_EQ(run_small({}).exit_code, 0);
  const std::string old = folder_ / "old.slam";
  std::filesystem::copy_file(out_ + "/map.slam", old);
  const std::string map = read_file(out_ + "/map.pgm");
  for (const double begin : {500.0, 2000.0}) {
    SmallBag other;
    other.begin = begin;
    const Outcome outcome = run_small(other, "--map " + old);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(contains(outcome.output,
                         "old.slam; this is another drive, as its first scan is " +
                             std::string(begin < 1000.0 ? "504.900 s older" : "995.100 s newer") +
                             " than the last one of the map: the robot is searched"))
        << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "found nowhere in the map: 1; ")) << outcome.output;
    EXPECT_TRUE(read_file(out_ + "/map.pgm") == map);
    EXPECT_EQ(report("scans/state/lost"), 50.0);
    EXPECT_GT(report("scans/inserted"), 0.0);
  }
  ASSERT_EQ(run("--set slam/update_map=false --map " + old).exit_code, 0);
  EXPECT_EQ(report("scans/state/lost"), 50.0);
  EXPECT_EQ(report("scans/inserted"), 0.0);
  EXPECT_FALSE(contains(read_file(out_ + "/scans.csv"), ",1\n"));
  std::filesystem::remove_all(out_);
  expect_one_line(run("--map " + (folder_ / "none.slam")), 2, "none.slam");
  expect_one_line(run("--quiet --map " + old + " --set map/resolution=0.1"), 2, "map/resolution");
}

/// Part of a run as a drive of its own, whose odometry begins at zero.
SimulatedRun part_of(const SimulatedRun& run, std::size_t from, std::size_t to) {
  SimulatedRun part;
  part.base_from_laser = run.base_from_laser;
  part.scans = {run.scans.begin() + static_cast<std::ptrdiff_t>(from),
                run.scans.begin() + static_cast<std::ptrdiff_t>(to)};
  const double begin = part.scans.front().stamp - 0.1;
  const double end = part.scans.back().stamp + 0.1;
  for (const OdometryReading& reading : run.odometry) {
    if (reading.stamp > begin && reading.stamp < end) {
      part.odometry.push_back(reading);
    }
  }
  const Pose2 odom_from_begin = part.odometry.front().odom_from_base;
  for (OdometryReading& reading : part.odometry) {
    reading.odom_from_base = odom_from_begin.inverse() * reading.odom_from_base;
  }
  return part;
}

/// Two drives in one world, the second an hour later and from another start, which it sees again.
class TwoDrives : public MapBag {
 protected:
  TwoDrives() {
    const World world = make_world("loop", 3);
    SimulationOptions options;
    options.laser.beams = 260;
    options.laser.scan_rate = 2.5;
    options.drive.speed = 1.0;
    const auto record = [&](const std::string& bag, std::uint64_t seed, std::size_t from,
                            std::size_t to) {
      const SimulatedRun run = simulate_run(world, world.route(), options, seed);
      SimulatedBagWriter(bag, {}).write(part_of(run, from, std::min(to, run.scans.size())),
                                        {"loop", 3, options.laser, {}});
      for (std::size_t i = 0; i < run.scans.size(); ++i) {
        truth_[std::lround(1e3 * run.scans[i].stamp)] = run.world_from_base[i];
      }
      return run.world_from_base[from];
    };
    world_from_map_ = record(bag_, 3, 0, 190);
    options.time.start_stamp += 3600.0;
    record(second_, 4, 80, 1000);
  }

  /// Farthest from the truth [m] of a file of poses.
  double worst(const std::string& file) {
    double worst = 0.0;
    const Trajectory poses = read_tum(out_ + "/" + file);
    for (const StampedPose2& pose : poses.poses()) {
      const Pose2 truth = world_from_map_.inverse() * truth_.at(std::lround(1e3 * pose.stamp));
      worst = std::max(worst, (pose.pose.translation() - truth.translation()).norm());
    }
    return worst;
  }

  const std::string second_ = folder_ / "second.bag";
  std::map<long, Pose2> truth_;  ///< world_from_base by stamp [ms]
  Pose2 world_from_map_;
};

TEST_F(TwoDrives, BecomeOneMap) {
  const auto expect_one_map = [this](const Outcome& outcome, const std::string& told) {
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, told)) << outcome.output;
    EXPECT_LT(worst("trajectory.tum"), 0.02);  // 0.012
    EXPECT_LT(worst("key_scans.tum"), 0.02) << "a wall is drawn twice";
    EXPECT_GE(report("loops/closed"), 1.0);  // where the second one ends and the first began
    EXPECT_EQ(report("scans/maps_apart"), 0.0);
  };
  expect_one_map(run(second_), "\nanother drive begins after 190 scans: the robot is searched for");
  ASSERT_EQ(run("").exit_code, 0);
  const std::string old = folder_ / "old.slam";
  std::filesystem::copy_file(out_ + "/map.slam", old);
  expect_one_map(run_command(MATCHBOX_MAP_BAG, second_ + " --out " + out_ + " --map " + old),
                 " newer than the last one of the map: the robot is searched for in the map");
}

TEST_F(MapBag, DrivesThatNeverMeetAreNotDrawnOverEachOther) {
  const auto drive = [this](const std::string& bag, const std::string& world, int seed,
                            double begin) {
    SimulationOptions options;
    options.laser.beams = 260;
    options.laser.scan_rate = 5.0;
    options.time.start_stamp = begin;
    const World there = make_world(world, static_cast<std::uint64_t>(seed));
    SimulatedRun run =
        simulate_run(there, there.route(), options, static_cast<std::uint64_t>(seed));
    SimulatedBagWriter(bag, {}).write(part_of(run, 0, 100), {world, 3, options.laser, {}});
  };
  const std::string second = folder_ / "second.bag";
  drive(bag_, "rooms", 3, 1000.0);
  drive(second, "loop", 3, 5000.0);
  const Outcome outcome = run(second);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output,
                       "100 of 200 poses are in such maps, each in a frame of its "
                       "own that has nothing to do with the map's"))
      << outcome.output;
  EXPECT_EQ(poses(), 200U);
}

TEST_F(MapBag, TellsOfFilesWhoseScansAreOfTheSameTime) {
  SmallBag recipe;
  write_small_bag(bag_, recipe);
  const std::string second = folder_ / "second.bag";
  recipe.begin = 1002.05;
  write_small_bag(second, recipe);
  const Outcome mixed = run(second);
  EXPECT_TRUE(contains(mixed.output, "warning: " + bag_ + " and " + second +
                                         " both hold scans of /scan, and are of the same time for "
                                         "3.2 s: they are read as one recording"))
      << mixed.output;
  EXPECT_TRUE(contains(mixed.output, "merge_maps A/map.slam B/map.slam --out DIR")) << mixed.output;
  recipe.begin = 1004.5;  // as the files of a drive that is split
  write_small_bag(second, recipe);
  EXPECT_FALSE(contains(run(second).output, "the same time"));
  recipe.begin = 1002.05;
  recipe.scan_topic = "/rear_scan";
  write_small_bag(second, recipe);
  EXPECT_FALSE(contains(run(second + " --scan-topic /scan --scan-topic /rear_scan").output,
                        "the same time"));
}

TEST_F(MapBag, WhatIsNoMapToGoOnWithIsRefusedWithWhatToGive) {
  write_small_bag(bag_);
  expect_one_line(run("--map " + (folder_ / "")), 2, "is a folder; give the map in it");
  expect_one_line(run("--map " + bag_), 2, "is a recording; map_bag");
  std::filesystem::copy_file(bag_, folder_ / "a.slam");
  std::filesystem::copy_file(bag_, folder_ / "a.yaml");
  expect_one_line(run("--map " + (folder_ / "a.slam")), 2, "is a recording; map_bag");
  expect_one_line(run("--map " + (folder_ / "a.yaml")), 2, "is a recording; map_bag");
  expect_one_line(run("--map map.png"), 2, "is the image of a map; give the .slam");
}

}  // namespace
}  // namespace matchbox_slam
