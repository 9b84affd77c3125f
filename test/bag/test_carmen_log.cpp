#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "bag/bag_error.hpp"
#include "bag/carmen_log.hpp"
#include "common/error_text.hpp"
#include "io/gzip.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

/// How a log is written: scans of three beams ten times a second.
struct LogRecipe {
  std::string message = "FLASER";
  int scans = 20;
  double mount_x = 0.0;        ///< by the laser's poses
  double odometry_lead = 0.0;  ///< [m] by which ODOM lines are ahead of the scans' poses
  std::string before;          ///< lines
  bool has_stamps = true;
};

std::string carmen_log(const LogRecipe& recipe) {
  std::ostringstream log;
  log << "# CARMEN Logfile\n" << recipe.before;
  for (int k = 0; k < recipe.scans; ++k) {
    const double x = 0.05 * k;
    std::ostringstream tail;
    tail.precision(16);
    if (recipe.has_stamps) {
      tail << ' ' << 976052857.0 + 0.1 * k << " host " << 0.1 * k;
    }
    log << "ODOM " << x + recipe.odometry_lead << " 0 0 0.5 0 0" << tail.str() << '\n';
    log << recipe.message << " 3 1 2 81.91 " << x + recipe.mount_x << " 0 0 " << x << " 0 0"
        << tail.str() << '\n';
  }
  return log.str();
}

class ReadCarmenLog : public testing::Test {
 protected:
  CarmenLog open(const std::string& text) {
    std::ofstream(path_, std::ios::binary) << text;
    return CarmenLog(path_);
  }

  /// All of its messages.
  static std::vector<RecordedMessage> messages(const CarmenLog& log) {
    BagSelection all;
    for (const auto& [number, connection] : log.connections()) {
      all.connections.insert(number);
    }
    const auto messages = log.messages(all);
    std::vector<RecordedMessage> read;
    while (messages->peek()) {
      read.push_back(messages->next());
    }
    return read;
  }

