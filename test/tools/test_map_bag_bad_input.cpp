// Of tools/bag_mapper.hpp: every row of the table of bad input that map_bag meets.

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <optional>

#include "common/error_text.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "ros/messages.hpp"
#include "ros/scan_types.hpp"
#include "tools/map_bag_run.hpp"
#include "tools/out_folder.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

TEST_F(MapBag, AJumpWhileItIsInDoubtLosesNothing) {
  ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                        "--world rooms --seed 8 --duration 70 --sensor rplidar_a1 --turn-rate 2.5 "
                        "--turn-acceleration 20 --imu --no-odometry --rotation-noise 0.002 "
                        "--heading-noise 0.0005 --heading-bias 0 --rotation-bias 0.005 --bag " +
                            bag_ + " --truth " + (folder_ / "truth.tum"))
                .exit_code,
            0);
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
}

TEST_F(MapBag, ARunThatIsRefusedLeavesNoFolder) {
  EXPECT_EQ(run_small({}, "--start 1000").exit_code, 1);
  EXPECT_FALSE(std::filesystem::exists(out_));
  std::filesystem::create_directory(out_);
  EXPECT_EQ(run("--start 1000").exit_code, 1);
  EXPECT_TRUE(std::filesystem::exists(out_)) << "it was there";
}

TEST_F(MapBag, TwoDoNotWriteIntoOneFolderAtOnce) {
  write_small_bag(bag_, {});
  std::filesystem::create_directories(out_);
  {
    const FolderLock of_another(out_);
    expect_one_line(run(""), 2, "another program is writing its results into '" + out_ + "'");
  }
  EXPECT_EQ(run("").exit_code, 0);
}

TEST_F(MapBag, ARunThatIsRefusedLeavesTheFolderToTheOneThatWrites) {
  {
    const EmptyFolderRemoval of_the_second(out_);
    std::filesystem::create_directories(out_);
    const FolderLock of_the_first(out_);
  }
  EXPECT_FALSE(std::filesystem::exists(out_)) << "nobody writes there any more";
  std::optional<EmptyFolderRemoval> of_the_second(out_);
  std::filesystem::create_directories(out_);
  const FolderLock of_the_first(out_);
  of_the_second.reset();
  EXPECT_TRUE(std::filesystem::exists(out_)) << "the first one was about to write there";
}

TEST_F(MapBag, AdvisesToMaskBeamsThatEndOnTheRobot) {
  const std::string healthy = folder_ / "healthy.bag";
  ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                        "--world rooms --seed 4 --duration 120 --beams 261 --scan-rate 5 --bag " +
                            healthy + " --truth " + (folder_ / "truth.tum"))
                .exit_code,
            0);
  const Outcome silent = run_command(MATCHBOX_MAP_BAG, healthy + " --out " + out_);
  EXPECT_FALSE(contains(silent.output, "warning")) << silent.output;
  convert_bag(healthy, bag_, "/base_scan", "/base_scan", [](sensor_msgs::LaserScan scan) {
    for (std::size_t k = 20; k < 30; ++k) {
      scan.ranges[k] = 0.45F;
    }
    return scan;
  });
  const Outcome told = run("");
  EXPECT_EQ(told.exit_code, 0);
  EXPECT_TRUE(contains(told.output,
                       "warning: beams end on the robot itself: in 1 sector the range stays the "
                       "same wherever it is; to leave them out of every laser's scans give --set "
                       "scan/masked_angles=[-1.947,-1.739]\n"))
      << told.output;
  const Outcome masked = run("--set scan/masked_angles=[-1.947,-1.739]");
  EXPECT_FALSE(contains(masked.output, "warning")) << masked.output;
}

