#include <gtest/gtest.h>
#include <tf2_eigen/tf2_eigen.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "ros/messages.hpp"
#include "ros/scan_queue.hpp"

namespace matchbox_slam {
namespace {

ScanQueueSettings settings() {
  ScanQueueSettings settings;
  settings.base_frame = "base";
  settings.odom_frame = "odom";
  settings.map_frame = "map";
  return settings;
}

/// A queue that is fed by stamps and asked for the stamps that come out.
class Feed {
 public:
  explicit Feed(const ScanQueueSettings& settings) : queue(settings) {}

  void scan(double stamp) { scan_at(stamp, stamp); }
  void scan_at(double stamp, double now) { queue.add_scan(make_scan(stamp), ros::Time(now)); }

  void scan_of(int laser, double stamp, double now) {
    queue.add_scan(make_scan(stamp), ros::Time(now), laser);
  }

  void odometry(double stamp) { odometry_at(stamp, stamp); }
  void odometry_at(double stamp, double now) {
    queue.add_transforms(make_link(stamp, "odom", "base", stamp), false, ros::Time(now));
  }
  void laser() {
    queue.add_transforms(make_link(0.0, "base", "laser", 0.2), true, ros::Time(100.0));
  }

  std::vector<double> ready() {
    std::vector<double> stamps;
    while (const auto item = queue.next()) {
      if (std::holds_alternative<LeftOut>(*item)) {
        continue;
      }
      const auto* scan = std::get_if<ReadyScan>(&*item);
      stamps.push_back(scan != nullptr ? scan->stamp.toSec() : -std::get<TimeJump>(*item).seconds);
    }
    return stamps;
  }

  [[nodiscard]] std::size_t skipped(SkipReason reason) const {
    const auto found = queue.account().skipped.find(reason);
    return found == queue.account().skipped.end() ? 0 : found->second;
  }

  void expect_all_accounted_for() const {
    const ScanAccount& account = queue.account();
    EXPECT_EQ(account.received, account.delivered + account.skipped_total() + queue.waiting());
  }

  ScanQueue queue;
};

using Stamps = std::vector<double>;

TEST(ScanQueue, WaitsUntilTransformsCoverTheScan) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.scan(100.5);
  EXPECT_EQ(feed.ready(), Stamps{});
  feed.odometry(100.4);
  EXPECT_EQ(feed.ready(), Stamps{});
  feed.odometry(100.6);
  EXPECT_EQ(feed.ready(), Stamps{100.5});
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, WaitsForTheLastBeam) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  sensor_msgs::LaserScan scan = make_scan(100.5);
  scan.time_increment = 0.002F;  // 0.178 s in all
  feed.queue.add_scan(scan, ros::Time(100.7));
  feed.odometry(100.6);
  EXPECT_EQ(feed.ready(), Stamps{});
  feed.odometry(100.7);
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  const ScanInput& input = std::get<ReadyScan>(*item).input;
  EXPECT_NEAR(input.odometry->odom_from_base.x, 100.5, 1e-9);
  EXPECT_NEAR(input.odometry->odom_from_base_last_beam.x, 100.678, 1e-6);
  EXPECT_NEAR(input.base_from_laser.translation().x(), 0.2, 1e-12);
}

nav_msgs::Odometry odometry_message(double stamp, const std::string& child = "base") {
  nav_msgs::Odometry message;
  message.header.stamp = ros::Time(stamp);
  message.header.frame_id = "/odom";
  message.child_frame_id = child;
  message.pose.pose.position.x = stamp;
  message.pose.pose.orientation.w = 1.0;
  return message;
}

const ScanInput& input_of(const ScanQueue::Item& item) { return std::get<ReadyScan>(item).input; }

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
  feed.expect_all_accounted_for();
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

