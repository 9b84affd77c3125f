#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/LaserScan.h>
#include <tf2_msgs/TFMessage.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bag/simulated_bag.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

LaserOptions inverted_laser() {
  LaserOptions laser;
  laser.beams = 50;
  laser.mount_roll = kPi;
  return laser;
}

SimulationRecord how_it_was_made() { return {"rooms", 1, inverted_laser(), {}}; }

SimulatedRun short_run() {
  SimulationOptions options;
  options.time.duration = 4.0;
  options.laser = inverted_laser();
  const World world = make_world("rooms", 1);
  return simulate_run(world, world.route(), options, 1);
}

/// What a bag holds.
struct Recording {
  std::vector<sensor_msgs::LaserScan> scans;
  std::map<std::string, std::vector<geometry_msgs::TransformStamped>> transforms;  ///< by child
  std::vector<double> delays;  ///< [s] from each scan's stamp to its recording
};

Recording read(const std::string& path) {
  Recording recording;
  rosbag::Bag bag(path, rosbag::bagmode::Read);
  for (const rosbag::MessageInstance& message : rosbag::View(bag)) {
    if (const auto scan = message.instantiate<sensor_msgs::LaserScan>()) {
      EXPECT_EQ(message.getTopic(), "/base_scan");
      recording.scans.push_back(*scan);
      recording.delays.push_back((message.getTime() - scan->header.stamp).toSec());
    } else if (const auto transforms = message.instantiate<tf2_msgs::TFMessage>()) {
      EXPECT_EQ(message.getTopic(), "/tf");
      for (const auto& transform : transforms->transforms) {
        recording.transforms[transform.child_frame_id].push_back(transform);
      }
    } else if (message.getTopic() != kSimulationTopic) {
      ADD_FAILURE() << message.getTopic();
    }
  }
  return recording;
}