TEST_F(MapBag, ScansOfFewReturnsAreTold) {
  for (const auto& [beams, is_told] : {std::pair("8", true), {"32", true}, {"64", false}}) {
    ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                          "--world rooms --seed 5 --duration 15 --sensor ranger32 --beams " +
                              std::string(beams) + " --bag " + bag_ + " --truth " +
                              (folder_ / "truth.tum"))
                  .exit_code,
              0);
    const Outcome mapped = run("");
    EXPECT_EQ(mapped.exit_code, 0);
    EXPECT_EQ(contains(mapped.output,
                       " returns in the median; with fewer than 40 the map may be no better than "
                       "odometry. "),
              is_told)
        << mapped.output;
  }
}

/// A bag whose scans start over at an earlier stamp, as when the robot's clock was set back.
void write_bag_with_time_jump(const std::string& path) {
  SmallBag recipe;
  recipe.scans = 30;
  write_small_bag(path, recipe);
  rosbag::Bag bag(path, rosbag::bagmode::Append);
  for (int k = 0; k < 60; ++k) {
    const double stamp = 900.0 + 0.05 * k;
    const ros::Time recorded(1010.0 + 0.05 * k);
    bag.write("/tf", recorded,
              make_transforms({make_transform(stamp, "odom", "base_link", 0.001 * k),
                               make_transform(stamp, "base_link", "laser", 0.2)}));
    bag.write("/scan", recorded, make_scan(stamp));
  }
}

TEST_F(MapBag, CutsBeamsThatReadTheLargestRangePlusNoise) {
  write_small_bag(bag_);
  rosbag::Bag bag(bag_, rosbag::bagmode::Append);
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const double stamp = 1000.01 + 0.1 * i;
    sensor_msgs::LaserScan scan = make_scan(stamp);
    for (std::size_t k = 0; k < scan.ranges.size(); k += 2) {
      scan.ranges[k] = scan.range_max + 0.02F * static_cast<float>(random.gaussian());
    }
    bag.write("/far_scan", ros::Time(stamp), scan);
  }
  bag.close();
  const Outcome cut = run("--scan-topic /far_scan");
  EXPECT_EQ(cut.exit_code, 0) << cut.output;
  EXPECT_TRUE(contains(cut.output,
                       "beams of a laser read one range plus noise; scan/max_range "
                       "is set to 29."))
      << cut.output;
  EXPECT_NEAR(report("configuration/scan~1max_range"), 29.9, 0.02);
  EXPECT_LT(read_map(out_ + "/map.yaml").width, 200);
  const Outcome kept = run("--scan-topic /far_scan --set scan/max_range=40");
  EXPECT_FALSE(contains(kept.output, "plus noise")) << kept.output;
  EXPECT_GT(read_map(out_ + "/map.yaml").width, 500) << "walls at 30 m";
  EXPECT_FALSE(contains(run("--scan-topic /scan").output, "plus noise"));
}

TEST_F(MapBag, GoesOnStartsAnewOrStopsWhenTimeJumpsBack) {
  write_bag_with_time_jump(bag_);
  const Outcome on = run("");
  EXPECT_EQ(on.exit_code, 0) << on.output;
  EXPECT_TRUE(contains(on.output, "after 30 scans: the map goes on, as time_jump is 'go_on'"))
      << on.output;
  EXPECT_TRUE(contains(on.output, "poses of before the first step are in " + out_ +
                                      "/trajectory.1.tum, those since the last one in"))
      << on.output;
  for (const std::string name : {"trajectory", "trajectory_live", "odometry"}) {
    EXPECT_EQ(read_tum(out_ + "/" + name + ".1.tum").size(), 30U) << name;
    const Trajectory since = read_tum(out_ + "/" + name + ".tum");
    EXPECT_EQ(30.0 + static_cast<double>(since.size()), report("scans/used")) << name;
    EXPECT_LT(since.poses().back().stamp, 910.0) << name;
  }
  EXPECT_EQ(report("clock_steps"), 1.0);
  EXPECT_EQ(report("resets"), 0.0);
  EXPECT_EQ(report("scans/received"), report("scans/used") + report("scans/skipped_total"));
  const Outcome reset = run("--set time_jump=reset");
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  EXPECT_TRUE(contains(reset.output, "after 30 scans: starting a new map, as time_jump is 'reset'"))
      << reset.output;
  EXPECT_LT(read_tum(out_ + "/trajectory.tum").poses().front().stamp, 910.0);
  EXPECT_EQ(report("resets"), 1.0);
  EXPECT_EQ(report("scans/used"), static_cast<double>(poses()));
  EXPECT_EQ(report("scans/skipped/before_reset"), 30.0);
  EXPECT_EQ(report("scans/skipped/out_of_order"), 2.0);
  EXPECT_EQ(report("scans/received"), report("scans/used") + report("scans/skipped_total"));
  const Outcome stop = run("--set time_jump=stop");
  EXPECT_EQ(stop.exit_code, 0) << stop.output;
  EXPECT_TRUE(contains(stop.output, "stopping there, as time_jump is 'stop'")) << stop.output;
  EXPECT_EQ(poses(), 30U);
}