TEST(ScanQueue, WaitsForTheLastBeamOfALaserThatIsTilted) {
  Feed feed(settings());
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
  limited.max_tilt = 0.2;
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
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, TheResultDoesNotDependOnHowMessagesInterleave) {
  Feed late_scans(settings());
  Feed late_transforms(settings());
  for (Feed* feed : {&late_scans, &late_transforms}) {
    feed->laser();
  }
  for (int k = 0; k < 20; ++k) {
    late_scans.odometry_at(100.0 + 0.07 * k, 100.0 + 0.07 * k);
    late_transforms.scan_at(100.05 + 0.05 * k, 100.05 + 0.05 * k);
  }
  for (int k = 0; k < 20; ++k) {
    late_scans.scan_at(100.05 + 0.05 * k, 101.4 + 0.05 * k);
    late_transforms.odometry_at(100.0 + 0.07 * k, 101.05 + 0.05 * k);
  }
  const Stamps stamps = late_scans.ready();
  EXPECT_EQ(stamps.size(), 20U);
  EXPECT_EQ(late_transforms.ready(), stamps);
}

TEST(ScanQueue, SkipsAScanWithoutTransformAfterTheTimeout) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.scan(100.5);
  feed.odometry_at(100.2, 102.4);
  EXPECT_TRUE(feed.queue.take_skipped().empty());
  feed.odometry_at(100.3, 102.6);
  const std::vector<SkippedScan> skipped = feed.queue.take_skipped();
  ASSERT_EQ(skipped.size(), 1U);
  EXPECT_EQ(skipped[0].reason, SkipReason::kNoTransform);
  EXPECT_EQ(skipped[0].text,
            "scan of 100.500 s skipped (no_transform): no transform from 'base' to 'odom' at "
            "100.500: the newest is 0.200 s older");
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, SkipsScansWhenItsFramesAreSwapped) {
  ScanQueueSettings swapped = settings();
  std::swap(swapped.base_frame, *swapped.odom_frame);
  Feed feed(swapped);
  feed.laser();
  feed.odometry(100.0);
  feed.scan(100.0);
  EXPECT_EQ(feed.ready(), Stamps{});
  const std::vector<SkippedScan> skipped = feed.queue.take_skipped();
  ASSERT_EQ(skipped.size(), 1U);
  EXPECT_EQ(skipped[0].text,
            "scan of 100.000 s skipped (no_transform): odometry frame 'base' lies below base frame "
            "'odom' in tf; are the two swapped?");
}

TEST(ScanQueue, WaitingScansAreSkippedAtTheEnd) {
  Feed feed(settings());
  feed.scan(100.0);
  feed.queue.finish();
  EXPECT_EQ(feed.ready(), Stamps{});
  EXPECT_EQ(feed.skipped(SkipReason::kNoTransform), 1U);
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, BringsWaitingScansIntoOrder) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.scan_at(100.3, 100.4);
  feed.scan_at(100.2, 100.4);
  feed.odometry(100.5);
  EXPECT_EQ(feed.ready(), (Stamps{100.2, 100.3}));
}

TEST(ScanQueue, CountsDuplicatesAndScansThatComeTooLate) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry(101.0);
  for (const double stamp : {100.5, 100.5, 100.4, 100.6}) {
    feed.scan_at(stamp, 101.0);
  }
  EXPECT_EQ(feed.ready(), (Stamps{100.5, 100.6}));
  EXPECT_EQ(feed.skipped(SkipReason::kDuplicateStamp), 1U);
  EXPECT_EQ(feed.skipped(SkipReason::kOutOfOrder), 1U);
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, CountsScansThatAreNone) {
  Feed feed(settings());
  sensor_msgs::LaserScan scan = make_scan(100.0);
  scan.ranges.clear();
  feed.queue.add_scan(scan, ros::Time(100.0));
  scan = make_scan(100.1);
  scan.angle_increment = 0.0F;
  feed.queue.add_scan(scan, ros::Time(100.1));
  EXPECT_EQ(feed.skipped(SkipReason::kEmpty), 1U);
  EXPECT_EQ(feed.skipped(SkipReason::kInvalid), 1U);
  EXPECT_TRUE(contains(feed.queue.take_skipped().at(1).text, "angle_increment is 0"));
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, SkipsScansThatWouldBeTornOverTheMap) {
  Feed feed(settings());
  feed.queue.add_transforms(make_link(0.0, "base", "laser", 1001.0), true, ros::Time(100.0));
  feed.odometry(100.0);
  feed.odometry(101.0);
  feed.scan_at(100.5, 101.0);
  EXPECT_TRUE(contains(feed.queue.take_skipped().at(0).text, "m from the base; allowed: up to"));
  feed.laser();
  sensor_msgs::LaserScan scan = make_scan(101.5);
  scan.time_increment = 0.002F;  // 0.178 s in all
  feed.queue.add_scan(scan, ros::Time(101.7));
  feed.queue.add_transforms(make_link(102.0, "odom", "base", 9e6), false, ros::Time(102.0));
  EXPECT_TRUE(contains(feed.queue.take_skipped().at(0).text, "while it is taken"));
  EXPECT_EQ(feed.ready(), Stamps{});
  EXPECT_EQ(feed.skipped(SkipReason::kInvalid), 2U);
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, TheFrameMayChangeFromScanToScan) {
  Feed feed(settings());
  feed.laser();
  feed.queue.add_transforms(make_link(0.0, "base", "other", -0.3), true, ros::Time(100.0));
  feed.odometry(100.0);
  feed.odometry(101.0);
  feed.scan_at(100.5, 101.0);
  feed.queue.add_scan(make_scan(100.6, "/other", 17), ros::Time(101.0));
  (void)feed.queue.next();
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  const auto& scan = std::get<ReadyScan>(*item);
  EXPECT_EQ(scan.frame, "other");
  EXPECT_NEAR(scan.input.base_from_laser.translation().x(), -0.3, 1e-12);
  EXPECT_EQ(scan.input.scan.ranges.size(), 17U);
}

