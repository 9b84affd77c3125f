#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "common/error_text.hpp"
#include "motion/motion_tracker.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kBeams = 101;

/// A scan that takes `duration` seconds.
ScanInput scan_at(double stamp, double duration = 0.0) {
  ScanInput input;
  input.scan.stamp = stamp;
  input.scan.ranges.assign(kBeams, 3.0F);
  input.scan.time_increment = duration / static_cast<double>(kBeams - 1);
  return input;
}

ScanInput scan_with_odometry(double stamp, const Pose2& odom_from_base,
                             const Pose2& odom_from_base_last_beam) {
  ScanInput input = scan_at(stamp, 0.04);
  input.odometry = ScanOdometry{odom_from_base, odom_from_base_last_beam};
  return input;
}

MatchResult match_at(const Pose2& pose, MatchStatus status = MatchStatus::kAccepted) {
  MatchResult match;
  match.map_from_base = pose;
  match.status = status;
  return match;
}

void expect_near(const Pose2& actual, const Pose2& expected, double tolerance = 1e-12) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(actual.theta, expected.theta, tolerance);
}

const Eigen::Matrix3d kNone = Eigen::Matrix3d::Zero();

/// The scan was predicted, and found to be here, exactly.
void fix(MotionTracker& tracker, const ScanInput& input, const Pose2& pose) {
  tracker.remember(input, tracker.predict(input), pose, kNone, true);
}

/// Nothing was found, so that the prediction stands.
void miss(MotionTracker& tracker, const ScanInput& input) {
  const MotionPrediction predicted = tracker.predict(input);
  tracker.remember(input, predicted, predicted.fixed_from_base, predicted.covariance, false);
}

/// Half a metre a second, ahead.
MotionTracker tracker_of_steady_robot() {
  MotionTracker tracker({});
  for (const int i : {0, 1}) {
    const Pose2 pose{0.05 * i, 0.0, 0.0};
    fix(tracker, scan_with_odometry(1.0 + 0.1 * i, pose, pose), pose);
  }
  return tracker;
}

/// Walls to both sides: they tell where the base is across and its heading, and nothing along.
void match_in_corridor(MotionTracker& tracker, const ScanInput& input) {
  const MotionPrediction predicted = tracker.predict(input);
  Eigen::Matrix3d covariance = predicted.covariance;
  covariance.row(1).setZero();
  covariance.col(1).setZero();
  covariance.row(2).setZero();
  covariance.col(2).setZero();
  covariance.diagonal() += Eigen::Vector3d(0.0, 1e-6, 1e-8);
  tracker.remember(input, predicted, predicted.fixed_from_base, covariance, true);
}

// --- input ---

TEST(MotionTracker, RefusesScansOutOfOrder) {
  MotionTracker tracker({});
  EXPECT_NO_THROW((void)tracker.predict(scan_at(-7.0))) << "the first one may have any stamp";
  fix(tracker, scan_at(5.0), {});
  EXPECT_NO_THROW((void)tracker.predict(scan_at(5.001)));
  for (const double stamp : {5.0, 4.999, std::numeric_limits<double>::quiet_NaN()}) {
    const std::string text =
        error_text<std::invalid_argument>([&] { (void)tracker.predict(scan_at(stamp)); });
    EXPECT_TRUE(contains(text, "is not later than the one before, at 5.000000 s")) << text;
  }
  ScanInput of_another_laser = scan_at(5.0);
  of_another_laser.laser = 1;
  EXPECT_NO_THROW((void)tracker.predict(of_another_laser));
  of_another_laser.scan.stamp = 4.999;
  EXPECT_THROW((void)tracker.predict(of_another_laser), std::invalid_argument);
}

