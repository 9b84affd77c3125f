#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "simulation/make_world.hpp"
#include "simulation/odometry.hpp"
#include "simulation/robot.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

std::vector<double> stamps_until(double end, double step) {
  std::vector<double> stamps;
  for (int i = 0; i * step <= end; ++i) {
    stamps.push_back(i * step);
  }
  return stamps;
}

/// Mean and standard deviation.
struct Statistics {
  double mean = 0.0;
  double deviation = 0.0;
};

Statistics statistics(const std::vector<double>& values) {
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const double value : values) {
    sum += value;
    sum_of_squares += value * value;
  }
  const auto count = static_cast<double>(values.size());
  return {sum / count, std::sqrt(sum_of_squares / count - sum / count * (sum / count))};
}

constexpr int kDrives = 4000;
// A deviation estimated from that many runs is right to 1.1 %; four times that is no accident.
constexpr double kTolerance = 0.045;

TEST(Odometry, WithoutErrorsItIsTheTruth) {
  const RobotMotion motion = drive(make_rooms_world(5).route(), {});
  const auto truth = [&](double time) { return motion.pose(time); };
  const auto readings = simulate_odometry(truth, stamps_until(motion.duration(), 0.02),
                                          without_noise(OdometryOptions{}), 1);
  for (const OdometryReading& reading : readings) {
    const Pose2 pose = motion.pose(0.0) * reading.odom_from_base;
    const Pose2 error = motion.pose(reading.stamp).inverse() * pose;
    ASSERT_LT(std::hypot(error.x, error.y), 1e-9);
    ASSERT_LT(std::abs(error.theta), 1e-9);
  }
}

TEST(Odometry, DistanceDriftsAsTheOptionsSay) {
  OdometryOptions options = without_noise(OdometryOptions{});
  options.translation_noise = 0.02;
  options.translation_bias = 0.01;
  const auto straight = [](double time) { return Pose2{0.5 * time, 0.0, 0.0}; };
  const std::vector<double> stamps = stamps_until(8.0, 0.1);  // 4 m
  std::vector<double> errors;
  for (std::uint64_t seed = 0; seed < kDrives; ++seed) {
    const Pose2 end = simulate_odometry(straight, stamps, options, seed).back().odom_from_base;
    EXPECT_EQ(end.y, 0.0);
    errors.push_back(end.x - 4.0);
  }
  const double deviation = 0.02 * std::sqrt(4.0);
  EXPECT_NEAR(statistics(errors).mean, 0.01 * 4.0, 4.0 * deviation / std::sqrt(kDrives));
  EXPECT_NEAR(statistics(errors).deviation, deviation, kTolerance * deviation);
}

TEST(Odometry, HeadingDriftsWithTheDistance) {
  OdometryOptions options = without_noise(OdometryOptions{});
  options.heading_noise = 0.008;
  options.heading_bias = 0.003;
  const auto straight = [](double time) { return Pose2{0.5 * time, 0.0, 0.0}; };
  const std::vector<double> stamps = stamps_until(8.0, 0.1);
  std::vector<double> errors;
  for (std::uint64_t seed = 0; seed < kDrives; ++seed) {
    errors.push_back(
        simulate_odometry(straight, stamps, options, seed).back().odom_from_base.theta);
  }
  const double deviation = 0.008 * std::sqrt(4.0);
  EXPECT_NEAR(statistics(errors).mean, 0.003 * 4.0, 4.0 * deviation / std::sqrt(kDrives));
  EXPECT_NEAR(statistics(errors).deviation, deviation, kTolerance * deviation);
}

TEST(Odometry, HeadingDriftsWithTheTurn) {
  OdometryOptions options = without_noise(OdometryOptions{});
  options.rotation_noise = 0.03;
  options.rotation_bias = 0.01;
  const auto on_the_spot = [](double time) { return Pose2{0.0, 0.0, wrap_angle(-0.5 * time)}; };
  const std::vector<double> stamps = stamps_until(4.0, 0.1);  // 2 rad to the right
  std::vector<double> errors;
  for (std::uint64_t seed = 0; seed < kDrives; ++seed) {
    const Pose2 end = simulate_odometry(on_the_spot, stamps, options, seed).back().odom_from_base;
    EXPECT_EQ(end.translation().norm(), 0.0);
    errors.push_back(wrap_angle(end.theta + 2.0));
  }
  const double deviation = 0.03 * std::sqrt(2.0);
  EXPECT_NEAR(statistics(errors).mean, -0.01 * 2.0, 4.0 * deviation / std::sqrt(kDrives));
  EXPECT_NEAR(statistics(errors).deviation, deviation, kTolerance * deviation);
}

TEST(Odometry, AShareThatWandersStaysForAMetre) {
  OdometryOptions options = without_noise(OdometryOptions{});
  options.translation_wander = 0.2;
  const auto straight = [](double time) { return Pose2{0.5 * time, 0.0, 0.0}; };
  const std::vector<double> stamps = stamps_until(4.0, 0.1);  // 2 m
  std::vector<double> first_metre;
  std::vector<double> both;
  for (std::uint64_t seed = 0; seed < kDrives; ++seed) {
    const auto readings = simulate_odometry(straight, stamps, options, seed);
    const double half = readings[10].odom_from_base.x - 0.5;
    first_metre.push_back(readings[20].odom_from_base.x - 1.0);
    both.push_back(readings[40].odom_from_base.x - 2.0);
    ASSERT_NEAR(half, 0.5 * first_metre.back(), 1e-9);
  }
  EXPECT_NEAR(statistics(first_metre).mean, 0.0, 4.0 * 0.2 / std::sqrt(kDrives));
  EXPECT_NEAR(statistics(first_metre).deviation, 0.2, kTolerance * 0.2);
  // The next metre has another.
  EXPECT_NEAR(statistics(both).deviation, 0.2 * std::sqrt(2.0), kTolerance * 0.2 * std::sqrt(2.0));
}