TEST(ScanQueue, WithoutOdometryTheLaserIsEnough) {
  ScanQueueSettings without = settings();
  without.odom_frame.reset();
  without.base_frame = "laser";
  Feed feed(without);
  feed.scan(100.0);
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  const ScanInput& input = std::get<ReadyScan>(*item).input;
  EXPECT_FALSE(input.odometry);
  EXPECT_TRUE(input.base_from_laser.isApprox(Eigen::Isometry3d::Identity()));
}

TEST(ScanQueue, AddsTheOffsetToTheStampsOfScans) {
  ScanQueueSettings offset = settings();
  offset.scan_time_offset = ros::Duration(82.5);
  Feed feed(offset);
  feed.laser();
  feed.odometry(182.0);
  feed.odometry(183.0);
  feed.scan_at(100.0, 183.0);
  const auto item = feed.queue.next();
  ASSERT_TRUE(item);
  EXPECT_DOUBLE_EQ(std::get<ReadyScan>(*item).input.scan.stamp, 182.5);
  offset.scan_time_offset = ros::Duration(-200.0);
  Feed before_time(offset);
  before_time.scan(100.0);
  EXPECT_EQ(before_time.skipped(SkipReason::kInvalid), 1U);
}

TEST(ScanQueue, StartsAnewWhenTheClockJumpsBack) {
  Feed feed(settings());
  feed.laser();
  for (const double begin : {100.0, 50.0}) {
    feed.odometry(begin);
    feed.scan(begin + 0.1);
    feed.odometry(begin + 0.2);
  }
  feed.scan(50.3);
  EXPECT_EQ(feed.ready(), (Stamps{100.1, -50.2, 50.1}));
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, StartsAnewWhenStampsJumpBack) {
  Feed feed(settings());
  feed.laser();
  feed.odometry_at(100.0, 200.0);
  feed.odometry_at(100.2, 200.0);
  feed.scan_at(100.1, 200.0);
  for (const double stamp : {50.1, 50.2, 50.3}) {
    feed.scan_at(stamp, 200.1);
  }
  feed.odometry_at(50.0, 200.2);
  feed.odometry_at(50.4, 200.3);
  EXPECT_EQ(feed.ready(), (Stamps{100.1, -49.8, 50.3}));
  EXPECT_EQ(feed.skipped(SkipReason::kOutOfOrder), 2U) << "the two before it was certain";
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, SingleScansWithAnOldStampAreNoTimeJump) {
  Feed feed(settings());
  feed.laser();
  feed.odometry_at(100.0, 200.0);
  feed.odometry_at(110.0, 200.0);
  for (const double stamp :
       {100.1, 50.1, 100.2, 50.2, 50.3, 100.3, 50.4, 50.4, 50.3, 50.2, 100.4}) {
    feed.scan_at(stamp, 200.0);
  }
  EXPECT_EQ(feed.ready(), (Stamps{100.1, 100.2, 100.3, 100.4}));
  EXPECT_EQ(feed.skipped(SkipReason::kOutOfOrder), 7U);
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, AScanWithAStampFarAheadIsNoTimeJump) {
  ScanQueueSettings without = settings();
  without.odom_frame.reset();
  without.base_frame = "laser";
  Feed feed(without);
  feed.scan_at(100.0, 200.0);
  feed.scan_at(3.9e9, 200.1);
  for (const double stamp : {100.1, 100.2, 100.3, 100.4}) {
    feed.scan_at(stamp, stamp + 100.0);
  }
  EXPECT_EQ(feed.ready(), (Stamps{100.0, 100.1, 100.2, 100.3, 100.4}));
  EXPECT_EQ(feed.skipped(SkipReason::kOutOfOrder), 1U);
  for (const double stamp : {5000.0, 5000.1, 5000.2}) {  // another clock
    feed.scan_at(stamp, 300.0);
  }
  EXPECT_EQ(feed.ready(), Stamps{5000.2});
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, TimesAreComparedAcrossAllThatAStampCanHold) {
  Feed feed(settings());
  feed.scan_at(1.0, 4e9);
  feed.scan_at(4e9, 4e9);
  feed.scan_at(2.0, 1.0);
  feed.queue.finish();
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, CountsWhatAResetDiscards) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry(101.0);
  feed.scan_at(100.1, 101.0);
  feed.scan_at(100.2, 101.0);
  feed.queue.discard_delivered();
  EXPECT_EQ(feed.skipped(SkipReason::kBeforeReset), 0U) << "they wait to be delivered";
  EXPECT_EQ(feed.ready(), (Stamps{100.1, 100.2}));
  feed.queue.discard_delivered();
  EXPECT_EQ(feed.skipped(SkipReason::kBeforeReset), 2U);
  EXPECT_EQ(feed.queue.account().delivered, 0U);
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, CountsAScanThatIsLeftOutWhilePaused) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry(101.0);
  feed.scan_at(100.1, 101.0);
  feed.scan_at(100.2, 101.0);
  const auto first = feed.queue.next();
  ASSERT_TRUE(first);
  feed.queue.leave_out(std::get<ReadyScan>(*first));
  EXPECT_EQ(feed.ready(), Stamps{100.2});
  EXPECT_EQ(feed.skipped(SkipReason::kPaused), 1U);
  EXPECT_EQ(feed.queue.account().delivered, 1U);
  feed.expect_all_accounted_for();
}

