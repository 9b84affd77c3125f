// Of ros/scan_queue.hpp: the motion that comes with a scan, by tf, a topic or an IMU, and lasers
// that are tilted.

#include <gtest/gtest.h>
#include <tf2_eigen/tf2_eigen.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "ros/messages.hpp"
#include "ros/scan_feed.hpp"
#include "ros/scan_queue.hpp"

namespace matchbox_slam {
namespace {

nav_msgs::Odometry odometry_message(double stamp, const std::string& child = "base") {
  nav_msgs::Odometry message;
  message.header.stamp = ros::Time(stamp);
  message.header.frame_id = "/odom";
  message.child_frame_id = child;
  message.pose.pose.position.x = stamp;
  message.pose.pose.orientation.w = 1.0;
  return message;
}

TEST(ScanQueue, TakesOdometryFromItsTopicWhateverTfSaysOfItsFrames) {
  ScanQueueSettings by_topic = settings();
  by_topic.odometry_by_topic = true;
  Feed feed(by_topic);
  feed.laser();
  // Of the same frames, elsewhere; and the child hangs on the robot already.
  feed.odometry(99.0);
  feed.queue.add_transforms(make_link(0.0, "base", "wheels", -0.5), true, ros::Time(99.0));
  feed.scan(100.5);
  EXPECT_EQ(feed.queue.add_odometry(odometry_message(100.0, "wheels"), ros::Time(100.5)), "");
  EXPECT_EQ(feed.ready(), Stamps{});
  EXPECT_EQ(feed.queue.add_odometry(odometry_message(101.0, "/wheels"), ros::Time(101.0)), "");
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  EXPECT_NEAR(input_of(*item).odometry->odom_from_base.x, 100.5 + 0.5, 1e-9);
  EXPECT_NEAR(input_of(*item).base_from_laser.translation().x(), 0.2, 1e-12);
  EXPECT_TRUE(std::get<ReadyScan>(*item).is_odometry_in_tf);  // by the link of 99 s
}

TEST(ScanQueue, OdometryThatNamesNoFramesIsThatOfTheBase) {
  ScanQueueSettings by_topic = settings();
  by_topic.odometry_by_topic = true;
  Feed feed(by_topic);
  feed.laser();
  feed.scan(100.5);
  for (const double stamp : {100.0, 101.0}) {
    nav_msgs::Odometry message = odometry_message(stamp, "");
    message.header.frame_id = "";
    EXPECT_EQ(feed.queue.add_odometry(message, ros::Time(stamp)), "");
  }
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  EXPECT_NEAR(input_of(*item).odometry->odom_from_base.x, 100.5, 1e-9);
  EXPECT_FALSE(std::get<ReadyScan>(*item).is_odometry_in_tf);
}

TEST(ScanQueue, CountsOdometryThatIsNoneAndSaysWhy) {
  ScanQueueSettings by_topic = settings();
  by_topic.odometry_by_topic = true;
  Feed feed(by_topic);
  feed.laser();
  const auto defect_of = [&](const std::function<void(nav_msgs::Odometry&)>& spoil) {
    nav_msgs::Odometry message = odometry_message(100.0);
    spoil(message);
    return feed.queue.add_odometry(message, ros::Time(100.0));
  };
  EXPECT_EQ(defect_of([](auto& message) { message.pose.pose.position.y = NAN; }),
            "its position is no number");
  EXPECT_EQ(defect_of([](auto& message) { message.pose.pose.orientation.w = 0.5; }),
            "its orientation is no quaternion of length 1");
  EXPECT_EQ(defect_of([](auto& message) { message.header.stamp = ros::Time(); }),
            "its stamp is none");
  EXPECT_EQ(defect_of([](auto& message) { message.header.frame_id = "world"; }),
            "its frame is 'world' and odom_frame is 'odom': they have to be the same");
  EXPECT_EQ(defect_of([](auto& /*message*/) {}), "");
  EXPECT_EQ(defect_of([](auto& message) { message.child_frame_id = "arm"; }),
            "its child_frame_id is 'arm', and 'base' before");
  EXPECT_EQ(feed.queue.invalid_odometry(), 5U);
  feed.scan(102.0);
  feed.queue.finish();
  EXPECT_TRUE(contains(feed.queue.take_skipped().front().text,
                       "no pose on the topic of odometry at 102.000: the newest is 2.000 s older"));
}

/// What a queue says of a scan that never gets its transforms.
std::string skip_text(const ScanQueueSettings& settings, const tf2_msgs::TFMessage& links) {
  Feed feed(settings);
  feed.queue.add_transforms(links, true, ros::Time(99.0));
  feed.scan(100.0);
  feed.queue.finish();
  const std::vector<SkippedScan> skipped = feed.queue.take_skipped();
  return skipped.empty() ? "" : skipped.front().text;
}

TEST(ScanQueue, SaysWhatToTypeWhereTfHasNoWayBetweenFrames) {
  ScanQueueSettings of_node = settings();
  ScanQueueSettings of_bag = settings();
  of_bag.is_live = false;
  const tf2_msgs::TFMessage no_laser = make_link(0.0, "odom", "base", 1.0);
  EXPECT_TRUE(contains(skip_text(of_node, no_laser),
                       "tf has no frame 'laser'; it has base, odom; if base_frame is right, say "
                       "where the laser is on it with laser_pose:=X,Y,YAW"));
  EXPECT_TRUE(contains(skip_text(of_bag, no_laser), "with --laser-pose X,Y,YAW"));
  const tf2_msgs::TFMessage no_odometry = make_link(0.0, "base", "laser", 1.0);
  EXPECT_TRUE(contains(skip_text(of_node, no_odometry),
                       "tf has no frame 'odom'; it has base, laser; set odom_frame and base_frame "
                       "to frames that there are, or odom_topic to a topic of nav_msgs/Odometry, "
                       "or use_odometry to false"));
  EXPECT_TRUE(contains(skip_text(of_bag, no_odometry),
                       "give frames that there are as --odom-frame and --base-frame, or a topic of "
                       "nav_msgs/Odometry as --odom-topic, or --no-odom"));
}

TEST(ScanQueue, LasersAreWhereTheyAreSaidToBe) {
  ScanQueueSettings told = settings();
  told.odom_frame.reset();
  told.lasers = 2;
  told.laser_poses = {Eigen::Isometry3d(Eigen::Translation3d(0.4, -0.1, 0.0) *
                                        Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()))};
  Feed feed(told);
  feed.laser();  // tf has it elsewhere: for the second one that holds
  feed.scan_of(0, 100.0, 100.0);
  feed.scan_of(1, 100.01, 100.0);
  feed.queue.finish();
  const auto first = feed.queue.next();
  const auto second = feed.queue.next();
  ASSERT_TRUE(first && second);
  EXPECT_NEAR(input_of(*first).base_from_laser.translation().x(), 0.4, 1e-12);
  EXPECT_NEAR(project_to_plane(input_of(*first).base_from_laser).theta, 0.3, 1e-12);
  EXPECT_NEAR(input_of(*second).base_from_laser.translation().x(), 0.2, 1e-12);
}

TEST(ScanQueue, SaysOnceThatTfHasALaserElsewhereThanItIsSaidToBe) {
  for (const bool is_live : {true, false}) {
    for (const double said : {0.4, 0.2}) {
      ScanQueueSettings told = settings();
      told.odom_frame.reset();
      told.is_live = is_live;
      told.laser_poses = {Eigen::Isometry3d(Eigen::Translation3d(said, 0.0, 0.0))};
      Feed feed(told);
      feed.scan_at(100.0, 100.0);
      feed.scan_at(100.1, 100.1);
      EXPECT_TRUE(feed.queue.take_news().empty());  // tf says nothing yet
      feed.laser();
      feed.scan_at(100.2, 100.2);
      feed.scan_at(100.3, 100.3);
      feed.queue.finish();
      std::vector<std::string> expected;
      if (said == 0.4) {
        expected.push_back(std::string("tf has laser at 0.200,0.000,0.000 on base; ") +
                           (is_live ? "laser_pose" : "--laser-pose") +
                           " 0.400,0.000,0.000 is used instead");
      }
      EXPECT_EQ(feed.queue.take_news(), expected);
    }
  }
}

TEST(ScanQueue, WithoutOdometryAnImuTellsTheHeading) {
  ScanQueueSettings by_imu = settings();
  by_imu.odom_frame.reset();
  by_imu.use_imu = true;
  by_imu.heading_by_imu = true;
  for (const bool has_orientation : {true, false}) {
    Feed feed(by_imu);
    feed.laser();
    // It hangs with its y axis up.
    geometry_msgs::TransformStamped mount = make_transform(0.0, "base", "imu", 0.3);
    mount.transform.rotation =
        tf2::toMsg(Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitX())));
    feed.queue.add_transforms(make_transforms({mount}), true, ros::Time(99.0));
    constexpr double kRate = 0.5;  // rad/s
    for (int k = 0; k <= 20; ++k) {
      sensor_msgs::Imu message;
      message.header.stamp = ros::Time(100.0 + 0.1 * k);
      message.header.frame_id = "imu";
      message.angular_velocity.y = kRate;
      if (has_orientation) {
        message.orientation = tf2::toMsg(
            Eigen::Quaterniond(Eigen::AngleAxisd(1.0 + 0.1 * k * kRate, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitX())));
      }
      EXPECT_EQ(feed.queue.add_imu(message, ros::Time(100.0 + 0.1 * k)), "");
    }
    feed.scan_at(100.25, 102.0);
    feed.scan_at(101.25, 102.0);
    const auto first = feed.queue.next();
    const auto second = feed.queue.next();
    ASSERT_TRUE(first && second);
    EXPECT_TRUE(input_of(*first).odometry->is_heading_only);
    EXPECT_NEAR(input_of(*second).odometry->odom_from_base.theta -
                    input_of(*first).odometry->odom_from_base.theta,
                kRate, 1e-6);
    EXPECT_EQ(input_of(*first).odometry->odom_from_base.x, 0.0);
    EXPECT_LT(tilt_of(input_of(*first).base_from_laser), 1e-9);
  }
}

