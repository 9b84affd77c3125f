#include <gtest/gtest.h>
#include <tf2_eigen/tf2_eigen.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/error_text.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "node/scan_matcher_diagnostics.hpp"
#include "node/scan_matcher_node.hpp"
#include "ros/imu_heading.hpp"
#include "ros/messages.hpp"
#include "ros/odometry_message.hpp"
#include "ros/queue_settings.hpp"
#include "run/scan_matcher_setup.hpp"

namespace matchbox_slam {
namespace {

ScanMatcherSetup setup_of(const std::string& yaml) {
  const MatcherLoader loader;
  return make_scan_matcher_setup(parse_yaml_parameters(yaml, "test"), loader);
}

std::string refusal_of(const std::string& yaml) {
  return error_text<ConfigurationError>([&] { (void)setup_of(yaml); });
}

// --- configuration ---

TEST(ScanMatcherSetup, HasDefaultsThatFitTogether) {
  const ScanMatcherSetup setup = setup_of("{}");
  EXPECT_EQ(setup.matcher_name, "matchbox_slam/Olson");
  EXPECT_EQ(setup.guess, GuessSource::kVelocity);
  EXPECT_EQ(setup.tf_child(), "base_link");
  const ScanQueueSettings settings = queue_settings(setup);
  EXPECT_FALSE(settings.odom_frame) << "scans wait for no odometry";
  EXPECT_EQ(settings.map_frame, "odom") << "our own tf is no news";
}

TEST(ScanMatcherSetup, TakesTheFilesOfTheSlamNode) {
  for (const std::string name : {"olson", "hough", "monte_carlo"}) {
    const MatcherLoader loader;
    const ScanMatcherSetup setup = make_scan_matcher_setup(
        read_yaml_parameters({std::string(MATCHBOX_SOURCE_DIR) + "/config/" + name + ".yaml"}),
        loader);
    EXPECT_EQ(matcher_short_name(setup.matcher_name), name);
  }
}

TEST(ScanMatcherSetup, AGuessByOdometryPutsTfAboveThat) {
  const ScanMatcherSetup setup =
      setup_of("{guess: odometry, guess_frame: /odom, odom_frame: scan_odom}");
  EXPECT_EQ(setup.guess, GuessSource::kOdometry);
  EXPECT_EQ(setup.tf_child(), "odom");
  const ScanQueueSettings settings = queue_settings(setup);
  EXPECT_EQ(settings.odom_frame, "odom");
  EXPECT_EQ(settings.map_frame, "scan_odom");
}

TEST(ScanMatcherSetup, TheFrameOfTheGuessMayBeOursWithoutTf) {
  const std::string shared = "guess: odometry, guess_frame: odom, odom_frame: odom";
  const std::string text = refusal_of("{" + shared + "}");
  EXPECT_TRUE(contains(text, "odom_frame: 'odom' is not allowed with publish_tf")) << text;
  EXPECT_TRUE(contains(text, "such as scan_odom, or publish_tf: false")) << text;
  const ScanQueueSettings settings =
      queue_settings(setup_of("{" + shared + ", publish_tf: false}"));
  EXPECT_EQ(settings.odom_frame, "odom");
  EXPECT_EQ(settings.map_frame, "") << "else the guess would be ignored";
}

TEST(ScanMatcherSetup, RefusesWhatDoesNotFitTogether) {
  const auto refused = [](const std::string& yaml, const std::string& words) {
    const std::string text = refusal_of(yaml);
    EXPECT_TRUE(contains(text, words)) << yaml << ": " << text;
  };
  refused("{base_frame: odom}", "odom_frame: 'odom' is not allowed; allowed: a frame other than");
  refused("{base_frame: ''}", "base_frame: '' is not allowed");
  refused("{odom_frame: /base_link}", "odom_frame: 'base_link' is not allowed");
  refused("{guess: odometry}", "guess_frame: '' is not allowed with guess 'odometry'");
  refused("{guess: odometry, guess_frame: base_link}", "guess_frame: 'base_link'");
  refused("{guess_frame: odom}", "guess_frame: 'odom' is not allowed with guess 'velocity'");
  refused("{guess: wheels}", "guess: wheels is not allowed");
  refused("{map_frame: map}", "unknown parameter 'map_frame'");
  refused("{odometri/key_angle: 3}", "did you mean 'odometry'?");
  refused("{odometry/local_map_scan: 3}", "did you mean 'local_map_scans'?");
  refused("{slam/recent_scan: 3}", "did you mean 'recent_scans'?");
  refused("{hough/angles: 1}", "hough/angles");
  refused("{matcher: olsen}", "there is no matcher 'olsen'");
}

// --- an IMU's heading ---

sensor_msgs::Imu imu_message(const Eigen::Quaterniond& world_from_imu) {
  sensor_msgs::Imu message;
  message.header.stamp = ros::Time(5.0);
  message.header.frame_id = "imu_link";
  message.orientation.w = world_from_imu.w();
  message.orientation.x = world_from_imu.x();
  message.orientation.y = world_from_imu.y();
  message.orientation.z = world_from_imu.z();
  return message;
}

Eigen::Quaterniond turn(double angle, const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
}

TEST(ImuHeading, IsTheBasesHoweverTheImuIsMounted) {
  constexpr double kYaw = 0.7;
  for (const Eigen::Quaterniond& base_from_imu :
       {Eigen::Quaterniond::Identity(), turn(kPi, Eigen::Vector3d::UnitX()),
        turn(1.2, Eigen::Vector3d::UnitZ()), turn(0.5 * kPi, Eigen::Vector3d::UnitY())}) {
    const Eigen::Quaterniond world_from_base = turn(kYaw, Eigen::Vector3d::UnitZ());
    geometry_msgs::TransformStamped mount = make_transform(0.0, "base_link", "imu_link", 0.3);
    mount.transform.rotation = tf2::toMsg(base_from_imu);
    const sensor_msgs::Imu message = imu_message(world_from_base * base_from_imu);
    ASSERT_EQ(find_defect(message), "");
    TransformStore store("");
    store.add(make_transforms({mount}), true);
    store.add(make_transforms({heading_link(message)}), false);
    const auto heading_from_base = store.lookup(kImuHeadingFrame, "base_link", ros::Time(5.0));
    ASSERT_TRUE(heading_from_base);
    EXPECT_NEAR(project_to_plane(*heading_from_base).theta, kYaw, 1e-9);
  }
}

TEST(ImuHeading, DoesNotGiveTheBaseASecondParent) {
  TransformStore store("");
  store.add(make_link(4.0, "odom", "base_link", 1.0), false);
  store.add(make_link(6.0, "odom", "base_link", 2.0), false);
  for (const double stamp : {4.0, 6.0}) {
    sensor_msgs::Imu message = imu_message(turn(stamp, Eigen::Vector3d::UnitZ()));
    message.header.stamp = ros::Time(stamp);
    message.header.frame_id = "/base_link";
    store.add(make_transforms({heading_link(message)}), false);
  }
  EXPECT_TRUE(store.covers("odom", "base_link", ros::Time(5.0)));
  const auto heading = store.lookup(kImuHeadingFrame, "base_link", ros::Time(5.0));
  ASSERT_TRUE(heading);
  EXPECT_NEAR(wrap_angle(project_to_plane(*heading).theta - 5.0), 0.0, 1e-9) << "interpolated";
}

TEST(ImuHeading, ToldWhatIsNone) {
  sensor_msgs::Imu message = imu_message(Eigen::Quaterniond::Identity());
  message.orientation_covariance[0] = -1.0;
  EXPECT_TRUE(contains(find_defect(message), "measures no orientation"));
  message = imu_message(Eigen::Quaterniond::Identity());
  message.orientation.w = 0.0;
  EXPECT_TRUE(contains(find_defect(message), "of length 0"));
  message.orientation.w = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(find_defect(message), "");
  message = imu_message(Eigen::Quaterniond::Identity());
  message.header.stamp = ros::Time();
  EXPECT_TRUE(contains(find_defect(message), "stamp"));
  message = imu_message(Eigen::Quaterniond::Identity());
  message.header.frame_id = "/";
  EXPECT_EQ(find_defect(message), "it does not name its frame");
}

// --- messages out ---

TEST(OdometryMessage, HasPoseAndTwistWithCovariances) {
  LaserOdometryOutcome outcome;
  outcome.odom_from_base = {1.0, 2.0, 0.5 * kPi};
  outcome.covariance << 4.0, 0.1, 0.2, 0.1, 5.0, 0.3, 0.2, 0.3, 6.0;
  outcome.velocity = {0.5, -0.1, 0.2};
  outcome.velocity_covariance = Eigen::Vector3d(7.0, 8.0, 9.0).asDiagonal();
  const nav_msgs::Odometry message = to_message(outcome, ros::Time(3.0), "odom", "base_link");
  EXPECT_EQ(message.header.stamp, ros::Time(3.0));
  EXPECT_EQ(message.header.frame_id, "odom");
  EXPECT_EQ(message.child_frame_id, "base_link");
  EXPECT_EQ(message.pose.pose.position.y, 2.0);
  EXPECT_NEAR(message.pose.pose.orientation.z, std::sqrt(0.5), 1e-12);
  EXPECT_EQ(message.pose.covariance[0], 4.0);
  EXPECT_EQ(message.pose.covariance[1], 0.1);
  EXPECT_EQ(message.pose.covariance[5], 0.2);
  EXPECT_EQ(message.pose.covariance[35], 6.0);
  EXPECT_EQ(message.twist.twist.linear.x, 0.5);
  EXPECT_EQ(message.twist.twist.linear.y, -0.1);
  EXPECT_EQ(message.twist.twist.angular.z, 0.2);
  EXPECT_EQ(message.twist.covariance[7], 8.0);
  EXPECT_EQ(message.twist.covariance[35], 9.0);
  for (const std::size_t axis : {2U, 3U, 4U}) {
    EXPECT_EQ(message.pose.covariance[7 * axis], kUnknownVariance);
    EXPECT_EQ(message.twist.covariance[7 * axis], kUnknownVariance);
  }
}

// --- who else publishes tf ---

TEST(RivalLink, IsWhatGivesOurFrameAParent) {
  const auto found = [](const std::string& parent, const std::string& child, bool from_others) {
    return find_rival_link(make_link(1.0, parent, child, 0.0), "base_link", "odom", from_others);
  };
  EXPECT_EQ(found("/odom", "/base_link", true), "odom -> base_link") << "wheels";
  EXPECT_EQ(found("wheel_odom", "base_link", true), "wheel_odom -> base_link");
  EXPECT_EQ(found("wheel_odom", "base_link", false), "wheel_odom -> base_link")
      << "of another nodelet in our process";
  EXPECT_EQ(found("odom", "base_link", false), "") << "our own";
  EXPECT_EQ(found("map", "odom", true), "") << "a localiser above us is welcome";
  EXPECT_EQ(found("base_link", "laser", true), "");
}

// --- diagnostics ---

LaserOdometryOutcome outcome_of(MatchStatus status) {
  LaserOdometryOutcome outcome;
  outcome.match.status = status;
  return outcome;
}

TEST(ScanMatcherDiagnostics, JudgesWhatHasHappenedSince) {
  ScanMatcherDiagnostics diagnostics;
  ScanMatcherHealth health;
  const auto level = [&] {
    diagnostic_updater::DiagnosticStatusWrapper status;
    diagnostics.fill(health, status);
    return std::to_string(status.level) + " " + status.message;
  };
  EXPECT_EQ(level(), "1 no scans are coming in");
  health.account.received = 10;
  health.matches.add(outcome_of(MatchStatus::kRejectedNoReference), 0.0);
  health.matches.add(outcome_of(MatchStatus::kAccepted), 0.001);
  EXPECT_EQ(level(), "0 matching");
  health.account.received = 20;
  health.matches.add(outcome_of(MatchStatus::kRejectedLowScore), 0.001);
  EXPECT_EQ(level(), "1 1 scans did not fit; the guess stands for them");
  health.account.received = 30;
  EXPECT_EQ(level(), "0 matching") << "it is over";
  health.account.received = 31;
  health.account.skipped[SkipReason::kEmpty] = 1;
  health.last_skip = "it has no ranges";
  EXPECT_EQ(level(), "1 1 scans skipped; the last: it has no ranges");
  health.tf_conflict = "no tf";
  EXPECT_EQ(level(), "2 no tf");
}

TEST(MatchRecord, CountsAndForgetsOldTimes) {
  MatchRecord record;
  LaserOdometryOutcome outcome = outcome_of(MatchStatus::kAccepted);
  outcome.match.unconstrained_directions = {{1.0, 0.0}};
  outcome.is_key_scan = true;
  for (int k = 0; k < 300; ++k) {
    record.add(outcome, 0.001 * k);
  }
  EXPECT_EQ(record.statuses().at(MatchStatus::kAccepted), 300U);
  EXPECT_EQ(record.unconstrained(), 300U);
  EXPECT_EQ(record.key_scans(), 300U);
  EXPECT_EQ(record.failed(), 0U);
  ASSERT_EQ(record.recent_match_seconds().size(), 200U);
  EXPECT_NEAR(record.recent_match_seconds().front(), 0.1, 1e-6);
}

}  // namespace
}  // namespace matchbox_slam
