#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

double gap(const Pose2& a, const Pose2& b) { return (a.translation() - b.translation()).norm(); }

TEST(Robot, RestsDrivesTheRouteAndRests) {
  Route route;
  route.waypoints = {{1.0, 2.0}, {6.0, 2.0}, {6.0, 7.0}};
  DriveOptions options;
  options.rest = 3.0;
  const RobotMotion motion = drive(route, options);
  const Pose2 start{1.0, 2.0, 0.0};
  EXPECT_EQ(motion.pose(-1.0), start);
  EXPECT_EQ(motion.pose(3.0), start);
  EXPECT_NE(motion.pose(4.0), start);
  const Pose2 end = motion.pose(1e6);
  EXPECT_LT(gap(end, {6.0, 7.0, 0.0}), 0.03);
  EXPECT_NEAR(end.theta, 0.5 * kPi, 0.05);
  EXPECT_EQ(motion.steps().back().speed, 0.0);
  EXPECT_NEAR(length_of(motion), 9.8, 0.2);  // a corner cut
}

TEST(Robot, DrivesSeveralLapsOfAWayThatComesBack) {
  Route route;
  route.waypoints = {{0.0, 0.0}, {4.0, 0.0}, {4.0, 3.0}, {0.0, 0.0}};
  DriveOptions options;
  const double lap = length_of(drive(route, options));
  options.laps = 3;
  const RobotMotion motion = drive(route, options);
  EXPECT_NEAR(length_of(motion), 3.0 * lap, 1.6);  // where a lap ends the corner is cut
  EXPECT_LT(gap(motion.pose(1e6), {0.0, 0.0, 0.0}), 0.03);
  route.waypoints.pop_back();
  EXPECT_THROW((void)drive(route, options), ConfigurationError);
}

TEST(Robot, KeepsItsLimits) {
  const DriveOptions options;
  for (const std::string& name : world_names()) {
    const RobotMotion motion = drive(make_world(name, 8).route(), options);
    const std::vector<RobotMotion::Step>& steps = motion.steps();
    const double step = motion.duration() / static_cast<double>(steps.size());
    double fastest = 0.0;
    for (std::size_t i = 1; i < steps.size(); ++i) {
      fastest = std::max(fastest, steps[i].speed);
      ASSERT_GE(steps[i].speed, 0.0);
      ASSERT_LE(std::abs(steps[i].turn_rate), options.turn_rate + 1e-9);
      ASSERT_LE(std::abs(steps[i].speed - steps[i - 1].speed), options.acceleration * step + 1e-9);
      ASSERT_LE(std::abs(steps[i].turn_rate - steps[i - 1].turn_rate),
                options.turn_acceleration * step + 1e-9);
    }
    EXPECT_NEAR(fastest, options.speed, 1e-9) << name;
  }
}

TEST(Robot, ItsPoseIsContinuousAndMovesAsItsSpeedSays) {
  const RobotMotion motion = drive(make_loop_world(1).route(), {});
  constexpr double kInterval = 0.0013;
  double length = 0.0;
  for (double time = 0.0; time < 60.0; time += kInterval) {
    const double step = gap(motion.pose(time), motion.pose(time + kInterval));
    ASSERT_LE(step, 0.5 * kInterval + 1e-9) << time;
    length += step;
  }
  EXPECT_GT(length, 15.0);
}

TEST(Robot, TurnsOnTheSpotWhereTheRouteTurnsBack) {
  Route route;
  route.start_heading = 3.0;
  route.waypoints = {{0.0, 0.0}, {4.0, 0.0}, {0.0, 0.2}};
  const RobotMotion motion = drive(route, {});
  EXPECT_LT(gap(motion.pose(1e6), {0.0, 0.2, 0.0}), 0.05);
  EXPECT_LT(length_of(motion), 8.2);
}

TEST(Robot, ArrivesWithEveryAllowedExtreme) {
  const Route route = make_rooms_world(3).route();
  const Eigen::Vector2d end = route.waypoints.back();
  for (const double speed : {0.05, 1.5}) {
    for (const double turn_rate : {0.05, 5.0}) {
      for (const double acceleration : {0.05, 10.0}) {
        for (const double turn_acceleration : {1.0, 100.0}) {
          const DriveOptions options{speed, turn_rate, acceleration, turn_acceleration, 0.0};
          const RobotMotion motion = drive(route, options);
          // Fast but sluggish, the robot keeps to the route loosely.
          EXPECT_LT((motion.pose(1e9).translation() - end).norm(), 0.5)
              << speed << " " << turn_rate << " " << acceleration << " " << turn_acceleration;
        }
      }
    }
  }
}

TEST(Robot, RefusesARouteWithoutLength) {
  EXPECT_THROW((void)drive({}, {}), std::invalid_argument);
  Route point;
  point.waypoints = {{1.0, 1.0}, {1.0, 1.0}};
  EXPECT_THROW((void)drive(point, {}), std::invalid_argument);
}

}  // namespace
}  // namespace matchbox_slam
