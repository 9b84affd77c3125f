// Of sensor/sweep_time.hpp and sensor/sweep_time_choice.hpp.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "sensor/sweep_time.hpp"
#include "sensor/sweep_time_choice.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

constexpr double kPeriod = 0.2;  // s, from scan to scan
constexpr std::size_t kBeams = 360;
constexpr double kWhole = kPeriod * (kBeams - 1.0) / kBeams;  // of which a sweep takes all

enum class Way { kTurns, kDrives };

/// Where a robot is that begins after a second to turn on the spot, ever faster, or to drive
/// straight on, up to half a metre a second.
Pose2 pose_at(const Pose2& start, Way way, double time) {
  const double moving = std::max(0.0, time - 1.0);
  if (way == Way::kTurns) {
    return {start.x, start.y, wrap_angle(start.theta + 0.3 * moving * moving)};
  }
  const double driven = moving < 1.0 ? 0.25 * moving * moving : 0.5 * moving - 0.25;
  return start * Pose2{driven, 0.0, 0.0};
}

/// Scans of a laser at the base, whose beams are taken over `sweep` [s].
class Robot {
 public:
  Robot(const World& world, double sweep, Way way = Way::kTurns, std::size_t beams = kBeams,
        double field = 2.0 * kPi)
      : world_(world), sweep_(sweep), way_(way), beams_(beams), field_(field) {
    const Eigen::Vector2d at = world.route().waypoints.front();
    start_ = {at.x(), at.y(), world.route().start_heading};
  }

  [[nodiscard]] LaserScan scan(double time) {
    LaserScan scan;
    scan.stamp = time;
    scan.angle_min = -0.5 * field_;
    scan.angle_increment = field_ / static_cast<double>(beams_);
    scan.range_min = 0.1;
    scan.range_max = 8.0;
    for (std::size_t k = 0; k < beams_; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(beams_ - 1);
      const Pose2 pose = pose_at(start_, way_, time + share * sweep_);
      const double angle =
          pose.theta + scan.angle_min + static_cast<double>(k) * scan.angle_increment;
      const auto hit = world_.cast_ray(pose.translation(), {std::cos(angle), std::sin(angle)}, 8.0,
                                       {}, {time, k});
      scan.ranges.push_back(hit ? static_cast<float>(hit->range + noise_(random_))
                                : std::numeric_limits<float>::infinity());
    }
    return scan;
  }

  [[nodiscard]] Pose2 odom_from_base(double time) const { return pose_at(start_, way_, time); }

 private:
  const World& world_;
  double sweep_;
  Way way_;
  std::size_t beams_;
  double field_;
  Pose2 start_;
  std::mt19937 random_{7};
  std::normal_distribution<double> noise_{0.0, 0.01};
};

struct Decided {
  double sweep = 0.0;  ///< [s]
  std::string news;
  std::size_t scans = 0;  ///< until then
};

/// What is taken for the last of some scans whose messages tell `sent` from beam to beam.
Decided decide(Robot robot, double sent, const SweepTimeSetting& setting = {}, int scans = 20,
               double sent_scan_time = 0.0, double period = kPeriod) {
  SweepTimeChoice choice(setting);
  Decided decided;
  for (int k = 0; k < scans; ++k) {
    const double time = 100.0 + period * k;
    LaserScan scan = robot.scan(time - 100.0);
    scan.stamp = time;
    scan.time_increment = sent;
    choice.note_pose(time, robot.odom_from_base(time - 100.0), [&](double stamp) {
      return std::optional(robot.odom_from_base(stamp - 100.0));
    });
    scan.time_increment = choice.time_increment(scan, sent_scan_time);
    const double sweep = scan.duration();
    decided.scans = sweep == decided.sweep ? decided.scans : static_cast<std::size_t>(k);
    decided.sweep = sweep;
    choice.add(scan, sent, Eigen::Isometry3d::Identity(), robot.odom_from_base(time - 100.0));
    decided.news += choice.take_news();
  }
  return decided;
}

class SweepTime : public testing::TestWithParam<std::string> {
 protected:
  const World world_ = make_world(GetParam(), 3);
};

TEST_P(SweepTime, IsSeenFromScansOfATurningRobot) {
  for (const double sweep : {0.0, 0.1, 0.2}) {
    Robot robot(world_, sweep);
    SweepTimeEstimator estimator;
    std::vector<double> told;
    for (int k = 0; k < 20; ++k) {
      const double time = kPeriod * k;
      const Pose2 now = robot.odom_from_base(time);
      const Pose2 motion = now.inverse() * robot.odom_from_base(time + kPeriod);
      const std::optional<ToldSweepTime> one =
          estimator.add({robot.scan(time), Eigen::Isometry3d::Identity(), now,
                         motion.translation() / kPeriod, motion.theta / kPeriod});
      if (one && one->is_turning) {
        told.push_back(one->seconds);
      }
    }
    ASSERT_GE(told.size(), 5U);
    EXPECT_EQ(estimator.turning_scans(), told.size());
    std::sort(told.begin(), told.end());
    EXPECT_NEAR(told[told.size() / 2], sweep, 0.02);
  }
}