TEST(ScanQueue, AnImuOfRatesAloneHasToHaveAPlaceInTf) {
  ScanQueueSettings by_imu = settings();
  by_imu.heading_by_imu = true;
  Feed feed(by_imu);
  sensor_msgs::Imu message;
  message.header.stamp = ros::Time(100.0);
  message.header.frame_id = "imu";
  EXPECT_EQ(feed.queue.add_imu(message, ros::Time(100.0)),
            "until tf says how it is mounted, which takes a way from 'imu' to 'base'");
  message.angular_velocity_covariance[0] = -1.0;
  EXPECT_EQ(feed.queue.add_imu(message, ros::Time(100.0)),
            "it measures neither orientation nor rate of turn: both covariances begin with -1");
}

/// A link that leans by some angle about an axis.
tf2_msgs::TFMessage leaning(double stamp, const std::string& parent, const std::string& child,
                            double angle, const Eigen::Vector3d& axis, double yaw = 0.0) {
  geometry_msgs::TransformStamped link = make_transform(stamp, parent, child, 0.2);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(angle, axis));
  link.transform.rotation.x = turn.x();
  link.transform.rotation.y = turn.y();
  link.transform.rotation.z = turn.z();
  link.transform.rotation.w = turn.w();
  return make_transforms({link});
}

