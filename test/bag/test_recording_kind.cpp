#include <gtest/gtest.h>

#include <fstream>

#include "bag/bag_error.hpp"
#include "bag/bag_reader.hpp"
#include "bag/recording_kind.hpp"
#include "common/error_text.hpp"
#include "io/gzip.hpp"
#include "io/temporary_folder.hpp"

namespace matchbox_slam {
namespace {

class OpenRecording : public testing::Test {
 protected:
  /// What is said of a file of these bytes.
  std::string why_not(const std::string& bytes) {
    std::ofstream(path_, std::ios::binary) << bytes;
    return error_text<BagError>([this] { const BagReader reader({path_}); });
  }

  void expect_named(const std::string& bytes, const std::string& words) {
    const std::string text = why_not(bytes);
    EXPECT_EQ(text.substr(0, path_.size() + 3), "'" + path_ + "' ") << text;
    EXPECT_TRUE(contains(text, words)) << text;
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "recording.bag";
};

TEST_F(OpenRecording, NamesOldBagsAndWhatConvertsThem) {
  expect_named("#ROSBAG V1.2\n#and more\n",
               "is a bag of version 1.2, which ROS wrote in its first years; convert it: rosbag "
               "filter '" +
                   path_ + "' NEW.bag True");
  expect_named("#ROSBAG V1.1\n",
               "version 1.1, which ROS wrote in its first years; convert it with");
}

TEST_F(OpenRecording, NamesRawlogsOfMrptPackedOrNot) {
  const std::string rawlog =
      "\x8D"
      "CSensoryFrame\x02\x01";
  expect_named(rawlog, "is a rawlog of MRPT; play it with `rosrun mrpt_rawlog rawlog_play`");
  expect_named(compress(rawlog), "is a rawlog of MRPT");
  expect_named(
      "\x9B"
      "mrpt::obs::CActionCollection",
      "is a rawlog of MRPT");
}

TEST_F(OpenRecording, NamesRecordingsOfTinySlam) {
  std::string line = "1234567";
  for (int k = 0; k < 700; ++k) {
    line += " " + std::to_string(100 + k);
  }
  expect_named(line + "\n" + line + "\n", "looks like a recording of tinySLAM");
}

TEST_F(OpenRecording, SaysHowToUnpackWhatIsPackedAsAWhole) {
  expect_named("\x28\xB5\x2F\xFD and more",
               "is packed by zstd, as ros2 bag record does with "
               "--compression-mode file; unpack it: unzstd '" +
                   path_);
  expect_named("BZh91AY", "unpack it: bunzip2 '");
  expect_named(compress("#ROSBAG V2.0\nand more"), "is packed by gzip; unpack it: gunzip '");
}

TEST_F(OpenRecording, SaysThatItIsNothingThatIsRead) {
  expect_named("a text\n", "is no bag of version 2.0, no bag of ROS 2 (.db3, .mcap) and no log of");
  expect_named(compress("a text\n"), "is no bag of version 2.0");
  expect_named("\x1F\x8B", "is no bag of version 2.0");
}

TEST_F(OpenRecording, LooksAtTheInsideAndNotAtTheName) {
  std::ofstream(path_) << "PARAM a b\nFLASER 1 1 0 0 0 0 0 0 1 h 1\n";
  EXPECT_EQ(BagReader({path_}).topics_of("sensor_msgs/LaserScan"),
            std::vector<std::string>{"/flaser"});
}

}  // namespace
}  // namespace matchbox_slam