TEST(Odometry, TurnsWanderLikewise) {
  OdometryOptions options = without_noise(OdometryOptions{});
  options.rotation_wander = 0.08;
  const auto on_the_spot = [](double time) { return Pose2{0.0, 0.0, wrap_angle(0.5 * time)}; };
  const std::vector<double> stamps = stamps_until(2.0, 0.1);  // 1 rad
  std::vector<double> errors;
  for (std::uint64_t seed = 0; seed < kDrives; ++seed) {
    errors.push_back(
        simulate_odometry(on_the_spot, stamps, options, seed).back().odom_from_base.theta - 1.0);
  }
  EXPECT_NEAR(statistics(errors).deviation, 0.08, kTolerance * 0.08);
}

TEST(Odometry, ARestingRobotDoesNotDrift) {
  const auto at_rest = [](double /*time*/) { return Pose2{3.0, 1.0, 0.5}; };
  for (const OdometryReading& reading :
       simulate_odometry(at_rest, stamps_until(10.0, 0.02), {}, 1)) {
    ASSERT_LT(reading.odom_from_base.translation().norm(), 1e-12);
    ASSERT_LT(std::abs(reading.odom_from_base.theta), 1e-12);
  }
}

TEST(Odometry, IsInterpolatedBetweenItsReadings) {
  const std::vector<OdometryReading> odometry = {{10.0, {0.0, 0.0, 3.1}}, {12.0, {2.0, 4.0, -3.1}}};
  const Pose2 middle = interpolate_odometry(odometry, 11.0);
  EXPECT_DOUBLE_EQ(middle.x, 1.0);
  EXPECT_DOUBLE_EQ(middle.y, 2.0);
  EXPECT_NEAR(std::abs(middle.theta), kPi, 1e-12);
  EXPECT_EQ(interpolate_odometry(odometry, 9.0), odometry.front().odom_from_base);
  EXPECT_EQ(interpolate_odometry(odometry, 12.0), odometry.back().odom_from_base);
  EXPECT_EQ(interpolate_odometry(odometry, 13.0), odometry.back().odom_from_base);
}

class FaultyOdometry : public testing::Test {
 protected:
  /// A drive straight on at 1 m/s that turns by 0.1 rad/s, with these faults.
  [[nodiscard]] static std::vector<OdometryReading> told(const std::vector<Fault>& faults) {
    return with_odometry_faults(readings(), faults, kStart, 1);
  }
  [[nodiscard]] static std::vector<OdometryReading> readings() {
    std::vector<double> stamps;
    for (int i = 0; i <= 1000; ++i) {
      stamps.push_back(kStart + 0.02 * i);
    }
    return simulate_odometry(
        [](double stamp) {
          return Pose2{stamp - kStart, 0.0, 0.0} * Pose2{0.0, 0.0, 0.1 * (stamp - kStart)};
        },
        stamps, without_noise(OdometryOptions{}), 1);
  }
  /// Motion that is told between two times.
  [[nodiscard]] static Pose2 motion(const std::vector<OdometryReading>& odometry, double from,
                                    double to) {
    return interpolate_odometry(odometry, kStart + from).inverse() *
           interpolate_odometry(odometry, kStart + to);
  }
  static constexpr double kStart = 1000.0;
};

TEST_F(FaultyOdometry, WithoutFaultsNothingChanges) {
  const auto told_readings = told({parse_fault("people:5:5")});
  for (std::size_t i = 0; i < told_readings.size(); ++i) {
    EXPECT_LT(
        (told_readings[i].odom_from_base.translation() - readings()[i].odom_from_base.translation())
            .norm(),
        1e-9);
  }
}

TEST_F(FaultyOdometry, AFreezeStandsStillAndCatchesUp) {
  const auto odometry = told({parse_fault("freeze:5:2")});
  EXPECT_LT(motion(odometry, 5.02, 6.98).translation().norm(), 1e-9);
  EXPECT_NEAR(motion(odometry, 4.9, 7.1).translation().norm(),
              motion(readings(), 4.9, 7.1).translation().norm(), 1e-9);
}

TEST_F(FaultyOdometry, LostEncodersNeverTellWhatTheyMissed) {
  const auto odometry = told({parse_fault("encoders:5:2")});
  EXPECT_LT(motion(odometry, 4.98, 7.0).translation().norm(), 0.021);
  EXPECT_NEAR(motion(odometry, 10.0, 11.0).translation().norm(),
              motion(readings(), 10.0, 11.0).translation().norm(), 1e-9);
}

TEST_F(FaultyOdometry, SlipTellsAShareMoreOrLess) {
  EXPECT_NEAR(motion(told({parse_fault("way_slip:5:2:0.5")}), 5.0, 7.0).translation().norm(),
              1.5 * motion(readings(), 5.0, 7.0).translation().norm(), 0.01);
  EXPECT_NEAR(motion(told({parse_fault("heading_slip:5:2:-0.5")}), 5.0, 7.0).theta, 0.1, 0.002);
}

TEST_F(FaultyOdometry, AJumpIsAsFarAsIsAskedForAndStays) {
  const auto jumped = told({parse_fault("jump:5.01::0.5"), parse_fault("turn_jump:8.01::0.3")});
  EXPECT_NEAR(motion(jumped, 5.0, 5.02).translation().norm(), 0.5, 0.021);
  EXPECT_NEAR(motion(jumped, 8.0, 8.02).theta, 0.3 + 0.002, 1e-6);
  EXPECT_NEAR(motion(jumped, 10.0, 12.0).theta, 0.2, 1e-6);
}

}  // namespace
}  // namespace matchbox_slam