TEST(ScanQueue, ABaseThatLeansComesOutUprightWithALaserThatLeans) {
  Feed feed(settings());
  feed.laser();
  sensor_msgs::LaserScan scan = make_scan(100.0);
  scan.time_increment = 0.1F / 89.0F;
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  feed.queue.add_transforms(leaning(100.0, "odom", "base", 0.10, y, 2.0), false, ros::Time(100.0));
  feed.queue.add_transforms(leaning(100.2, "odom", "base", 0.16, y, 2.0), false, ros::Time(100.2));
  feed.queue.add_scan(scan, ros::Time(100.2));
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  const ScanInput& input = std::get<ReadyScan>(*item).input;
  EXPECT_NEAR(input.odometry->odom_from_base.theta, 2.0, 1e-9);
  const Eigen::Matrix3d first = Eigen::AngleAxisd(0.10, y).toRotationMatrix();
  EXPECT_TRUE(input.base_from_laser.linear().isApprox(first, 1e-9));
  EXPECT_NEAR(input.base_from_laser.translation().z(), -0.2 * std::sin(0.10), 1e-9);
  const Eigen::Matrix3d last = Eigen::AngleAxisd(0.13, y).toRotationMatrix();
  EXPECT_TRUE((input.base_from_laser * input.laser_motion).linear().isApprox(last, 1e-6));
}

