#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "matchbox_slam/common/options.hpp"
#include "simulation/make_world.hpp"
#include "simulation/presets.hpp"
#include "simulation/simulation_support.hpp"

namespace matchbox_slam {
namespace {

LaserOptions sensor(const std::string& name) {
  return read_options<LaserOptions>(preset_named(sensor_presets(), "--sensor", name).values, name);
}

OdometryOptions odometry(const std::string& name) {
  return read_options<OdometryOptions>(preset_named(odometry_presets(), "--odometry", name).values,
                                       name);
}

/// A wall across the x axis, so far ahead of the laser.
World wall_at(double range, const LaserOptions& laser) {
  return {{{{laser.mount_x + range, -300.0}, {laser.mount_x + range, 300.0}}}, {}};
}

/// What the laser reads of that wall straight ahead, in the mean and about it.
struct Readings {
  double mean = 0.0;
  double deviation = 0.0;
};

Readings readings_of_wall(double range, LaserOptions laser) {
  const World world = wall_at(range, laser);
  const PoseAtTime at_rest = [](double /*time*/) { return Pose2{}; };
  laser.dropout = 0.0;
  const auto ahead = static_cast<std::size_t>(laser.beams / 2);
  constexpr int kScans = 2000;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (std::uint64_t seed = 0; seed < kScans; ++seed) {
    const LaserScan scan = simulate_scan(world, laser, at_rest, 0.0, seed).scan;
    const double error = static_cast<double>(scan.ranges[ahead]) - range;
    sum += error;
    sum_of_squares += error * error;
  }
  const double mean = sum / kScans;
  return {range + mean, std::sqrt(sum_of_squares / kScans - mean * mean)};
}

/// A few turns in the hall, from a robot that drives.
SimulatedRun short_run(const std::string& name, double duration = 5.0) {
  const World world = make_world("rooms", 1);
  SimulationOptions options;
  options.laser = sensor(name);
  options.drive.rest = 0.0;
  options.time.duration = duration;
  return simulate_run(world, world.route(), options, 3);
}

/// What every sensor of the list promises of a scan.
struct Promise {
  const char* name;
  std::size_t beams;
  double degrees;
  double range_max;
  double rate;    ///< [Hz], of turns
  double sweeps;  ///< share of the time from turn to turn
};

class Sensor : public testing::TestWithParam<Promise> {};

TEST_P(Sensor, HasTheBeamsViewReachRateAndSweepThatItPromises) {
  const Promise promise = GetParam();
  const LaserOptions laser = sensor(promise.name);
  EXPECT_NO_THROW(check_laser_options(laser));
  const LaserScan scan = ideal_scan(wall_at(1.0, laser), laser, {}, 12.5);
  EXPECT_EQ(scan.stamp, 12.5);
  ASSERT_EQ(scan.ranges.size(), promise.beams);
  const double view = degrees_to_radians(promise.degrees);
  EXPECT_NEAR(scan.angle_min, -0.5 * view, 1e-12);
  EXPECT_NEAR(scan.angle_increment * static_cast<double>(promise.beams), view, 1e-12);
  EXPECT_EQ(scan.range_max, promise.range_max);
  EXPECT_EQ(laser.scan_rate, promise.rate);
  EXPECT_NEAR(scan.time_increment * static_cast<double>(promise.beams),
              promise.sweeps / promise.rate, 1e-12);
}

TEST_P(Sensor, SeesAWallAndNothingBeyondItsReach) {
  const LaserOptions laser = sensor(GetParam().name);
  const double within = 0.9 * laser.range_max;
  const auto ahead = static_cast<std::size_t>(laser.beams / 2);
  EXPECT_NEAR(ideal_scan(wall_at(within, laser), laser, {}).ranges[ahead], within, 1e-4);
  const double beyond = laser.range_max + 1.0;
  const float read = ideal_scan(wall_at(beyond, laser), laser, {}).ranges[ahead];
  EXPECT_FALSE(read > laser.range_min && read < laser.range_max) << read;
}

TEST_P(Sensor, KeepsItsPromiseAtScansFarApart) {
  LaserOptions laser = sensor(GetParam().name);
  laser.scan_rate = 0.33;
  EXPECT_NO_THROW(check_laser_options(laser));
  SimulationOptions options;
  options.laser = laser;
  options.time.duration = 20.0;
  const World world = make_world("street", 1);
  const SimulatedRun run = simulate_run(world, world.route(), options, 1);
  const auto parts = static_cast<std::size_t>(laser.parts);
  ASSERT_EQ(run.scans.size(), 8 * parts);
  EXPECT_NEAR(run.scans[parts].stamp - run.scans[0].stamp, 1.0 / 0.33, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(All, Sensor,
                         testing::Values(Promise{"utm30", 1040, 260.0, 30.0, 20.0, 0.0},
                                         Promise{"sick180", 180, 180.0, 80.0, 10.0, 0.0},
                                         Promise{"lds01", 360, 360.0, 3.5, 5.0, 1.0},
                                         Promise{"lds01_as_sent", 360, 360.0, 3.5, 5.0, 1.0},
                                         Promise{"rplidar_a1", 360, 360.0, 12.0, 5.5, 1.0},
                                         Promise{"narrow120", 360, 120.0, 10.0, 10.0, 0.0},
                                         Promise{"narrow90", 270, 90.0, 10.0, 10.0, 0.0},
                                         Promise{"depth_camera", 320, radians_to_degrees(1.0), 5.0,
                                                 10.0, 0.0},
                                         Promise{"ranger32", 32, 360.0, 4.0, 10.0, 0.0},
                                         Promise{"in_parts", 360, 360.0, 10.0, 10.0, 1.0}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(SensorPresets, AreAllHeldToAPromise) {
  EXPECT_EQ(sensor_presets().size(), 10U);
  EXPECT_TRUE(sensor_presets().front().values.empty()) << "the default";
}

TEST(SensorPresets, OfASickReadsMoreThanItsReachForNoReturn) {
  const LaserOptions laser = sensor("sick180");
  const LaserScan scan = ideal_scan(wall_at(100.0, laser), laser, {});
  EXPECT_EQ(scan.ranges[90], 81.0F);
  EXPECT_NEAR(readings_of_wall(8.0, laser).deviation, 0.01, 0.001);
}

TEST(SensorPresets, Lds01AsSentMeasuresTheSameAndTellsOtherwise) {
  const SimulatedRun measured = short_run("lds01");
  const SimulatedRun sent = short_run("lds01_as_sent");
  ASSERT_EQ(sent.scans.size(), measured.scans.size());
  int no_returns = 0;
  for (std::size_t i = 0; i < sent.scans.size(); ++i) {
    EXPECT_NEAR(sent.scans[i].duration(), 0.2 * 359.0 / 360.0, 1e-9);
    for (std::size_t k = 0; k < 360; ++k) {
      const float range = measured.scans[i].ranges[k];
      no_returns += std::isfinite(range) ? 0 : 1;
      EXPECT_EQ(sent.scans[i].ranges[k], std::isfinite(range) ? range : 0.0F);
    }
  }
  EXPECT_GT(no_returns, 100);
  EXPECT_EQ(sensor("lds01_as_sent").sent_time_increment, 2.99e-5);
  EXPECT_EQ(sensor("lds01_as_sent").sent_scan_time, 0.0);
  EXPECT_LT(sensor("lds01").sent_time_increment, 0.0);
  EXPECT_LT(sensor("lds01").sent_scan_time, 0.0);
}

TEST(SensorPresets, RplidarSweepsAndSaysThatItDoesNot) {
  const LaserOptions laser = sensor("rplidar_a1");
  EXPECT_GT(laser.time_increment, 0.0);
  EXPECT_EQ(laser.sent_time_increment, 0.0);
  EXPECT_EQ(laser.sent_scan_time, 0.0);
}

TEST(SensorPresets, NoiseOfADepthCameraGrowsWithTheSquareOfTheRange) {
  const LaserOptions laser = sensor("depth_camera");
  for (const double range : {1.0, 2.0, 4.0}) {
    const Readings readings = readings_of_wall(range, laser);
    const double deviation = 1.4e-3 * range * range;
    EXPECT_NEAR(readings.mean, range, 0.1 * deviation);
    EXPECT_NEAR(readings.deviation, deviation, 0.08 * deviation) << range;
  }
}

TEST(SensorPresets, ADepthCameraReadsNanBeyondAndBeforeItsReach) {
  const LaserOptions laser = sensor("depth_camera");
  for (const double range : {0.4, 5.5, 50.0}) {
    const LaserScan scan = ideal_scan(wall_at(range, laser), laser, {});
    EXPECT_TRUE(std::isnan(scan.ranges[160])) << range;
  }
}

TEST(SensorPresets, PartsAreScansOfTheirOwnThatMakeATurn) {
  const LaserOptions laser = sensor("in_parts");
  const SimulatedRun run = short_run("in_parts", 1.0);
  ASSERT_EQ(run.scans.size(), 110U);
  ASSERT_EQ(run.world_from_base.size(), run.scans.size()) << "a true pose each";
  for (std::size_t i = 0; i < run.scans.size(); ++i) {
    const LaserScan& part = run.scans[i];
    ASSERT_EQ(part.ranges.size(), 36U);
    EXPECT_NEAR(part.stamp, run.scans.front().stamp + 0.01 * static_cast<double>(i), 1e-6);
    EXPECT_NEAR(part.angle_min, -kPi + degrees_to_radians(36.0) * static_cast<double>(i % 10),
                1e-9);
    EXPECT_NEAR(part.time_increment, 1.0 / 3600.0, 1e-12);
  }
  EXPECT_GT(
      (run.world_from_base[109].translation() - run.world_from_base[100].translation()).norm(),
      0.02);
  LaserOptions whole = laser;
  whole.parts = 1;
  const LaserScan turn = ideal_scan(wall_at(1.0, laser), laser, {}, 7.0);
  const std::vector<LaserScan> parts = in_parts(turn, laser);
  std::vector<float> joined;
  for (const LaserScan& part : parts) {
    joined.insert(joined.end(), part.ranges.begin(), part.ranges.end());
  }
  EXPECT_EQ(joined, turn.ranges);
  EXPECT_EQ(in_parts(turn, whole).size(), 1U);
  EXPECT_EQ(in_parts(turn, whole).front().ranges, turn.ranges);
}

TEST(SensorPresets, TheSameSeedGivesTheSameBits) {
  for (const Preset& preset : sensor_presets()) {
    const SimulatedRun run = short_run(preset.name, 1.0);
    const SimulatedRun same = short_run(preset.name, 1.0);
    ASSERT_EQ(run.scans.size(), same.scans.size()) << preset.name;
    for (std::size_t i = 0; i < run.scans.size(); ++i) {
      EXPECT_TRUE(are_same_ranges(run.scans[i], same.scans[i])) << preset.name;
    }
  }
}

TEST(Presets, NameWhatThereIs) {
  try {
    (void)preset_named(sensor_presets(), "--sensor", "sick");
    FAIL() << "accepted an unknown name";
  } catch (const ConfigurationError& error) {
    const std::string text = error.what();
    for (const char* word : {"--sensor", "'sick'", "sick180", "in_parts"}) {
      EXPECT_NE(text.find(word), std::string::npos) << text;
    }
  }
  EXPECT_NE(preset_help(odometry_presets()).find("awful: "), std::string::npos);
}

/// Of the odometry's errors over many seeds.
struct Errors {
  double mean = 0.0;
  double deviation = 0.0;
};

/// Of the odometry's last reading, by what is asked of it.
template <typename Value>
Errors errors_of(const PoseAtTime& motion, double duration, const OdometryOptions& options,
                 const Value& value) {
  constexpr int kRuns = 1000;
  std::vector<double> stamps;
  for (int i = 0; i <= 100; ++i) {
    stamps.push_back(0.01 * i * duration);
  }
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    const double error = value(simulate_odometry(motion, stamps, options, seed).back());
    sum += error;
    sum_of_squares += error * error;
  }
  const double mean = sum / kRuns;
  return {mean, std::sqrt(sum_of_squares / kRuns - mean * mean)};
}

/// By how much one metre straight on is told too long.
Errors errors_of_a_metre(const OdometryOptions& options) {
  return errors_of(
      [](double time) {
        return Pose2{time, 0.0, 0.0};
      },
      1.0, options,
      [](const OdometryReading& last) { return last.odom_from_base.translation().norm() - 1.0; });
}

/// By how much a turn of one radian is told too large.
Errors errors_of_a_radian(const OdometryOptions& options) {
  return errors_of(
      [](double time) {
        return Pose2{0.0, 0.0, time};
      },
      1.0, options, [](const OdometryReading& last) { return last.odom_from_base.theta - 1.0; });
}

/// [m] between odometry and truth at the end of a drive, in the mean.
double mean_end_error(const char* world, const OdometryOptions& options) {
  const RobotMotion motion = drive(make_world(world, 1).route(), {});
  std::vector<double> stamps;
  for (double time = 0.0; time < motion.duration(); time += 0.05) {
    stamps.push_back(time);
  }
  constexpr int kRuns = 12;
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    const auto readings =
        simulate_odometry([&](double time) { return motion.pose(time); }, stamps, options, seed);
    const Pose2 end = motion.pose(0.0) * readings.back().odom_from_base;
    sum += (end.translation() - motion.pose(stamps.back()).translation()).norm();
  }
  return sum / kRuns;
}

TEST(OdometryPresets, PerfectIsTheTruth) {
  EXPECT_LT(mean_end_error("street", odometry("perfect")), 1e-9);
}

TEST(OdometryPresets, GoodIsTheDefault) {
  EXPECT_TRUE(preset_named(odometry_presets(), "--odometry", "good").values.empty());
}

TEST(OdometryPresets, AwfulIsOffByAFifthOfEachStepAndByMoreWithEachTurn) {
  const Errors metre = errors_of_a_metre(odometry("awful"));
  EXPECT_NEAR(metre.deviation, 0.2, 0.02);
  EXPECT_GT(metre.mean, 0.03) << "a part is systematic";
  const Errors radian = errors_of_a_radian(odometry("awful"));
  EXPECT_GT(std::hypot(radian.mean, radian.deviation), 0.08);
  EXPECT_LT(std::hypot(radian.mean, radian.deviation), 0.16);
  EXPECT_GT(radian.mean, 0.03);
}

TEST(OdometryPresets, GoWorseFromGoodToAwful) {
  for (const char* world : {"street", "atrium", "hall"}) {
    const double good = mean_end_error(world, odometry("good"));
    const double bad = mean_end_error(world, odometry("bad"));
    const double awful = mean_end_error(world, odometry("awful"));
    EXPECT_GT(bad, 1.5 * good) << world;
    EXPECT_GT(awful, 1.3 * bad) << world;
    EXPECT_GT(awful, 10.0) << world;
  }
}

TEST(OdometryPresets, TheSameSeedGivesTheSameBits) {
  const std::vector<double> stamps = {0.0, 0.7, 1.9, 4.0};
  const PoseAtTime straight = [](double time) { return Pose2{time, 0.0, 0.1 * time}; };
  for (const Preset& preset : odometry_presets()) {
    const OdometryOptions options = odometry(preset.name);
    const Pose2 end = simulate_odometry(straight, stamps, options, 3).back().odom_from_base;
    EXPECT_EQ(end, simulate_odometry(straight, stamps, options, 3).back().odom_from_base);
    if (preset.name != "perfect") {
      EXPECT_NE(end, simulate_odometry(straight, stamps, options, 4).back().odom_from_base);
    }
  }
}

}  // namespace
}  // namespace matchbox_slam