/// For each item, its stamp, or the place of its kind among RunEvent's with a minus sign.
std::vector<double> order_of_items(ScanQueue& queue) {
  std::vector<double> order;
  while (const auto item = queue.next()) {
    if (const auto* scan = std::get_if<ReadyScan>(&*item)) {
      order.push_back(scan->stamp.toSec());
    } else {
      order.push_back(-static_cast<double>(std::get<RunEvent>(*item).index()));
    }
  }
  return order;
}

TEST(ScanQueue, AnEventComesAfterTheScansThatWereReady) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry(100.25);
  feed.scan_at(100.1, 100.3);
  feed.scan_at(100.2, 100.3);
  feed.scan_at(100.3, 100.3);  // its transforms come after the event
  feed.queue.add_event(Pause{true});
  feed.odometry_at(101.0, 100.4);
  EXPECT_EQ(order_of_items(feed.queue), (std::vector<double>{100.1, 100.2, -4.0, 100.3}));
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, AnEventThatGivesUpTheMapWaitsForNoScan) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry(101.0);
  feed.scan_at(100.1, 101.0);
  feed.queue.add_event(Pause{true});
  feed.scan_at(100.2, 101.0);
  feed.queue.add_event(Reset{});
  feed.scan_at(100.3, 101.0);
  EXPECT_EQ(order_of_items(feed.queue), (std::vector<double>{-4.0, -2.0, 100.3}));
  EXPECT_EQ(feed.skipped(SkipReason::kBeforeReset), 2U);
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, AnInterruptLeavesNothingAndCountsAll) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry(100.25);
  feed.scan_at(100.1, 100.3);
  feed.scan_at(100.2, 100.3);
  feed.scan_at(100.3, 100.3);  // without transforms
  ASSERT_TRUE(feed.queue.next());
  feed.queue.add_event(Pause{true});
  feed.queue.interrupt();
  EXPECT_FALSE(feed.queue.next());
  EXPECT_EQ(feed.queue.waiting(), 0U);
  EXPECT_EQ(feed.skipped(SkipReason::kInterrupted), 2U);
  EXPECT_EQ(feed.queue.account().delivered, 1U);
  EXPECT_EQ(to_string(feed.queue.account()),
            "3 scans received, 1 used, 2 skipped (interrupted: 2)");
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, StopsWhenTimeJumpsBackIfAskedTo) {
  ScanQueueSettings stop = settings();
  stop.stop_at_time_jump = true;
  Feed feed(stop);
  feed.laser();
  feed.odometry(100.0);
  feed.odometry(100.2);
  feed.scan_at(100.1, 100.2);
  for (const double stamp : {50.1, 50.2, 50.3}) {
    feed.scan_at(stamp, 100.3);
  }
  const auto first = feed.queue.next();
  const auto second = feed.queue.next();
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(std::get<TimeJump>(*second).stopped);
  EXPECT_EQ(feed.skipped(SkipReason::kStopped), 1U);
  EXPECT_TRUE(feed.queue.stopped());
  feed.queue.start_again();
  EXPECT_FALSE(feed.queue.stopped());
  feed.odometry_at(50.0, 100.4);
  feed.odometry_at(51.0, 100.4);
  feed.scan_at(50.4, 100.4);
  EXPECT_EQ(feed.ready(), Stamps{50.4});
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, ATransformBeforeSimulatedTimeBeginsCostsNoScan) {
  Feed feed(settings());
  feed.queue.add_transforms(make_link(0.0, "base", "laser", 0.2), true, ros::Time());
  feed.scan_at(1000.1, 0.0);
  feed.odometry(1000.0);
  feed.odometry(1000.2);
  EXPECT_EQ(feed.ready(), Stamps{1000.1});
}