/// An IMU lying on its side on the base, `leaning` with it.
sensor_msgs::Imu imu_message(double stamp, const Eigen::Quaterniond& leaning) {
  const Eigen::Quaterniond side(Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitX()));
  sensor_msgs::Imu message;
  message.header.stamp = ros::Time(stamp);
  message.header.frame_id = "imu";
  message.orientation = tf2::toMsg(Eigen::Quaterniond(leaning * side));
  return message;
}

TEST(ScanQueue, TakesRollAndPitchFromAnImuWhereTheOdometryShowsNone) {
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  for (const bool has_odometry : {true, false}) {
    for (const double shown : {0.0, 0.05}) {
      ScanQueueSettings by_imu = settings();
      by_imu.use_imu = true;
      if (!has_odometry) {
        by_imu.odom_frame.reset();
      }
      Feed feed(by_imu);
      feed.laser();
      for (const double stamp : {100.0, 100.2}) {
        feed.queue.add_transforms(leaning(stamp, "odom", "base", shown, y, 2.0), false,
                                  ros::Time(stamp));
      }
      sensor_msgs::LaserScan scan = make_scan(100.0);
      scan.time_increment = 0.1F / 89.0F;
      feed.queue.add_scan(scan, ros::Time(100.2));
      const auto add_imu = [&](double stamp, double pitch) {
        const Eigen::Quaterniond leans(Eigen::AngleAxisd(-1.0, Eigen::Vector3d::UnitZ()) *
                                       Eigen::AngleAxisd(pitch, y));
        EXPECT_EQ(feed.queue.add_imu(imu_message(stamp, leans), ros::Time(100.2)), "");
      };
      add_imu(100.0, 0.10);
      add_imu(100.2, 0.16);
      EXPECT_FALSE(feed.queue.next()) << "tf does not say how it is mounted";
      feed.queue.add_transforms(leaning(0.0, "base", "imu", 0.5 * kPi, Eigen::Vector3d::UnitX()),
                                true, ros::Time(100.2));
      const auto item = feed.queue.next();
      ASSERT_TRUE(item);
      const ScanInput& input = std::get<ReadyScan>(*item).input;
      const bool by_tf = has_odometry && shown > 0.0;
      const Eigen::Matrix3d first = Eigen::AngleAxisd(by_tf ? shown : 0.10, y).toRotationMatrix();
      EXPECT_TRUE(input.base_from_laser.linear().isApprox(first, 1e-9)) << shown;
      const Eigen::Matrix3d last = Eigen::AngleAxisd(by_tf ? shown : 0.13, y).toRotationMatrix();
      EXPECT_TRUE((input.base_from_laser * input.laser_motion).linear().isApprox(last, 1e-6));
      EXPECT_EQ(input.odometry.has_value(), has_odometry);
    }
  }
}