  /// Where a frame is in its parent by the first message that tells it.
  static geometry_msgs::TransformStamped place_of(const CarmenLog& log, const std::string& frame) {
    for (const RecordedMessage& message : messages(log)) {
      if (const auto* tf = std::get_if<tf2_msgs::TFMessage::ConstPtr>(&message.content)) {
        for (const geometry_msgs::TransformStamped& transform : (*tf)->transforms) {
          if (transform.child_frame_id == frame) {
            return transform;
          }
        }
      }
    }
    ADD_FAILURE() << "no frame " << frame;
    return {};
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "drive.log";
};

TEST_F(ReadCarmenLog, GivesScansOdometryAndMount) {
  const CarmenLog log = open(carmen_log({}));
  EXPECT_TRUE(log.remarks().empty()) << log.remarks().front();
  std::map<std::string, std::size_t> counts;
  ros::Time last;
  for (const RecordedMessage& message : messages(log)) {
    ++counts[message.connection->topic];
    EXPECT_GE(message.time, last);
    last = message.time;
    if (const auto* scan = std::get_if<sensor_msgs::LaserScan::ConstPtr>(&message.content)) {
      EXPECT_EQ((*scan)->header.stamp, message.time);
      EXPECT_EQ((*scan)->header.frame_id, "flaser");
      EXPECT_EQ((*scan)->range_max, 80.0F);
      EXPECT_EQ((*scan)->ranges, (std::vector<float>{1.0F, 2.0F, 81.91F}));
      EXPECT_FLOAT_EQ((*scan)->angle_max, static_cast<float>(0.5 * kPi));
    }
  }
  EXPECT_EQ(counts,
            (std::map<std::string, std::size_t>{{"/flaser", 20}, {"/tf", 40}, {"/tf_static", 1}}));
  EXPECT_DOUBLE_EQ(log.begin_time().toSec(), 976052857.0);
  const auto mount = place_of(log, "flaser");
  EXPECT_EQ(mount.header.frame_id, "base_link");
  EXPECT_EQ(mount.transform.translation.x, 0.0);
  EXPECT_EQ(place_of(log, "base_link").header.frame_id, "odom");
}

TEST_F(ReadCarmenLog, PlacesTheLaserByParametersElseByPoses) {
  LogRecipe recipe;
  recipe.mount_x = 0.3;
  EXPECT_NEAR(place_of(open(carmen_log(recipe)), "flaser").transform.translation.x, 0.3, 1e-12);
  recipe.before =
      "PARAM robot_frontlaser_offset 0.21 host 0\nPARAM robot_frontlaser_side_offset -0.1 host 0\n"
      "PARAM robot_frontlaser_angular_offset 1.0 host 0\n";
  const CarmenLog log = open(carmen_log(recipe));
  const auto mount = place_of(log, "flaser").transform;
  EXPECT_EQ(mount.translation.x, 0.21);
  EXPECT_EQ(mount.translation.y, -0.1);
  EXPECT_NEAR(mount.rotation.z, std::sin(0.5), 1e-12);
  ASSERT_EQ(log.remarks().size(), 1U);  // the poses say otherwise
  EXPECT_TRUE(contains(log.remarks().front(), "PARAM lines, which are taken"));
}

TEST_F(ReadCarmenLog, ARearLaserLooksBackUnlessTheLogTells) {
  LogRecipe recipe;
  recipe.message = "RLASER";
  EXPECT_NEAR(std::abs(place_of(open(carmen_log(recipe)), "rlaser").transform.rotation.z), 1.0,
              1e-12);
  recipe.before = "PARAM robot_rearlaser_offset -0.2 host 0\n";
  EXPECT_EQ(place_of(open(carmen_log(recipe)), "rlaser").transform.translation.x, -0.2);
}

TEST_F(ReadCarmenLog, CorrectedPosesAreNoMountAndTold) {
  std::string text;
  for (int k = 0; k < 20; ++k) {
    const std::string stamp = std::to_string(1000.0 + k);
    text += "FLASER 1 1 " + std::to_string(0.3 * k) + " 0 0 0 0 0 " + stamp + " h " + stamp + "\n";
  }
  const CarmenLog log = open(text);
  EXPECT_EQ(place_of(log, "flaser").transform.translation.x, 0.0);
  ASSERT_EQ(log.remarks().size(), 1U);
  EXPECT_TRUE(contains(log.remarks().front(), "corrected")) << log.remarks().front();
}

TEST_F(ReadCarmenLog, OfTwoOdometriesTheScansOwnIsTaken) {
  LogRecipe recipe;
  recipe.odometry_lead = 5.0;
  const CarmenLog log = open(carmen_log(recipe));
  EXPECT_EQ(messages(log).size(), 41U);
  ASSERT_EQ(log.remarks().size(), 1U);
  EXPECT_TRUE(contains(log.remarks().front(), "the latter alone are taken"));
}

TEST_F(ReadCarmenLog, RawReadingsOfALaserThatIsThereWithPosesAreLeftAside) {
  const std::string scan = " 0 -1.57 3.14 1.57 81 0 0 3 1 2 3 0 ";
  std::string text;
  for (int k = 0; k < 3; ++k) {
    const std::string tail = std::to_string(1000.0 + k) + " h 1\n";
    text += "RAWLASER1" + scan + tail + "ROBOTLASER1" + scan + "0 0 0 0 0 0 0 0 0 0 0 " + tail;
    text += "FLASER 3 1 2 3 0 0 0 0 0 0 " + tail;
  }
  const CarmenLog log = open(text);
  std::set<std::string> topics;
  for (const auto& [number, connection] : log.connections()) {
    topics.insert(connection.topic);
  }
  EXPECT_EQ(topics, (std::set<std::string>{"/flaser", "/robotlaser1", "/tf", "/tf_static"}));
  ASSERT_EQ(log.remarks().size(), 1U);
  EXPECT_TRUE(contains(log.remarks().front(), "RAWLASER1 is left aside")) << log.remarks().front();
  for (const RecordedMessage& message : messages(log)) {
    if (const auto* read = std::get_if<sensor_msgs::LaserScan::ConstPtr>(&message.content)) {
      EXPECT_EQ((*read)->angle_min, -1.57F);  // of the FLASER too
    }
  }
}

TEST_F(ReadCarmenLog, TellsOfBadLinesWithTheNumberOfTheFirst) {
  std::string text = carmen_log({});
  text.insert(text.find("ODOM 0.05"), "FLASER 3 1 2\nFLASER 3 1 x 3 0 0 0 0 0 0 1 h 1\n");
  const CarmenLog log = open(text);
  ASSERT_EQ(log.remarks().size(), 1U);
  EXPECT_EQ(log.remarks().front(),
            "'" + path_ +
                "': 2 lines, among them perhaps scans, are left out; the first, line 4: 3 words of "
                "readings should follow where 2 are left; it may be cut off");
  EXPECT_EQ(messages(log).size(), 61U);
}

TEST_F(ReadCarmenLog, CutOffInItsLastLineItIsReadUpToThere) {
  const std::string text = carmen_log({});
  for (std::size_t size = text.size() - 60; size < text.size() - 5; ++size) {
    const CarmenLog log = open(text.substr(0, size));
    EXPECT_GE(messages(log).size(), 56U) << size;
    EXPECT_GE(log.begin_time().toSec(), 976052857.0) << size;  // no part of a stamp is one
    for (const std::string& remark : log.remarks()) {
      EXPECT_TRUE(contains(remark, "1 line is left out; line 4")) << remark;
    }
  }
}

TEST_F(ReadCarmenLog, PackedByGzipItIsTheSameAndCutOffReadAsFarAsItGoes) {
  LogRecipe recipe;
  recipe.scans = 5000;
  const std::string packed = compress(carmen_log(recipe));
  EXPECT_EQ(messages(open(packed)).size(), 15001U);
  const CarmenLog log = open(packed.substr(0, packed.size() / 2));
  BagSelection all;
  for (const auto& [number, connection] : log.connections()) {
    all.connections.insert(number);
  }
  const auto messages = log.messages(all);
  std::size_t count = 0;
  const std::string text = error_text<BagError>([&] {
    for (; messages->peek(); ++count) {
      (void)messages->next();
    }
  });
  EXPECT_GT(count, 5000U);
  EXPECT_TRUE(contains(text, path_ + "' is damaged after line ")) << text;
  EXPECT_TRUE(contains(text, "cut off")) << text;
}

TEST_F(ReadCarmenLog, WithoutStampsItTellsThatTheyAreMadeUp) {
  LogRecipe recipe;
  recipe.has_stamps = false;
  const CarmenLog log = open(carmen_log(recipe));
  ASSERT_EQ(log.remarks().size(), 1U);
  EXPECT_TRUE(contains(log.remarks().front(), "made-up ones")) << log.remarks().front();
  EXPECT_DOUBLE_EQ(log.end_time().toSec(), 1000000019.0);
}

TEST_F(ReadCarmenLog, DrivesOfAClockThatWasSetBackAreNotMixed) {
  // A second drive of the same stamps, the log's own clock set back between them.
  const std::string drive = carmen_log({});
  const CarmenLog log = open(drive + drive);
  EXPECT_EQ(log.remarks(),
            (std::vector<std::string>{
                "'" + path_ +
                "': at line 43 its clock was set back by 1.9 s; what follows is read after what "
                "was before"}));
  std::vector<double> stamps;
  ros::Time last;
  for (const RecordedMessage& message : messages(log)) {
    EXPECT_GE(message.time, last);
    last = message.time;
    if (const auto* scan = std::get_if<sensor_msgs::LaserScan::ConstPtr>(&message.content)) {
      stamps.push_back((*scan)->header.stamp.toSec() - 976052857.0);
    }
  }
  ASSERT_EQ(stamps.size(), 40U);
  for (std::size_t k = 0; k < stamps.size(); ++k) {
    EXPECT_NEAR(stamps[k], 0.1 * static_cast<double>(k % 20), 1e-6) << k;
  }
}

TEST_F(ReadCarmenLog, WithoutScansItIsRefused) {
  EXPECT_EQ(error_text<BagError>([&] { (void)open("ODOM 0 0 0 0 0 0 1 h 1\nFLASER 3 1\n"); }),
            "log '" + path_ +
                "' of CARMEN holds no laser's readings; line 2: 3 words of readings should follow "
                "where 1 are left; it may be cut off");
}

}  // namespace
}  // namespace matchbox_slam