ScanQueueSettings two_lasers() {
  ScanQueueSettings result = settings();
  result.lasers = 2;
  return result;
}

TEST(ScanQueue, MergesScansOfSeveralLasersByTheirStamps) {
  Feed feed(two_lasers());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry_at(110.0, 100.5);
  feed.scan_of(0, 101.0, 101.0);
  EXPECT_EQ(feed.ready(), Stamps{}) << "the other laser may have an earlier one";
  feed.scan_of(1, 100.9, 101.1);  // slower to arrive
  feed.scan_of(0, 101.1, 101.2);
  EXPECT_EQ(feed.ready(), (Stamps{100.9}));
  feed.scan_of(1, 101.05, 101.25);
  feed.scan_of(0, 101.2, 101.3);
  feed.scan_of(1, 101.15, 101.35);
  EXPECT_EQ(feed.ready(), (Stamps{101.0, 101.05, 101.1, 101.15}));
  feed.expect_all_accounted_for();
}

/// Two lasers, of which the second is slow to arrive, before and after their stamps jump back by
/// 54 s; the time of arrival does so, too, or goes on.
void feed_time_jump(double slow, bool arrivals_jump, Feed& feed) {
  struct Message {
    double arrival;
    int laser;  ///< -1: odometry
    double stamp;
  };
  std::vector<Message> messages;
  for (int k = 0; k < 80; ++k) {
    const double arrival = 100.0 + 0.1 * k;
    const double stamp = k < 40 ? arrival : arrival - 54.0;
    messages.push_back({arrival, -1, stamp});
    messages.push_back({arrival + 0.01, 0, stamp});
    messages.push_back({arrival + 0.01 + slow, 1, stamp + 0.03});
    messages.push_back({arrival + slow, -1, stamp + 0.05});
  }
  std::stable_sort(messages.begin(), messages.end(),
                   [](const Message& a, const Message& b) { return a.arrival < b.arrival; });
  for (const Message& message : messages) {
    const double now = message.arrival - (arrivals_jump && message.arrival > 103.999 ? 54.0 : 0.0);
    if (message.laser < 0) {
      feed.odometry_at(message.stamp, now);
    } else {
      feed.scan_of(message.laser, message.stamp, now);
    }
  }
}