TEST_F(MapBag, WhenNothingAfterATimeJumpCanBeUsedItSaysThat) {
  SmallBag recipe;
  recipe.scans = 30;
  write_small_bag(bag_, recipe);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    for (int k = 0; k < 40; ++k) {  // without transforms
      bag.write("/scan", ros::Time(1010.0 + 0.05 * k), make_scan(900.0 + 0.05 * k));
    }
  }
  EXPECT_EQ(run("").exit_code, 0) << "what was mapped before is a map";
  EXPECT_EQ(poses(), 30U);
  const Outcome outcome = run("--quiet --set time_jump=reset");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  const std::string last = outcome.output.substr(outcome.output.find("map_bag: "));
  EXPECT_TRUE(contains(last,
                       "of 70 scans 30 were used before time jumped back and none since, the "
                       "first: scan of 900.1"))
      << last;
  EXPECT_TRUE(contains(last, "(no_transform)")) << last;
  EXPECT_TRUE(contains(last, "--set time_jump=stop")) << last;
}

TEST_F(MapBag, OneScanWithAWrongStampCostsNoMap) {
  write_small_bag(bag_);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    bag.write("/scan", ros::Time(1002.01), make_scan(900.0));
  }
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(poses(), 50U);
  EXPECT_EQ(report("resets"), 0.0);
  EXPECT_EQ(report("scans/skipped/out_of_order"), 1.0);
}

TEST_F(MapBag, SkipsScansThatAreNoneAndSaysWhy) {
  write_small_bag(bag_);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    sensor_msgs::LaserScan scan = make_scan(1000.05);
    scan.ranges.clear();
    bag.write("/scan", ros::Time(1000.05), scan);
    scan = make_scan(1000.06);
    scan.angle_increment = std::nanf("");
    bag.write("/scan", ros::Time(1000.06), scan);
    bag.write("/scan", ros::Time(1000.11), make_scan(1000.1));
  }
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "skipped (empty): it has no ranges")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "skipped (invalid): its angle_min")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "skipped (duplicate_stamp)")) << outcome.output;
  EXPECT_EQ(poses(), 50U);
  EXPECT_EQ(report("scans/received"), 53.0);
  EXPECT_EQ(report("scans/skipped/empty"), 1.0);
  EXPECT_EQ(report("scans/skipped/invalid"), 1.0);
  EXPECT_EQ(report("scans/skipped/duplicate_stamp"), 1.0);
}

TEST_F(MapBag, RefusesBagsThatCannotBeRead) {
  expect_one_line(run(""), 2, "bag '" + bag_ + "' does not exist");
  replace_file(bag_, "");
  expect_one_line(run(""), 1, "is empty (0 bytes)");
  replace_file(bag_, "no bag");
  expect_one_line(run(""), 1, "is no bag");
  write_small_bag(bag_);
  const std::string bytes = read_file(bag_);
  replace_file(bag_, bytes.substr(0, bytes.size() / 2));
  expect_one_line(
      run(""), 1,
      "makes it readable, but only up to the first damage: what is behind that is lost");
}

