// Of bag/bag_conversion.hpp: recordings in other formats than bags of ROS 1; map_bag makes the same
// map of them, and writes them as such bags.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bag/ros2_recordings.hpp"
#include "bag/whole_bag.hpp"
#include "common/error_text.hpp"
#include "io/gzip.hpp"
#include "io/real_data.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

class Recordings : public testing::Test {
 protected:
  Outcome map(const std::string& recording, const std::string& out,
              const std::string& arguments = "") {
    return run_command(MATCHBOX_MAP_BAG, recording + " --out " + (folder_ / out) + " " + arguments);
  }

  Outcome convert(const std::string& recording, const std::string& bag,
                  const std::string& arguments = "") {
    return run_command(MATCHBOX_MAP_BAG, recording + " --convert " + bag + " " + arguments);
  }

  void expect_same_map(const std::string& out, const std::string& expected) {
    for (const std::string file :
         {"trajectory.tum", "odometry.tum", "map.pgm", "map.slam", "scans.csv"}) {
      EXPECT_EQ(read_file(folder_ / out + "/" + file), read_file(folder_ / expected + "/" + file))
          << out << '/' << file;
    }
  }

  TemporaryFolder folder_;
  std::string bag_ = folder_ / "whole.bag";
};

/// Odometry and the scans of one topic of a bag as CARMEN would have logged them.
std::string as_carmen_log(const std::string& bag, const std::string& topic) {
  std::ostringstream log;
  log.precision(17);
  std::string pose = "0 0 0";
  const BagReader reader({bag});
  const auto stream = reader.messages([](const BagConnection& /*all*/) { return true; }, {});
  while (const auto message = stream->next()) {
    const std::string tail = " " + std::to_string(message->time.toSec()) + " host 0";
    if (const auto* tf = std::get_if<tf2_msgs::TFMessage::ConstPtr>(&message->content)) {
      for (const geometry_msgs::TransformStamped& transform : (*tf)->transforms) {
        if (transform.header.frame_id.rfind("odom", 0) == 0) {
          const auto& at = transform.transform;
          std::ostringstream text;
          text.precision(17);
          text << at.translation.x << ' ' << at.translation.y << ' '
               << 2.0 * std::atan2(at.rotation.z, at.rotation.w);
          pose = text.str();
          log << "ODOM " << pose << " 0 0 0" << tail << '\n';
        }
      }
    } else if (message->connection->topic == topic) {
      const auto& scan = *std::get<sensor_msgs::LaserScan::ConstPtr>(message->content);
      log << "FLASER " << scan.ranges.size();
      for (const float range : scan.ranges) {
        log << ' ' << (std::isfinite(range) ? range : 81.91F);
      }
      log << ' ' << pose << ' ' << pose << tail << '\n';
    }
  }
  return log.str();
}

TEST_F(Recordings, OfRos2GiveTheMapOfTheBagOfRos1) {
  write_whole_bag(bag_);
  ASSERT_EQ(map(bag_, "ros1", "--scan-topic /scan").exit_code, 0);
  const std::vector<Ros2Message> messages = as_ros2(bag_);
  McapRecipe recipe;
  recipe.compression = "zstd";
  write_bytes(folder_ / "whole.mcap", to_mcap(messages, recipe));
  const Outcome mcap = map(folder_ / "whole.mcap", "mcap");  // it has one topic of LaserScan
  EXPECT_EQ(mcap.exit_code, 0) << mcap.output;
  expect_same_map("mcap", "ros1");
  std::filesystem::create_directory(folder_ / "drive");
  write_db3(folder_ / "drive/drive_0.db3", messages);
  write_bytes(folder_ / "drive/metadata.yaml",
              "rosbag2_bagfile_information:\n  relative_file_paths: [drive_0.db3]\n");
  const Outcome db3 = map(folder_ / "drive", "db3", "--threads 2");
  EXPECT_EQ(db3.exit_code, 0) << db3.output;
  expect_same_map("db3", "ros1");
}

TEST_F(Recordings, ConvertedTheyGiveTheSameMap) {
  write_whole_bag(bag_);
  write_bytes(folder_ / "whole.mcap", to_mcap(as_ros2(bag_)));
  write_bytes(folder_ / "drive.clf.gz", compress(as_carmen_log(bag_, "/scan")));
  for (const std::string name : {"whole.bag", "whole.mcap", "drive.clf.gz"}) {
    const std::string converted = folder_ / (name + ".bag");
    const Outcome conversion = convert(folder_ / name, converted, "--start 0.5");
    ASSERT_EQ(conversion.exit_code, 0) << conversion.output;
    const Outcome original = map(folder_ / name, name + ".out", "--start 0.5");
    EXPECT_EQ(original.exit_code, 0) << original.output;
    EXPECT_EQ(map(converted, name + ".bag.out").exit_code, 0);
    expect_same_map(name + ".bag.out", name + ".out");
  }
}