TEST(ScanQueue, ATimeJumpIsOneWithASlowLaserToo) {
  for (const bool arrivals_jump : {false, true}) {
    for (const double slow : {0.02, 0.15, 0.35}) {
      Feed feed(two_lasers());
      feed.laser();
      feed_time_jump(slow, arrivals_jump, feed);
      const Stamps ready = feed.ready();
      const std::string account = to_string(feed.queue.account()) + " " + std::to_string(slow);
      EXPECT_EQ(std::count_if(ready.begin(), ready.end(), [](double s) { return s < 0.0; }), 1)
          << account;
      EXPECT_GE(feed.queue.account().delivered, 146U) << account;
      feed.expect_all_accounted_for();
    }
  }
}

TEST(ScanQueue, LasersMayHaveTheSameStamps) {
  Feed feed(two_lasers());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry_at(110.0, 100.5);
  for (const double stamp : {101.0, 101.1}) {
    feed.scan_of(1, stamp, stamp);
    feed.scan_of(0, stamp, stamp);
  }
  feed.scan_of(0, 101.1, 101.2);  // once more
  EXPECT_EQ(feed.ready().size(), 4U);
  EXPECT_EQ(feed.queue.account().skipped_total(), 1U);
}

TEST(ScanQueue, ALaserThatFallsSilentHoldsTheOthersUpForAMoment) {
  Feed feed(two_lasers());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry_at(110.0, 100.5);
  feed.scan_of(0, 101.0, 101.0);
  feed.scan_of(1, 101.0, 101.0);
  feed.scan_of(0, 101.1, 101.1);
  EXPECT_EQ(feed.ready(), (Stamps{101.0, 101.0}));
  feed.scan_of(0, 101.2, 101.7);  // the other one may have stopped
  EXPECT_EQ(feed.ready(), (Stamps{101.1}));
  feed.scan_of(0, 101.8, 102.3);
  feed.scan_of(0, 101.9, 102.4);
  EXPECT_EQ(feed.ready(), (Stamps{101.2, 101.8, 101.9})) << "it is not waited for any more";
}

TEST(ScanQueue, GivesUpScansThatWaitedTooLongButNeverTheNewest) {
  ScanQueueSettings slow = settings();
  slow.max_lag = 0.25;
  Feed feed(slow);
  feed.laser();
  feed.odometry(100.0);
  feed.odometry_at(110.0, 100.5);
  for (const double stamp : {101.0, 101.1, 101.2, 101.3, 101.4}) {
    feed.scan(stamp);
  }
  EXPECT_EQ(feed.ready(), (Stamps{101.2, 101.3, 101.4}));
  EXPECT_EQ(feed.skipped(SkipReason::kTooLate), 2U);
  feed.scan_at(101.5, 105.0);
  feed.odometry_at(111.0, 105.5);
  EXPECT_EQ(feed.ready(), (Stamps{101.5})) << "late, but there is nothing newer";
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, InThePlaceOfAScanThatItHadNoTimeForItSaysThat) {
  ScanQueueSettings slow = settings();
  slow.max_lag = 0.25;
  Feed feed(slow);
  feed.laser();
  feed.odometry(100.0);
  feed.odometry_at(110.0, 100.5);
  for (const double stamp : {101.0, 101.1, 101.4}) {
    feed.scan(stamp);
  }
  const auto first = feed.queue.next();
  const auto second = feed.queue.next();
  const auto third = feed.queue.next();
  ASSERT_TRUE(first && second && third);
  EXPECT_EQ(std::get<LeftOut>(*first).stamp, 101.0);
  EXPECT_EQ(std::get<LeftOut>(*second).stamp, 101.1);
  EXPECT_TRUE(std::holds_alternative<ReadyScan>(*third));
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, NeverHoldsMoreThanItMay) {
  ScanQueueSettings small = settings();
  small.max_waiting = 3;
  Feed feed(small);
  for (int k = 0; k < 10; ++k) {
    feed.scan_at(100.0 + 0.1 * k, 100.0);
  }
  EXPECT_EQ(feed.queue.waiting(), 3U);
  EXPECT_EQ(feed.skipped(SkipReason::kQueueFull), 7U);
  feed.laser();
  feed.odometry(100.0);
  feed.odometry(101.0);
  EXPECT_EQ(feed.queue.waiting(), 3U);
  feed.scan_at(100.95, 101.0);
  EXPECT_EQ(feed.queue.waiting(), 3U);
  EXPECT_EQ(feed.ready(), (Stamps{100.8, 100.9, 100.95})) << "the newest are kept";
  feed.expect_all_accounted_for();
}