TEST_P(SweepTime, ThatCannotBeIsTheTimeFromScanToScan) {
  const Decided decided = decide(Robot(world_, kWhole), 2.99e-5);
  EXPECT_NEAR(decided.sweep, kWhole, 1e-6);
  EXPECT_EQ(decided.scans, 1U) << "from the second scan on, which tells the period";
  EXPECT_NE(decided.news.find("make a sweep of 0.011 s"), std::string::npos) << decided.news;
  EXPECT_NE(decided.news.find("scan/sweep_time"), std::string::npos) << decided.news;
}

TEST_P(SweepTime, OfALaserThatTellsNothingIsSeen) {
  const Decided sweeps = decide(Robot(world_, kWhole), 0.0);
  EXPECT_NEAR(sweeps.sweep, kWhole, 1e-6);
  EXPECT_LE(sweeps.scans, 7U) << "the robot turns from the fifth on";
  EXPECT_NE(sweeps.news.find("messages tell 0.000 s; taken is 0.199 s"), std::string::npos)
      << sweeps.news;
  const Decided at_once = decide(Robot(world_, 0.0), 0.0);
  EXPECT_EQ(at_once.sweep, 0.0);
  EXPECT_EQ(at_once.news, "");
}

TEST_P(SweepTime, IsSeenBeforeTheFirstTurn) {
  const Decided sweeps = decide(Robot(world_, kWhole, Way::kDrives), 0.0);
  EXPECT_NEAR(sweeps.sweep, kWhole, 1e-6);
  EXPECT_LE(sweeps.scans, 9U) << "the robot drives from the fifth on";
  const Decided at_once = decide(Robot(world_, 0.0, Way::kDrives), 0.0);
  EXPECT_EQ(at_once.sweep, 0.0);
  EXPECT_EQ(at_once.news, "");
}

TEST_P(SweepTime, ThatSeemedImpossibleIsTakenWhereScansShowIt) {
  EXPECT_NEAR(decide(Robot(world_, 0.01), 0.01 / (kBeams - 1.0)).sweep, 0.01, 1e-6);
}

TEST_P(SweepTime, ThatIsNeitherIsWhatScansShow) {
  for (const Way way : {Way::kTurns, Way::kDrives}) {
    const Decided decided = decide(Robot(world_, 0.1, way), 0.0, {}, 30);
    EXPECT_NEAR(decided.sweep, 0.1, 0.012);
    const std::size_t told = decided.news.find("scans of the moving robot show");
    EXPECT_NE(told, std::string::npos);
    EXPECT_EQ(decided.news.find("scans of the moving robot show", told + 1), std::string::npos)
        << decided.news;
  }
}

TEST_P(SweepTime, IsSeenWhereMostScansAreLeftOut) {
  for (const Way way : {Way::kTurns, Way::kDrives}) {
    const Decided few = decide(Robot(world_, kWhole, way), 0.0, {}, 6, 0.0, 5.0 * kPeriod);
    EXPECT_NEAR(few.sweep, kWhole, 0.03) << few.news;
    const Decided at_once = decide(Robot(world_, 0.0, way), 0.0, {}, 6, 0.0, 5.0 * kPeriod);
    EXPECT_EQ(at_once.sweep, 0.0);
    EXPECT_EQ(at_once.news, "");
  }
}

INSTANTIATE_TEST_SUITE_P(Worlds, SweepTime, testing::Values("rooms", "atrium", "glass"),
                         [](const auto& world) { return world.param; });

TEST(SweepTimeChoice, BelievesWhatCanBeAndWhatItIsToldTo) {
  const World world = make_world("rooms", 3);
  const Robot sweeping(world, kWhole);
  const double increment = kPeriod / kBeams;
  EXPECT_EQ(decide(sweeping, increment).sweep, increment * (kBeams - 1.0));
  EXPECT_EQ(decide(sweeping, 0.0, {true, std::nullopt}).sweep, 0.0);
  EXPECT_NEAR(decide(sweeping, increment, {false, 0.05}).sweep, 0.05, 1e-12);
  EXPECT_EQ(decide(Robot(world, 0.0), 1e-5, {}, 3, 1e-5 * kBeams).sweep, 1e-5 * (kBeams - 1.0))
      << "every so many scans of a laser that is faster";
}

/// Whatever scans seem to show by odometry that is wrong: here it says that the robot turns twice
/// as fast.
TEST(SweepTimeChoice, BelievesASweepOfScansOfWhichMostAreLeftOut) {
  const World world = make_world("rooms", 3);
  const double increment = kPeriod / kBeams;
  const Decided decided =
      decide(Robot(world, 0.5 * kWhole), increment, {}, 6, 5.0 * kPeriod, 5.0 * kPeriod);
  EXPECT_EQ(decided.sweep, increment * (kBeams - 1.0));
  EXPECT_EQ(decided.news, "");
}

TEST(SweepTimeChoice, LeavesLasersAloneThatDoNotTurnAllRound) {
  const World world = make_world("rooms", 3);
  const Decided decided =
      decide(Robot(world, 0.1, Way::kTurns, 270, degrees_to_radians(270.0)), 0.0);
  EXPECT_EQ(decided.sweep, 0.0);
  EXPECT_EQ(decided.news, "");
}

}  // namespace
}  // namespace matchbox_slam