class SimulatedBag : public testing::Test {
 protected:
  Recording record(const SimulatedBagOptions& options) {
    SimulatedBagWriter(path_, options).write(run_, how_it_was_made());
    return read(path_);
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "run.bag";
  SimulatedRun run_ = short_run();
};

TEST_F(SimulatedBag, TellsHowItWasMade) {
  (void)record({});
  const std::optional<SimulationRecord> told = read_simulation_record({path_});
  ASSERT_TRUE(told);
  EXPECT_EQ(told->world, "rooms");
  EXPECT_EQ(told->seed, 1U);
  EXPECT_EQ(told->laser.beams, 50);
  EXPECT_EQ(told->laser.mount_roll, kPi);
}

TEST(SimulationRecord, KeepsTheLargestSeedAndEveryOption) {
  SimulationRecord record{"loop", std::numeric_limits<std::uint64_t>::max(), {}, {}};
  record.laser.range_noise = 0.0123456789012345678;
  record.laser.no_return = "over_range";
  const SimulationRecord read = parse_simulation_record(to_yaml(record));
  EXPECT_EQ(read.seed, record.seed);
  EXPECT_EQ(read.laser.range_noise, record.laser.range_noise);
  EXPECT_EQ(read.laser.no_return, "over_range");
}

TEST(SimulationRecord, TellsLaterOptionsOnlyWhereTheyMatter) {
  SimulationRecord record{"rooms", 1, {}, {}};
  for (const char* name :
       {"range_noise_square", "parts", "sent_time_increment", "sent_scan_time"}) {
    EXPECT_EQ(to_yaml(record).find(name), std::string::npos) << name;
  }
  record.laser.range_noise_square = 0.002;
  record.laser.parts = 10;
  record.laser.sent_time_increment = 0.0;
  record.laser.sent_scan_time = 0.5;
  const SimulationRecord read = parse_simulation_record(to_yaml(record));
  EXPECT_EQ(read.laser.range_noise_square, 0.002);
  EXPECT_EQ(read.laser.parts, 10);
  EXPECT_EQ(read.laser.sent_time_increment, 0.0);
  EXPECT_EQ(read.laser.sent_scan_time, 0.5);
}

TEST(SimulationRecord, NamesTheFaultsWithTheirTimes) {
  SimulationRecord record{"rooms", 1, {}, {parse_fault("freeze:7:1.5"), parse_fault("jump:20")}};
  const SimulationRecord read = parse_simulation_record(to_yaml(record));
  ASSERT_EQ(read.faults.size(), 2U);
  EXPECT_EQ(to_string(read.faults[0]), to_string(record.faults[0]));
  EXPECT_EQ(to_string(read.faults[1]), to_string(record.faults[1]));
  EXPECT_THROW((void)parse_simulation_record("world: rooms\nseed: '1'\nfaults: [slip]"),
               ConfigurationError);
  EXPECT_THROW((void)parse_simulation_record("world: rooms\nseed: '1'\nfaults: 3"),
               ConfigurationError);
}

TEST(SimulationRecord, TellsOfTheDaysChanges) {
  SimulationRecord record{"rooms", 1, {}, {}};
  EXPECT_EQ(to_yaml(record).find("changes"), std::string::npos);
  record.changes.moved = 0.5;
  record.changes.walls = 2;
  record.changes.change_seed = 7;
  const SimulationRecord read = parse_simulation_record(to_yaml(record));
  EXPECT_EQ(read.changes.moved, 0.5);
  EXPECT_EQ(read.changes.walls, 2);
  EXPECT_EQ(read.changes.change_seed, 7);
  const World day = world_of(read);
  EXPECT_EQ(day.segments().size(), make_world("rooms", 1).segments().size() + 8U);
}

TEST(SimulationRecord, IsInNoRecordingOfAnotherFormat) {
  const TemporaryFolder folder;
  const std::string log = folder / "drive.log";
  replace_file(log, "FLASER 1 1 0 0 0 0 0 0 1 host 1\n");
  EXPECT_FALSE(read_simulation_record({log, folder.path()}));
}

TEST(SimulationRecord, RefusesWhatIsNone) {
  EXPECT_THROW((void)parse_simulation_record("hello"), ConfigurationError);
  EXPECT_THROW((void)parse_simulation_record("world: rooms"), ConfigurationError);
  EXPECT_THROW((void)parse_simulation_record("world: rooms\nseed: '-1'"), ConfigurationError);
  EXPECT_THROW((void)parse_simulation_record("world: rooms\nseed: '1'\nlaser: {beans: 3}"),
               ConfigurationError);
}

TEST_F(SimulatedBag, HoldsTheScansAsTheyWere) {
  const Recording recording = record({});
  ASSERT_EQ(recording.scans.size(), run_.scans.size());
  for (std::size_t i = 0; i < run_.scans.size(); ++i) {
    const sensor_msgs::LaserScan& scan = recording.scans[i];
    EXPECT_EQ(scan.header.frame_id, "base_laser_link");
    EXPECT_EQ(scan.header.stamp.toSec(), run_.scans[i].stamp);
    EXPECT_NEAR(scan.angle_max, scan.angle_min + 49 * scan.angle_increment, 1e-5);
    EXPECT_NEAR(scan.scan_time, 0.05, 1e-6);
    ASSERT_EQ(scan.ranges.size(), 50U);
    EXPECT_GT(recording.delays[i], 0.0);
    EXPECT_LT(recording.delays[i], 0.1);
  }
}

TEST_F(SimulatedBag, TimeFromScanToScanIsTheLasersAlsoAfterADropout) {
  run_.scans.erase(run_.scans.begin() + 1);
  EXPECT_NEAR(record({}).scans.front().scan_time, 0.05, 1e-6);
}

TEST_F(SimulatedBag, SaysOfTimesWhatTheLaserIsToSay) {
  SimulationRecord how = how_it_was_made();
  how.laser.sent_time_increment = 2.99e-5;
  how.laser.sent_scan_time = 0.0;
  SimulatedBagWriter(path_, {}).write(run_, how);
  for (const sensor_msgs::LaserScan& scan : read(path_).scans) {
    EXPECT_EQ(scan.time_increment, 2.99e-5F);
    EXPECT_EQ(scan.scan_time, 0.0F);
  }
}

TEST_F(SimulatedBag, PartsAreMessagesOfTheirOwn) {
  SimulationOptions options;
  options.time.duration = 2.0;
  options.laser.beams = 50;
  options.laser.parts = 5;
  options.laser.scan_rate = 10.0;
  options.laser.time_increment = 0.002;
  const World world = make_world("rooms", 1);
  run_ = simulate_run(world, world.route(), options, 1);
  SimulatedBagWriter(path_, {}).write(run_, {"rooms", 1, options.laser, {}});
  const std::vector<sensor_msgs::LaserScan> scans = read(path_).scans;
  ASSERT_EQ(scans.size(), 21U * 5U);
  for (std::size_t i = 1; i < scans.size(); ++i) {
    EXPECT_NEAR((scans[i].header.stamp - scans[i - 1].header.stamp).toSec(), 0.02, 1e-6);
    EXPECT_EQ(scans[i].ranges.size(), 10U);
    EXPECT_NEAR(scans[i].scan_time, 0.02, 1e-6);
    EXPECT_EQ(scans[i].time_increment, 0.002F);
    EXPECT_NEAR(scans[i].angle_max, scans[i].angle_min + 9 * scans[i].angle_increment, 1e-5);
    if (i % 5 != 0) {
      EXPECT_NEAR(scans[i].angle_min, scans[i - 1].angle_max + scans[i].angle_increment, 1e-5);
    }
  }
}

TEST_F(SimulatedBag, HoldsTheTransformsAroundEveryScan) {
  const Recording recording = record({});
  EXPECT_EQ(recording.transforms.size(), 3U);
  const std::map<std::string, std::string> parents = {{"base_footprint", "odom_combined"},
                                                      {"base_link", "base_footprint"},
                                                      {"base_laser_link", "base_link"}};
  for (const auto& [child, transforms] : recording.transforms) {
    ASSERT_EQ(parents.count(child), 1U) << child;
    EXPECT_EQ(transforms.size(), run_.odometry.size());
    EXPECT_EQ(transforms.front().header.frame_id, parents.at(child));
    EXPECT_LE(transforms.front().header.stamp, recording.scans.front().header.stamp);
    EXPECT_GE(transforms.back().header.stamp, recording.scans.back().header.stamp);
  }
  const auto& laser = recording.transforms.at("base_laser_link").front().transform;
  EXPECT_EQ(laser.translation.x, 0.275);
  EXPECT_EQ(laser.translation.z, 0.252);
  EXPECT_NEAR(std::abs(laser.rotation.x), 1.0, 1e-12);  // upside down
  const auto& odometry = recording.transforms.at("base_footprint");
  for (std::size_t i = 0; i < odometry.size(); ++i) {
    const Pose2& pose = run_.odometry[i].odom_from_base;
    EXPECT_EQ(odometry[i].header.stamp.toSec(), run_.odometry[i].stamp);
    EXPECT_EQ(odometry[i].transform.translation.x, pose.x);
    EXPECT_EQ(odometry[i].transform.translation.y, pose.y);
    EXPECT_NEAR(
        2.0 * std::atan2(odometry[i].transform.rotation.z, odometry[i].transform.rotation.w),
        pose.theta, 1e-12);
  }
}

TEST_F(SimulatedBag, CanLeaveTheOdometryOut) {
  SimulatedBagOptions options;
  options.no_odometry = true;
  const Recording recording = record(options);
  EXPECT_EQ(recording.transforms.count("base_footprint"), 0U);
  EXPECT_EQ(recording.transforms.count("base_laser_link"), 1U);
}

TEST_F(SimulatedBag, CanHaveTheQuirksOfOldRecordings) {
  SimulatedBagOptions options;
  options.clock_offset = 82.25;
  options.leading_slashes = true;
  const Recording recording = record(options);
  EXPECT_EQ(recording.scans.front().header.frame_id, "/base_laser_link");
  EXPECT_EQ(recording.scans.front().header.stamp.toSec(), run_.scans.front().stamp - 82.25);
  EXPECT_GT(recording.delays.front(), 82.25);
  ASSERT_EQ(recording.transforms.count("/base_footprint"), 1U);
  const auto& first = recording.transforms.at("/base_footprint").front();
  EXPECT_EQ(first.header.frame_id, "/odom_combined");
  EXPECT_EQ(first.header.stamp.toSec(), run_.odometry.front().stamp);
}

TEST_F(SimulatedBag, CompressedItHoldsTheSame) {
  SimulatedBagOptions options;
  const Recording plain = record(options);
  const auto plain_size = std::filesystem::file_size(path_);
  for (const char* compression : {"bz2", "lz4"}) {
    options.compression = compression;
    const Recording packed = record(options);
    EXPECT_EQ(packed.scans.size(), plain.scans.size());
    EXPECT_EQ(packed.transforms.size(), plain.transforms.size());
    EXPECT_LT(std::filesystem::file_size(path_), plain_size) << compression;
  }
}

TEST_F(SimulatedBag, TellsBeforeTheWorkThatItCannotBeWritten) {
  EXPECT_THROW(SimulatedBagWriter(folder_ / "missing/run.bag", {}), FileError);
  std::filesystem::create_directory(path_);
  EXPECT_THROW(SimulatedBagWriter(path_, {}), FileError);
}

TEST_F(SimulatedBag, LeavesNothingHalfWrittenAndAnOldBagAsItWas) {
  replace_file(path_, "old");
  { const SimulatedBagWriter never_used(path_, {}); }
  EXPECT_EQ(read_file(path_), "old");
  SimulatedBagOptions options;
  options.clock_offset = 1e6;
  run_.scans.front().stamp = 1e6;
  EXPECT_THROW(SimulatedBagWriter(path_, options).write(run_, how_it_was_made()),
               ConfigurationError);
  EXPECT_EQ(read_file(path_), "old");
  EXPECT_EQ(folder_.file_count(), 1U);
}

}  // namespace
}  // namespace matchbox_slam