TEST(ScanQueue, AScanThatIsSkippedTellsNothingOfTheSweep) {
  ScanQueueSettings without_odometry = settings();
  without_odometry.odom_frame.reset();
  Feed feed(without_odometry);
  feed.laser();
  feed.queue.add_transforms(make_link(0.0, "base", "far", 5000.0), true, ros::Time(100.0));
  const auto scan = [&](double stamp, const std::string& frame) {
    sensor_msgs::LaserScan message = make_scan(stamp);  // of an RPLidar: it tells no times
    message.header.frame_id = frame;
    message.angle_min = static_cast<float>(-kPi);
    message.angle_increment =
        static_cast<float>(2.0 * kPi / static_cast<double>(message.ranges.size()));
    message.time_increment = 0.0F;
    message.scan_time = 0.0F;
    feed.queue.add_scan(message, ros::Time(stamp));
    return feed.ready();
  };
  for (int k = 0; k < 6; ++k) {
    scan(100.0 + 0.2 * k, "laser");
  }
  EXPECT_TRUE(scan(101.2, "far").empty());
  EXPECT_EQ(feed.skipped(SkipReason::kInvalid), 1U);
  EXPECT_EQ(scan(101.2, "laser").size(), 1U);
}

TEST(ScanQueue, WaitsForTheLastBeamOfALaserThatIsTilted) {
  ScanQueueSettings tilted = settings();
  tilted.projection.max_tilt = 0.5;
  Feed feed(tilted);
  feed.odometry(100.0);
  feed.odometry(101.0);
  sensor_msgs::LaserScan scan = make_scan(100.0);
  scan.time_increment = 0.1F / 89.0F;
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  feed.queue.add_transforms(leaning(100.0, "base", "laser", 0.1, y), false, ros::Time(101.0));
  feed.queue.add_scan(scan, ros::Time(101.0));
  EXPECT_EQ(feed.queue.waiting(), 1U);
  EXPECT_FALSE(feed.queue.next());
  feed.queue.add_transforms(leaning(100.2, "base", "laser", 0.2, y), false, ros::Time(101.0));
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  const ScanInput& input = std::get<ReadyScan>(*item).input;
  EXPECT_NEAR(tilt_of(input.base_from_laser), 0.1, 1e-9);
  EXPECT_NEAR(tilt_of(input.base_from_laser * input.laser_motion), 0.15, 1e-6);
}

TEST(ScanQueue, SkipsScansThatAreTiltedTooMuch) {
  ScanQueueSettings limited = settings();
  limited.projection.max_tilt = 0.2;
  Feed feed(limited);
  feed.odometry(100.0);
  feed.odometry(103.0);
  const auto scan_at_tilt = [&](double stamp, double tilt) {
    feed.queue.add_transforms(leaning(stamp, "base", "laser", tilt, Eigen::Vector3d::UnitX()),
                              false, ros::Time(103.0));
    feed.scan_at(stamp, 103.0);
  };
  scan_at_tilt(101.0, 0.19);
  scan_at_tilt(101.5, 0.25);
  scan_at_tilt(102.0, kPi - 0.19);  // upside down
  EXPECT_EQ(feed.ready(), (Stamps{101.0, 102.0}));
  const std::vector<SkippedScan> skipped = feed.queue.take_skipped();
  ASSERT_EQ(skipped.size(), 1U);
  EXPECT_EQ(skipped[0].text,
            "scan of 101.500 s skipped (tilted): its plane is tilted by 0.250 rad; "
            "scan/max_tilt allows 0.200");
  feed.queue.set_limits(0.0, 0.3);
  scan_at_tilt(102.5, 0.25);
  EXPECT_EQ(feed.ready(), Stamps{102.5});
}

}  // namespace
}  // namespace matchbox_slam