TEST(MotionTracker, RefusesWhatIsNoNumber) {
  const MotionTracker tracker({});
  const auto refused = [&](const ScanInput& input, const std::string& words) {
    const std::string text =
        error_text<std::invalid_argument>([&] { (void)tracker.predict(input); });
    EXPECT_TRUE(contains(text, words)) << text;
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  refused(scan_with_odometry(1.0, {kNan, 0.0, 0.0}, {}), "is no number; leave it out");
  refused(scan_with_odometry(1.0, {}, {0.0, 0.0, kNan}), "is no number; leave it out");
  ScanInput input = scan_at(1.0);
  input.base_from_laser.translation().x() = std::numeric_limits<double>::infinity();
  refused(input, "the laser's pose for the scan at 1.000000 s is no number");
}

// --- predictions ---

TEST(MotionTracker, StartsWhereItIsTold) {
  MotionTracker tracker({});
  const Eigen::Matrix3d covariance = Eigen::Vector3d(1.0, 2.0, 3.0).asDiagonal();
  tracker.set_pose({10.0, -20.0, 3.0}, covariance);
  const MotionPrediction predicted = tracker.predict(scan_at(1.0, 0.1));
  EXPECT_EQ(predicted.fixed_from_base, (Pose2{10.0, -20.0, 3.0}));
  EXPECT_EQ(predicted.covariance, covariance);
  EXPECT_EQ(predicted.during_scan, Pose2{});
}

/// Defect of another implementation: the odometry's increment was added to the pose unrotated.
TEST(MotionTracker, OdometryMovesAlongTheHeadingInTheFixedFrame) {
  MotionTracker tracker({});
  fix(tracker, scan_with_odometry(1.0, {7.0, 8.0, 0.0}, {}), {0.0, 0.0, 0.5 * kPi});
  const MotionPrediction predicted =
      tracker.predict(scan_with_odometry(2.0, {8.0, 8.0, 0.0}, {8.1, 8.0, 0.0}));
  expect_near(predicted.fixed_from_base, {0.0, 1.0, 0.5 * kPi});
  expect_near(predicted.during_scan, {0.1, 0.0, 0.0});
}

/// Of what a match corrected after this long; the rest is put down to the prediction's floor.
double share_of_velocity(double seconds) {
  const MotionPriorOptions options;
  const double by_velocity = std::pow(options.velocity_change * seconds, 2);
  return by_velocity / (by_velocity + std::pow(options.translation_floor, 2));
}

TEST(MotionTracker, WithoutOdometryTheMotionFromFixToFixGoesOn) {
  for (const GuessSource source : {GuessSource::kOdometry, GuessSource::kVelocity}) {
    MotionTracker tracker({}, source);
    fix(tracker, scan_at(1.0), {2.0, 0.0, 0.5 * kPi});
    miss(tracker, scan_at(1.5));
    fix(tracker, scan_at(2.0), {2.0, 0.4, 0.5 * kPi});
    // 0.4 m a second ahead.
    const MotionPrediction predicted = tracker.predict(scan_at(2.5, 0.25));
    expect_near(predicted.fixed_from_base, {2.0, 0.4 + 0.2 * share_of_velocity(1.0), 0.5 * kPi});
    expect_near(predicted.during_scan, {0.1 * share_of_velocity(1.0), 0.0, 0.0});
    tracker.forget_motion();
    EXPECT_EQ(tracker.predict(scan_at(2.5, 0.25)).during_scan, Pose2{});
    expect_near(tracker.predict(scan_at(2.5)).fixed_from_base, {2.0, 0.4, 0.5 * kPi});
  }
}

/// Walls to both sides, and nothing along for this long; then the base is found further on.
MotionTracker after_corridor(double seconds, double further) {
  MotionTracker tracker({});
  for (const double stamp : {-0.2, -0.1, 0.0}) {
    fix(tracker, scan_at(stamp), {0.5 * stamp, 0.0, 0.0});
  }
  double stamp = 0.1;
  for (; stamp < seconds - 0.05; stamp += 0.1) {
    match_in_corridor(tracker, scan_at(stamp));
  }
  const Pose2 predicted = tracker.predict(scan_at(stamp)).fixed_from_base;
  fix(tracker, scan_at(stamp), {predicted.x + further, 0.0, 0.0});
  return tracker;
}

TEST(MotionTracker, WhatWasCorrectedCameInAllOfTheTimeThatNothingToldOf) {
  for (const double seconds : {0.1, 1.0, 3.0}) {
    const double speed = after_corridor(seconds, 0.3).state().velocity().x() -
                         after_corridor(seconds, 0.0).state().velocity().x();
    const double expected = 0.3 / seconds * share_of_velocity(seconds);
    EXPECT_NEAR(speed, expected, 0.05 * expected) << "after " << seconds << " s";
  }
}

TEST(MotionTracker, OnlyKOdometryBelievesTheWheels) {
  for (const GuessSource source : {GuessSource::kVelocity, GuessSource::kHeading}) {
    MotionTracker tracker({}, source, 0.005);
    fix(tracker, scan_with_odometry(1.0, {0.0, 0.0, 3.0}, {}), {});
    const MotionPrediction predicted =
        tracker.predict(scan_with_odometry(2.0, {5.0, 6.0, -3.0}, {7.0, 8.0, -2.9}));
    const bool by_heading = source == GuessSource::kHeading;
    expect_near(predicted.fixed_from_base, {0.0, 0.0, by_heading ? 2.0 * kPi - 6.0 : 0.0});
    expect_near(predicted.during_scan, {0.0, 0.0, by_heading ? 0.1 : 0.0});
    if (by_heading) {
      EXPECT_NEAR(predicted.covariance(2, 2), 0.005 * 0.005, 1e-15);
    }
  }
}

TEST(MotionTracker, OfAHeadingAloneOnlyTheTurnIsBelieved) {
  MotionTracker tracker({});
  const auto heading = [](double stamp, double theta, double theta_last) {
    ScanInput input = scan_with_odometry(stamp, {7.0, 8.0, theta}, {9.0, 9.0, theta_last});
    input.odometry->is_heading_only = true;
    return input;
  };
  fix(tracker, heading(1.0, 3.0, 3.0), {});
  const MotionPrediction predicted = tracker.predict(heading(2.0, -3.0, -2.9));
  expect_near(predicted.fixed_from_base, {0.0, 0.0, 2.0 * kPi - 6.0});
  expect_near(predicted.during_scan, {0.0, 0.0, 0.1});
  EXPECT_NEAR(predicted.covariance(2, 2), 0.02 * 0.02, 1e-15);
}

TEST(MotionTracker, UncertaintyGoesOnFromThatOfTheNewestScan) {
  MotionPriorOptions options;
  MotionTracker tracker(options);
  const Eigen::Matrix3d before = Eigen::Vector3d(0.01, 0.02, 0.04).asDiagonal();
  const ScanInput first = scan_with_odometry(1.0, {}, {});
  tracker.remember(first, tracker.predict(first), {}, before, true);
  const MotionPrediction predicted = tracker.predict(scan_with_odometry(2.0, {1.0, 0.0, 0.0}, {}));
  const MotionEstimate step = motion_from_odometry(Pose2{}, Pose2{1.0, 0.0, 0.0}, 1.0, options);
  const Eigen::Matrix3d added = step.covariance + step.floor;
  EXPECT_NEAR(predicted.covariance(0, 0), 0.01 + added(0, 0), 1e-12);
  EXPECT_NEAR(predicted.covariance(1, 1), 0.02 + 0.04 + added(1, 1), 1e-12) << "by the heading's";
}

// --- the same uncertainty at any rate ---

/// Drives `speed` m/s ahead or `turn_rate` rad/s on the spot for two seconds, with so many scans a
/// second, and predicts what comes another half a second later.
/// @param process  what becomes of a scan: MotionTracker&, ScanInput.
template <typename Process>
Eigen::Matrix3d covariance_after_two_seconds(GuessSource source, double speed, double turn_rate,
                                             int rate, bool with_odometry, Process process) {
  MotionTracker tracker({}, source, 0.005);
  const auto input_at = [&](double passed) {
    ScanInput input = scan_at(10.0 + passed);
    if (with_odometry) {
      const Pose2 pose{speed * passed, 0.0, wrap_angle(turn_rate * passed)};
      input.odometry = ScanOdometry{pose, pose};
    }
    return input;
  };
  fix(tracker, input_at(-1.0), {-speed, 0.0, -turn_rate});
  fix(tracker, input_at(0.0), {});
  for (int i = 1; i <= 2 * rate; ++i) {
    process(tracker, input_at(static_cast<double>(i) / rate));
  }
  return tracker.predict(input_at(2.5)).covariance;
}

TEST(MotionTracker, UnmatchedScansInBetweenChangeNothing) {
  for (const GuessSource source :
       {GuessSource::kOdometry, GuessSource::kVelocity, GuessSource::kHeading}) {
    for (const double turn_rate : {0.0, 0.7}) {
      const double speed = turn_rate == 0.0 ? 0.8 : 0.0;
      const auto at_rate = [&](int rate) {
        return covariance_after_two_seconds(source, speed, turn_rate, rate, true, miss);
      };
      const Eigen::Matrix3d none = at_rate(0);
      EXPECT_GT(none(0, 0), 0.01);
      for (const int rate : {1, 5, 10, 40}) {
        EXPECT_TRUE(at_rate(rate).isApprox(none, 1e-12)) << rate << " scans a second:\n"
                                                         << at_rate(rate) << "\nwithout:\n"
                                                         << none;
      }
    }
  }
}

TEST(MotionTracker, WhatNoWallTellsIsAsUncertainAtAnyRate) {
  for (const bool with_odometry : {true, false}) {
    const auto along = [&](int rate) {
      return covariance_after_two_seconds(GuessSource::kOdometry, 0.8, 0.0, rate, with_odometry,
                                          match_in_corridor)(0, 0);
    };
    const double at_one = along(1);
    EXPECT_GT(at_one, 0.1);
    for (const int rate : {5, 10, 20, 40}) {
      EXPECT_NEAR(along(rate), at_one, 1e-9 * at_one) << rate << " scans a second";
    }
  }
}

TEST(MotionTracker, WithoutOdometryTheUncertaintyGrowsWithTheTimeSinceTheMatch) {
  const auto after = [](double passed) {
    MotionTracker tracker({});
    fix(tracker, scan_at(0.0), {});
    fix(tracker, scan_at(1.0), {});
    for (double stamp = 1.1; stamp < 0.95 + passed; stamp += 0.1) {
      miss(tracker, scan_at(stamp));
    }
    return tracker.predict(scan_at(1.0 + passed)).covariance;
  };
  const MotionPriorOptions options;
  for (const double passed : {0.1, 0.5, 2.0}) {
    const double position = options.velocity_change * passed;
    const double heading = options.turn_rate_change * passed;
    const Eigen::Matrix3d covariance = after(passed);
    EXPECT_NEAR(covariance(0, 0), position * position + std::pow(options.translation_floor, 2),
                1e-9);
    EXPECT_NEAR(covariance(2, 2), heading * heading + std::pow(options.rotation_floor, 2), 1e-9);
  }
}

// --- what a match says ---

TEST(MotionTracker, AMatchGoesTooFarWhereTheMotionInTheScanWasPredicted) {
  MotionTracker tracker({});
  fix(tracker, scan_at(0.9), {});
  fix(tracker, scan_at(1.0), {});
  const ScanInput input = scan_at(1.1, 0.1);  // sweeps all the time
  const MotionPrediction predicted = tracker.predict(input);
  EXPECT_EQ(predicted.during_scan, Pose2{}) << "it was at rest";
  const MatchedMotion matched = tracker.after_match(input, predicted, match_at({0.3, -0.6, 0.15}));
  expect_near(matched.fixed_from_base, {0.2, -0.4, 0.1});
  expect_near(matched.during_scan, {0.2, -0.4, 0.1});
  // Told by odometry, by nothing or all at once, it stays as it is.
  const MatchedMotion rejected = tracker.after_match(
      input, predicted, match_at({0.3, -0.6, 0.15}, MatchStatus::kRejectedLowScore));
  EXPECT_EQ(rejected.fixed_from_base, (Pose2{0.3, -0.6, 0.15}));
  EXPECT_EQ(rejected.during_scan, Pose2{});
  MotionPrediction far_off = predicted;
  far_off.fixed_from_base = {0.7, 0.7, 0.7};
  EXPECT_EQ(tracker.after_match(scan_at(1.1), far_off, match_at({0.1, 0.1, 0.1})).fixed_from_base,
            (Pose2{0.1, 0.1, 0.1}));
  const ScanInput measured = scan_with_odometry(1.1, {}, {0.1, 0.0, 0.0});
  const MotionPrediction by_odometry = tracker.predict(measured);
  const MatchedMotion stays =
      tracker.after_match(measured, by_odometry, match_at({0.3, -0.6, 0.15}));
  EXPECT_EQ(stays.fixed_from_base, (Pose2{0.3, -0.6, 0.15}));
  EXPECT_EQ(stays.during_scan, by_odometry.during_scan);
}

TEST(MotionTracker, AHeadingThatWasMeasuredDidNotGoTooFar) {
  MotionTracker tracker({}, GuessSource::kHeading, 0.005);
  fix(tracker, scan_at(1.0), {});
  ScanInput input = scan_at(1.1, 0.1);
  input.odometry = ScanOdometry{{0.0, 0.0, 1.0}, {0.0, 0.0, 1.2}};
  const MatchedMotion matched =
      tracker.after_match(input, tracker.predict(input), match_at({0.3, -0.6, 0.15}));
  expect_near(matched.fixed_from_base, {0.2, -0.4, 0.15});
  expect_near(matched.during_scan, {0.2, -0.4, 0.2});
}

// --- its state ---

TEST(MotionTracker, APoseThatIsToldIsNoMotion) {
  const Pose2 told{50.0, 60.0, 1.0};
  const Pose2 step{0.1, 0.0, 0.0};
  const Pose2 goes_on{0.1 * share_of_velocity(1.0), 0.0, 0.0};
  MotionTracker tracker({});
  fix(tracker, scan_at(1.0), {});
  fix(tracker, scan_at(2.0), step);
  tracker.set_pose(told, kNone);
  expect_near(tracker.predict(scan_at(3.0)).fixed_from_base, told * goes_on);
  fix(tracker, scan_at(3.0), told);
  expect_near(tracker.predict(scan_at(4.0)).fixed_from_base, told * goes_on);
  // A base that was lost has no motion that is known.
  miss(tracker, scan_at(4.0));
  tracker.set_pose(told, kNone);
  expect_near(tracker.predict(scan_at(5.0)).fixed_from_base, told);
}

TEST(MotionTracker, ItsStateIsAllThatItKnows) {
  MotionTracker tracker({});
  fix(tracker, scan_with_odometry(1.0, {}, {}), {});
  fix(tracker, scan_with_odometry(2.0, {}, {}), {0.1, 0.0, 0.2});
  MotionTracker other({});
  other.set_state(tracker.state());
  for (const ScanInput& input :
       {scan_at(2.5, 0.1), scan_with_odometry(2.5, {0.1, 0.0, 0.0}, {0.2, 0.0, 0.0})}) {
    const MotionPrediction a = tracker.predict(input);
    const MotionPrediction b = other.predict(input);
    EXPECT_EQ(a.fixed_from_base, b.fixed_from_base);
    EXPECT_EQ(a.covariance, b.covariance);
    EXPECT_EQ(a.during_scan, b.during_scan);
    EXPECT_EQ(tracker.after_match(input, a, match_at({})).fixed_from_base,
              other.after_match(input, b, match_at({})).fixed_from_base);
  }
}

// --- odometry that tells of improbable steps ---

TEST(MotionTracker, GoesOnSteadilyWhereOdometryTellsOfNoMotionOfARobot) {
  const MotionTracker tracker = tracker_of_steady_robot();
  // It is set to another pose, or catches up.
  for (const Pose2& jumped :
       {Pose2{1.1, 0.0, 0.0}, Pose2{0.1, -1.0, 0.0}, Pose2{0.1, 0.0, 1.0}, Pose2{0.35, 0.0, 0.0}}) {
    const auto steady = tracker.predict_steadily(scan_with_odometry(1.2, jumped, jumped));
    ASSERT_TRUE(steady);
    expect_near(steady->fixed_from_base, {0.1, 0.0, 0.0});
  }
}

TEST(MotionTracker, OdometryThatIsSetMeanwhileTearsNoScan) {
  const MotionTracker tracker = tracker_of_steady_robot();
  const Pose2 first{0.1, 0.0, 0.0};
  const auto during = [&](const Pose2& last) {
    return tracker.predict(scan_with_odometry(1.2, first, last)).during_scan;
  };
  expect_near(during({0.13, 0.0, 0.0}), {0.03, 0.0, 0.0});
  expect_near(during({1.1, 0.0, 0.0}), {0.02, 0.0, 0.0});
}

TEST(MotionTracker, TakesOdometryAtItsWordWhereARobotMayMoveSo) {
  const MotionTracker tracker = tracker_of_steady_robot();
  // It brakes, or goes on by 2 m/s faster, or turns by 4 rad/s.
  for (const Pose2& moved : {Pose2{0.05, 0.0, 0.0}, Pose2{0.3, 0.0, 0.0}, Pose2{0.1, 0.0, 0.4}}) {
    EXPECT_FALSE(tracker.predict_steadily(scan_with_odometry(1.2, moved, moved)));
  }
  const Pose2 later{1.1, 0.0, 0.0};
  EXPECT_FALSE(tracker.predict_steadily(scan_with_odometry(2.1, later, later))) << "a second later";
}

TEST(MotionTracker, TwoPosesInOneMillisecondTellNoVelocity) {
  MotionTracker tracker({});
  for (const int i : {0, 1}) {  // of two lasers, which differ by a centimetre
    const Pose2 pose{0.01 * i, 0.0, 0.0};
    fix(tracker, scan_with_odometry(1.0 + 0.001 * i, {}, {}), pose);
  }
  EXPECT_FALSE(tracker.predict_steadily(scan_with_odometry(1.1, {}, {})));
}

TEST(MotionTracker, KnowsNoSteadyMotionWithoutOdometryOrMatches) {
  MotionTracker tracker = tracker_of_steady_robot();
  EXPECT_FALSE(tracker.predict_steadily(scan_at(1.2)));
  const Pose2 jumped{3.0, 0.0, 0.0};
  miss(tracker, scan_with_odometry(1.2, {}, {}));
  EXPECT_FALSE(tracker.predict_steadily(scan_with_odometry(1.3, jumped, jumped)));
  EXPECT_FALSE(MotionTracker({}).predict_steadily(scan_with_odometry(1.3, jumped, jumped)));
}

/// Driven straight on, each step matched as odometry said.
MotionTracker tracker_of_good_odometry(GuessSource source, double min_noise_scale) {
  MotionPriorOptions options;
  options.min_noise_scale = min_noise_scale;
  MotionTracker tracker(options, source, 0.01);
  for (int i = 0; i < 200; ++i) {
    const Pose2 pose{0.1 * i, 0.0, 0.0};
    const ScanInput input = scan_with_odometry(0.1 * i, pose, pose);
    const MotionPrediction predicted = tracker.predict(input);
    MatchResult match = match_at(pose);
    match.covariance = 1e-8 * Eigen::Matrix3d::Identity();
    tracker.learn(input, predicted, match);
    tracker.remember(input, predicted, pose, match.covariance, true);
  }
  return tracker;
}

Eigen::Matrix3d next_covariance(const MotionTracker& tracker) {
  const Pose2 pose{20.0, 0.0, 0.0};
  return tracker.predict(scan_with_odometry(20.0, pose, pose)).covariance;
}

TEST(MotionTracker, TrustsOdometryThatWasGood) {
  const MotionTracker tracker = tracker_of_good_odometry(GuessSource::kOdometry, 0.2);
  const Eigen::Matrix3d as_set =
      next_covariance(tracker_of_good_odometry(GuessSource::kOdometry, 1.0));
  EXPECT_EQ(tracker.state().noise_scale.translation, 0.2);
  EXPECT_NEAR(next_covariance(tracker)(0, 0), 0.04 * as_set(0, 0), 1e-7);
  EXPECT_NEAR(next_covariance(tracker)(2, 2), 0.04 * as_set(2, 2), 1e-7);
}

/// Of 100 m straight on, in a frame that moves meanwhile, whose odometry tells 2 % too much.
MotionTracker tracker_of_long_odometry(bool calibrate) {
  MotionPriorOptions options;
  options.calibrate = calibrate;
  MotionTracker tracker(options);
  Pose2 new_from_first;
  for (int i = 0; i < 1000; ++i) {
    const Pose2 told{0.102 * i, 0.0, 0.0};
    const ScanInput input = scan_with_odometry(0.1 * i, told, told);
    const MotionPrediction predicted = tracker.predict(input);
    MatchResult match = match_at(new_from_first * Pose2{0.1 * i, 0.0, 0.0});
    match.covariance = 1e-8 * Eigen::Matrix3d::Identity();
    tracker.learn(input, predicted, match);
    tracker.remember(input, predicted, match.map_from_base, match.covariance, true);
    if (i % 7 == 3) {
      const Pose2 moved{1.0, -2.0, 0.5};
      tracker.change_frame(moved);
      new_from_first = moved * new_from_first;
    }
  }
  return tracker;
}

TEST(MotionTracker, TakesOutSystematicErrorsOfOdometry) {
  const Pose2 told{0.102 * 999 + 1.02, 0.0, 0.0};
  const auto way = [&](const MotionTracker& tracker) {
    return tracker.predict(scan_with_odometry(101.0, told, told))
        .motion.previous_from_current.translation()
        .norm();
  };
  EXPECT_NEAR(way(tracker_of_long_odometry(true)), 1.0, 0.001);
  EXPECT_NEAR(way(tracker_of_long_odometry(false)), 1.02, 1e-9);
}

TEST(MotionTracker, DoesNotTrustOdometryThatAMatchRefuted) {
  MotionTracker tracker = tracker_of_good_odometry(GuessSource::kOdometry, 0.2);
  const Pose2 jumped{22.0, 0.0, 0.0};
  const ScanInput input = scan_with_odometry(20.0, jumped, jumped);
  const auto steady = tracker.predict_steadily(input);
  ASSERT_TRUE(steady);
  tracker.learn(input, *steady, match_at({20.0, 0.0, 0.0}));
  EXPECT_EQ(tracker.state().noise_scale.translation, 1.0);
}

/// Neither it nor the next one, which has none to compare with.
TEST(MotionTracker, TrustsOdometryAfterAScanWithout) {
  MotionTracker tracker = tracker_of_good_odometry(GuessSource::kOdometry, 0.2);
  for (const int i : {0, 1}) {
    const Pose2 pose{20.0 + 0.1 * i, 0.0, 0.0};
    ScanInput input = scan_with_odometry(20.0 + 0.1 * i, pose, pose);
    if (i == 0) {
      input.odometry.reset();
    }
    const MotionPrediction predicted = tracker.predict(input);
    tracker.learn(input, predicted, match_at(pose));
    EXPECT_EQ(tracker.state().noise_scale.translation, 0.2) << i;
    tracker.remember(input, predicted, pose, kNone, true);
  }
}

TEST(MotionTracker, LearnsNothingOfWhatItDoesNotPredictFrom) {
  for (const GuessSource source : {GuessSource::kVelocity, GuessSource::kHeading}) {
    EXPECT_EQ(tracker_of_good_odometry(source, 0.2).state().noise_scale.translation, 1.0);
  }
}

}  // namespace
}  // namespace matchbox_slam
