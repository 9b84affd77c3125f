#include <gtest/gtest.h>

#include <cmath>

#include "bag/bag_motion.hpp"
#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {
namespace {

/// A bag in which tf tells where the laser is, and nothing that moves.
class ChooseMotion : public testing::Test {
 protected:
  ChooseMotion() {
    SmallBag recipe;
    recipe.with_transforms = false;
    write_small_bag(path_, recipe);
    rosbag::Bag bag(path_, rosbag::bagmode::Append);
    bag.write("/tf_static", ros::Time(999.9), make_link(0.0, "base_link", "laser", 0.2));
    bag.write("/tf_static", ros::Time(999.9), make_link(0.0, "base_link", "imu_link", 0.1));
  }

  /// @param speed  [m/s]
  void add_odometry(const std::string& topic, double speed, const std::string& child = "base_link",
                    double begin = 1000.0) {
    rosbag::Bag bag(path_, rosbag::bagmode::Append);
    for (int k = 0; k < 100; ++k) {
      nav_msgs::Odometry message;
      message.header.stamp = ros::Time(begin + 0.05 * k);
      message.header.frame_id = "/odom";
      message.child_frame_id = child;
      message.pose.pose.position.x = k == 3 ? NAN : 0.05 * k * speed;
      message.pose.pose.orientation.w = 1.0;
      bag.write(topic, message.header.stamp, message);
    }
  }

  void add_imu(const std::string& topic, const std::string& frame = "imu_link") {
    rosbag::Bag bag(path_, rosbag::bagmode::Append);
    for (int k = 0; k < 100; ++k) {
      sensor_msgs::Imu message;
      message.header.stamp = ros::Time(1000.0 + 0.05 * k);
      message.header.frame_id = frame;
      message.orientation_covariance[0] = -1.0;
      bag.write(topic, message.header.stamp, message);
    }
  }

  BagMotion choose(const RunOptions& options = {}, const AskedFrames& asked = {}) {
    const BagReader reader({path_});
    const BagSurvey survey =
        survey_bag(reader, {"/scan"}, {}, "map", {}, {}, asked.is_laser_placed);
    return choose_motion(reader, survey, asked, {}, options);
  }

  std::string why_not(const RunOptions& options = {}) {
    return error_text<ConfigurationError>([&] { (void)choose(options); });
  }

  TemporaryFolder folder_;
  std::string path_ = folder_ / "small.bag";
};

TEST_F(ChooseMotion, FindsTheOnlyTopicOfOdometryThatMoves) {
  add_odometry("/dead", 0.0);
  add_odometry("/odom", 0.1);
  add_imu("/imu");
  const BagMotion motion = choose();
  EXPECT_EQ(motion.odom_topic, "/odom");
  EXPECT_EQ(motion.frames.base, "base_link");
  EXPECT_EQ(motion.frames.odom, "odom");
  EXPECT_EQ(motion.imu_topic, "");
  EXPECT_EQ(motion.told, "; odometry on topic /odom, of base_link in odom");
}

TEST_F(ChooseMotion, OdometryOnTfComesFirst) {
  write_small_bag(path_);
  add_odometry("/odom", 0.1);
  EXPECT_EQ(choose().odom_topic, "");
  RunOptions asked;
  asked.odom_topic = "odom";
  EXPECT_EQ(choose(asked).odom_topic, "/odom");
}

TEST_F(ChooseMotion, DoesNotChooseBetweenTopicsOfOdometry) {
  add_odometry("/odom", 0.1);
  add_odometry("/odom_filtered", 0.1);
  EXPECT_EQ(why_not(),
            "tf in the bag holds no odometry, and several topics do: /odom, /odom_filtered; choose "
            "one with --odom-topic, or give --no-odom");
  RunOptions asked;
  asked.odom_topic = "/odom_filtered";
  EXPECT_EQ(choose(asked).odom_topic, "/odom_filtered");
  asked.odom_topic = "/wheels";
  EXPECT_EQ(why_not(asked),
            "the bag has no topic '/wheels'; topics with odometry: /odom, /odom_filtered");
}

TEST_F(ChooseMotion, OdometryThatNeverMovesIsNotTakenUnasked) {
  add_odometry("/odom", 0.0);
  EXPECT_EQ(
      why_not(),
      "tf in the bag holds no odometry, and that on /odom does not move in the first minute; "
      "to use it all the same give --odom-topic /odom, to map from the laser alone --no-odom");
}

TEST_F(ChooseMotion, SaysWhoseItIsWhereTheMessagesDoNot) {
  add_odometry("/odom", 0.1, "");
  const BagMotion motion = choose();
  EXPECT_EQ(motion.frames.base, "base_link");
  EXPECT_EQ(motion.told,
            "; odometry on topic /odom, of base_link, as it names no child_frame_id in odom");
}

TEST_F(ChooseMotion, WithoutOdometryTheImuTellsTheTurns) {
  add_imu("/imu");
  const BagMotion motion = choose();
  EXPECT_EQ(motion.imu_topic, "/imu");
  EXPECT_FALSE(motion.frames.odom);
  EXPECT_TRUE(contains(motion.told, "the turn between scans is by the IMU on /imu; --no-odom"));
  RunOptions without;
  without.use_odometry = false;
  EXPECT_EQ(choose(without).imu_topic, "");
  EXPECT_TRUE(contains(choose(without).told, "--set imu_topic=/imu"));
  without.imu_topic = "imu";
  EXPECT_EQ(choose(without).imu_topic, "/imu");
}

TEST_F(ChooseMotion, AnImuThatHasNoPlaceInTfIsNotTaken) {
  add_imu("/imu", "elsewhere");
  EXPECT_TRUE(contains(why_not(), "to map from the laser alone give --no-odom"));
}

TEST_F(ChooseMotion, WhereTheLaserIsPlacedTheOdometryNeedNotCarryIt) {
  SmallBag recipe;
  recipe.laser_frame = "arm";  // which tf has; the scans are of another
  write_small_bag(path_, recipe);
  {
    rosbag::Bag bag(path_, rosbag::bagmode::Append);
    for (int k = 0; k < 20; ++k) {
      bag.write("/other", ros::Time(1000.0 + 0.1 * k), make_scan(1000.0 + 0.1 * k, "lidar"));
    }
  }
  const BagReader reader({path_});
  const BagSurvey survey = survey_bag(reader, {"/other"}, {}, "map", {}, {}, true);
  const BagMotion motion = choose_motion(reader, survey, {{}, {}, true}, {}, {});
  EXPECT_EQ(motion.frames.base, "base_link");
  EXPECT_EQ(motion.frames.odom, "odom");
  EXPECT_EQ(
      error_text<ConfigurationError>([&] { (void)choose_motion(reader, survey, {}, {}, {}); }),
      "tf in the bag says nothing of the scan's frame 'lidar', so there is no odometry; to "
      "map from the laser alone give --no-odom, or say where the laser is on the robot with "
      "--laser-pose X,Y,YAW; tf has arm, base_link, odom");
}

}  // namespace
}  // namespace matchbox_slam