TEST_F(MapBag, WritesThePartBeforeADamage) {
  SmallBag recipe;
  recipe.scans = 4000;
  recipe.compression = rosbag::compression::BZ2;
  write_small_bag(bag_, recipe);
  std::string bytes = read_file(bag_);
  const std::size_t chunk = bytes.find("BZh", bytes.size() / 2);
  ASSERT_NE(chunk, std::string::npos);
  bytes.replace(chunk + 200, 64, std::string(64, 'x'));
  replace_file(bag_, bytes);
  for (const char* threads : {"", "--threads 2"}) {
    const Outcome outcome = run(threads);
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "the results cover the part before, " +
                                             std::to_string(poses()) + " scans in "))
        << outcome.output;
    EXPECT_GT(poses(), 100U);
    EXPECT_LT(poses(), 4000U);
  }
}

TEST_F(MapBag, WritesNothingWhereTheBeginningOrAHeaderIsDamaged) {
  SmallBag recipe;
  recipe.scans = 4000;
  recipe.compression = rosbag::compression::BZ2;
  write_small_bag(bag_, recipe);
  const std::string whole = read_file(bag_);
  const auto expect_nothing = [&](std::size_t place) {
    ASSERT_NE(place, std::string::npos);
    std::string bytes = whole;
    bytes.replace(place, 64, std::string(64, 'x'));
    replace_file(bag_, bytes);
    expect_one_line(run(""), 1, "is damaged at byte ");
  };
  expect_nothing(whole.find("BZh") + 200);
  expect_nothing(whole.find("compression=bz2", whole.size() / 2));
}

TEST_F(MapBag, RefusesWhatCannotBeWrittenBeforeItStarts) {
  write_small_bag(bag_);
  replace_file(folder_ / "file", "");
  out_ = folder_ / "file/out";
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, out_)) << outcome.output;
  EXPECT_FALSE(contains(outcome.output, "scan topic")) << outcome.output;
}

TEST_F(MapBag, AFullDiskLeavesTheOldResults) {
  ASSERT_EQ(run_small({}).exit_code, 0);
  std::map<std::string, std::string> old;
  for (const auto& file : std::filesystem::directory_iterator(out_)) {
    old[file.path().string()] = read_file(file.path().string());
  }
  const Outcome outcome =
      run_on_full_disk(MATCHBOX_MAP_BAG, bag_ + " --quiet --set map/resolution=0.02 --out " + out_);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_EQ(outcome.output, "map_bag: cannot write '" + out_ + "/scans.csv': File too large\n");
  std::size_t files = 0;
  for (const auto& file : std::filesystem::directory_iterator(out_)) {
    EXPECT_TRUE(read_file(file.path().string()) == old[file.path().string()]) << file.path();
    ++files;
  }
  EXPECT_EQ(files, old.size());
}

TEST_F(MapBag, LeavesAWildPoseOutOfTheMap) {
  write_small_bag(bag_);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    for (const double stamp : {1010.0, 1010.1}) {  // 10000 km to the north-east
      tf2_msgs::TFMessage message = make_robot_transforms(stamp, {});
      message.transforms[0].transform.translation.x = 1e7;
      message.transforms[0].transform.translation.y = 1e7;
      bag.write("/tf", ros::Time(stamp), message);
    }
    bag.write("/scan", ros::Time(1010.05), make_scan(1010.05));
  }
  const Outcome outcome = run("--matcher odometry_only");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "a scan is left out of the map")) << outcome.output;
  EXPECT_EQ(poses(), 51U);
  EXPECT_LT(read_map(out_ + "/map.yaml").width, 200);
}

}  // namespace
}  // namespace matchbox_slam