/// Parts of turns of a laser that turns ten times a second, a quarter of a turn each.
std::vector<sensor_msgs::LaserScan> parts_from(double first, int count) {
  std::vector<sensor_msgs::LaserScan> parts;
  for (int k = 0; k < count; ++k) {
    sensor_msgs::LaserScan part = make_scan(first + 0.025 * k, "laser", 90);
    part.angle_increment = static_cast<float>(2.0 * kPi / 360.0);
    part.angle_min = static_cast<float>(0.5 * kPi * k);
    parts.push_back(part);
  }
  return parts;
}

TEST(ScanQueue, CountsPartsOfATurnAsOneScan) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry_at(102.0, 100.4);
  for (const sensor_msgs::LaserScan& part : parts_from(100.5, 11)) {
    feed.queue.add_scan(part, part.header.stamp);
  }
  EXPECT_EQ(feed.ready(), (Stamps{100.5, 100.525, 100.625}));
  EXPECT_EQ(feed.queue.account().received, 3U);
  EXPECT_EQ(feed.queue.take_news().size(), 1U);
  feed.queue.finish();
  EXPECT_EQ(feed.ready(), Stamps{100.725});
  EXPECT_EQ(feed.queue.account().received, 4U);
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, SkipsPartsWhoseTurnWasCutOffByATimeJump) {
  Feed feed(settings());
  feed.laser();
  feed.odometry(100.0);
  feed.odometry_at(102.0, 100.4);
  for (const sensor_msgs::LaserScan& part : parts_from(100.5, 7)) {
    feed.queue.add_scan(part, part.header.stamp);
  }
  EXPECT_EQ(feed.ready().size(), 2U);
  feed.queue.add_transforms(make_link(50.0, "odom", "base", 1.0), false, ros::Time(50.0));
  EXPECT_EQ(feed.skipped(SkipReason::kTimeJump), 1U);
  EXPECT_EQ(feed.queue.account().received, 3U);
  feed.expect_all_accounted_for();
}

TEST(ScanQueue, SkipsPartsThatWaitWhenTheRunIsEnded) {
  Feed feed(settings());
  for (const sensor_msgs::LaserScan& part : parts_from(100.5, 3)) {
    feed.queue.add_scan(part, part.header.stamp);
  }
  feed.queue.interrupt();
  EXPECT_EQ(feed.skipped(SkipReason::kInterrupted), 2U);
  feed.expect_all_accounted_for();
}

/// A laser that turns all round and tells no times, whose odometry is not known where it is asked
/// for between scans.
TEST(ScanQueue, LooksForNoSweepTimeWhereOdometryIsNotKnown) {
  Feed feed(settings());
  feed.laser();
  for (int k = 0; k < 6; ++k) {
    const double stamp = 100.0 + 100.0 * k;  // tf keeps 60 s
    sensor_msgs::LaserScan scan = make_scan(stamp, "laser", 360);
    scan.angle_increment = static_cast<float>(2.0 * kPi / 360.0);
    for (const double at : {stamp - 0.1, stamp, stamp + 0.1}) {
      feed.queue.add_transforms(make_link(at, "odom", "base", 0.1 * at, at), false,
                                ros::Time(stamp));
    }
    feed.queue.add_scan(scan, ros::Time(stamp));
  }
  EXPECT_EQ(feed.ready().size(), 6U);
  EXPECT_TRUE(feed.queue.take_news().empty());
  feed.expect_all_accounted_for();
}

}  // namespace
}  // namespace matchbox_slam