TEST_F(Recordings, AConversionHoldsWhatIsForAMap) {
  write_whole_bag(bag_);
  const Outcome all = convert(bag_, folder_ / "all.bag");
  EXPECT_TRUE(
      contains(all.output, "all.bag: 54 scans, 107 messages of tf and 4 of odometry and IMU\n"))
      << all.output;
  EXPECT_TRUE(all_of({folder_ / "all.bag"}) == all_of({bag_}));
  const Outcome one = convert(bag_, folder_ / "one.bag", "--scan-topic scan");
  EXPECT_TRUE(contains(one.output, "one.bag: 50 scans")) << one.output;
}

TEST_F(Recordings, AConversionOverwritesNothing) {
  write_whole_bag(bag_);
  const std::string before = read_file(bag_);
  const Outcome outcome = convert(bag_, bag_);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(contains(outcome.output, "--convert: there is '" + bag_ + "' already"));
  EXPECT_EQ(read_file(bag_), before);
  const Outcome with_map = convert(bag_, folder_ / "new.bag", "--out " + (folder_ / "out"));
  EXPECT_EQ(with_map.exit_code, 2);
  EXPECT_TRUE(contains(with_map.output, "--convert: --out is for maps")) << with_map.output;
  const Outcome full =
      run_on_full_disk(MATCHBOX_MAP_BAG, bag_ + " --convert " + (folder_ / "full.bag"));
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_TRUE(contains(full.output, "full.bag: the bag cannot be written")) << full.output;
  EXPECT_EQ(
      run_interrupted(MATCHBOX_MAP_BAG, bag_ + " --convert " + (folder_ / "stopped.bag")).exit_code,
      0);
  EXPECT_EQ(folder_.file_count(), 1U);
}

TEST_F(Recordings, ACutOffOneIsMappedAndConvertedAsFarAsItGoes) {
  SmallBag recipe;
  recipe.scans = 300;
  write_small_bag(bag_, recipe);
  const std::string bytes = to_mcap(as_ros2(bag_));
  const std::string path = folder_ / "cut.mcap";
  write_bytes(path, bytes.substr(0, 2 * bytes.size() / 3));
  const Outcome mapped = map(path, "out");
  EXPECT_EQ(mapped.exit_code, 1);
  EXPECT_TRUE(contains(mapped.output, "cut.mcap' is damaged at byte ")) << mapped.output;
  EXPECT_TRUE(contains(mapped.output, "; the results cover the part before")) << mapped.output;
  EXPECT_GT(read_tum(folder_ / "out/trajectory.tum").size(), 180U);
  const Outcome converted = convert(path, folder_ / "cut.bag");
  EXPECT_EQ(converted.exit_code, 1);
  EXPECT_TRUE(contains(converted.output, "; the bag holds the part before")) << converted.output;
  EXPECT_EQ(map(folder_ / "cut.bag", "converted").exit_code, 0);
  expect_same_map("converted", "out");
  // Without tf before the damage, both are told.
  SmallBag without_tf;
  without_tf.with_transforms = false;
  write_small_bag(folder_ / "scans.bag", without_tf);
  const std::string scans = to_mcap(as_ros2(folder_ / "scans.bag"));
  write_bytes(folder_ / "scans.mcap", scans.substr(0, scans.size() / 2));
  const Outcome no_tf = map(folder_ / "scans.mcap", "scans");
  EXPECT_EQ(no_tf.exit_code, 1);
  EXPECT_TRUE(contains(no_tf.output, "; of the part before: tf in the bag says nothing of"))
      << no_tf.output;
  // Within the ten seconds from which frames are found, too.
  write_bytes(path, bytes.substr(0, bytes.size() / 5));
  EXPECT_EQ(map(path, "short").exit_code, 1);
  EXPECT_GT(read_tum(folder_ / "short/trajectory.tum").size(), 50U);
}

TEST_F(Recordings, OfCarmenGiveTheMapOfTheBagThatWasMadeOfOne) {
  const std::string bag = real_data("aces.bag");
  MATCHBOX_SKIP_WITHOUT(bag);
  write_bytes(folder_ / "aces.clf", as_carmen_log(bag, "/base_scan"));
  ASSERT_EQ(map(bag, "bag").exit_code, 0);
  const Outcome outcome = map(folder_ / "aces.clf", "log", "--set scan/max_range=49");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_FALSE(contains(outcome.output, "warning")) << outcome.output;
  const Trajectory of_bag = read_tum(folder_ / "bag/trajectory.tum");
  const Trajectory of_log = read_tum(folder_ / "log/trajectory.tum");
  ASSERT_EQ(of_log.size(), of_bag.size());
  double farthest = 0.0;
  for (std::size_t k = 0; k < of_bag.size(); ++k) {
    farthest = std::max(
        farthest,
        (of_log.poses()[k].pose.translation() - of_bag.poses()[k].pose.translation()).norm());
  }
  EXPECT_LT(farthest, 0.02);  // 7 mm; with the angles of 181 beams 0.2 m
}

}  // namespace
}  // namespace matchbox_slam
