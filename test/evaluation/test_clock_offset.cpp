#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <stdexcept>

#include "common/error_text.hpp"
#include "evaluation/clock_offset.hpp"
#include "io/real_data.hpp"
#include "io/stata_truth.hpp"
#include "matchbox_slam/io/file.hpp"

namespace matchbox_slam {
namespace {

/// Drives at changing speed through changing curves; never the same twice.
Trajectory winding_path(double seconds, double start = 1000.0) {
  std::vector<StampedPose2> poses;
  Pose2 pose;
  for (int i = 0; i * 0.1 < seconds; ++i) {
    const double t = 0.1 * i;
    poses.push_back({start + t, pose});
    const double speed = 0.4 + 0.3 * std::sin(0.11 * t) * std::cos(0.037 * t * std::sqrt(t));
    const double turn = 0.5 * std::sin(0.13 * t) + 0.3 * std::sin(0.071 * t + 1.0);
    pose = pose * Pose2{0.1 * speed, 0.0, 0.1 * turn};
  }
  return Trajectory(poses);
}

/// What a recording of `truth` by another clock and in another frame looks like.
Trajectory recorded(const Trajectory& truth, double offset, double noise = 0.0,
                    const Pose2& laser_from_base = {}) {
  std::mt19937 engine(7);
  std::normal_distribution<double> normal(0.0, 1.0);
  const Pose2 map_from_truth{3.0, -8.0, 2.0};
  std::vector<StampedPose2> poses = truth.poses();
  for (StampedPose2& stamped : poses) {
    stamped.stamp += offset;
    stamped.pose = map_from_truth * stamped.pose * laser_from_base;
    stamped.pose.x += noise * normal(engine);
    stamped.pose.y += noise * normal(engine);
  }
  return Trajectory(poses);
}

/// Poses at odd stamps: a varying number of them is left out, and the others lie between two.
Trajectory at_odd_stamps(const Trajectory& trajectory) {
  std::vector<StampedPose2> kept;
  double stamp = trajectory.poses().front().stamp + 0.013;
  for (int i = 0; stamp < trajectory.poses().back().stamp; ++i) {
    if (const auto pose = trajectory.at(stamp, 1.0)) {
      kept.push_back({stamp, *pose});
    }
    stamp += 0.17 + 0.2 * (i % 7);
  }
  return Trajectory(kept);
}

Trajectory part(const Trajectory& trajectory, double from, double to) {
  std::vector<StampedPose2> kept;
  for (const StampedPose2& stamped : trajectory.poses()) {
    if (stamped.stamp >= from && stamped.stamp <= to) {
      kept.push_back(stamped);
    }
  }
  return Trajectory(kept);
}

TEST(FindClockOffset, FindsWhateverOffsetInTheRange) {
  const Trajectory truth = winding_path(200.0);
  for (const double offset : {82.2, -37.123, 0.0, 3.996}) {
    EXPECT_NEAR(find_clock_offset(recorded(truth, offset), truth).offset, offset, 0.001);
  }
}

TEST(FindClockOffset, OddStampsAndNoiseCostHundredths) {
  const Trajectory truth = winding_path(200.0);
  const Trajectory noisy = at_odd_stamps(recorded(truth, 82.2, 0.03));
  EXPECT_NEAR(find_clock_offset(noisy, truth).offset, 82.2, 0.02);
}

TEST(FindClockOffset, FindsAnEstimateOfWhichUpToHalfLiesOutsideTheTruth) {
  const Trajectory whole = winding_path(200.0);
  const Trajectory truth = part(whole, 1000.0, 1110.0);
  const Trajectory estimate = recorded(part(whole, 1050.0, 1160.0), 20.0, 0.01);
  EXPECT_NEAR(find_clock_offset(estimate, truth).offset, 20.0, 0.02);
  EXPECT_NEAR(find_clock_offset(truth, estimate).offset, -20.0, 0.02);
}

TEST(FindClockOffset, TheCurveIsOrderedAndLeastAtTheOffset) {
  const Trajectory truth = winding_path(100.0);
  const ClockOffset found = find_clock_offset(recorded(truth, 10.0), truth);
  ASSERT_GT(found.curve.size(), 200U);
  for (std::size_t i = 1; i < found.curve.size(); ++i) {
    EXPECT_LT(found.curve[i - 1].offset, found.curve[i].offset);
  }
  const auto least = std::min_element(
      found.curve.begin(), found.curve.end(),
      [](const ClockOffsetFit& a, const ClockOffsetFit& b) { return a.rmse < b.rmse; });
  EXPECT_NEAR(least->offset, 10.0, 0.006);
  EXPECT_EQ(least->poses, 1000U);
  // From far away too, where the error falls and rises on the way.
  EXPECT_LT(found.curve.front().offset, -30.0);
}

TEST(FindClockOffset, SaysSoWhenTheRobotRests) {
  std::vector<StampedPose2> poses;
  for (int i = 0; i < 500; ++i) {
    poses.push_back({0.1 * i, {1.0, 2.0, 0.3}});
  }
  const Trajectory rest(poses);
  const std::string text = error_text<EvaluationError>(
      [&] { (void)find_clock_offset(recorded(rest, 1.0, 0.002), rest); });
  EXPECT_TRUE(contains(text, "hardly depends on it")) << text;
}

TEST(FindClockOffset, SaysSoWhenTheRobotDrivesStraightOrInCircles) {
  for (const double turn : {0.0, 0.05}) {
    std::vector<StampedPose2> poses;
    Pose2 pose;
    for (int i = 0; i < 600; ++i) {
      poses.push_back({0.1 * i, pose});
      pose = pose * Pose2{0.05, 0.0, turn};
    }
    const Trajectory drive(poses);
    const std::string text = error_text<EvaluationError>(
        [&] { (void)find_clock_offset(recorded(drive, 5.0, 0.01), drive); });
    EXPECT_TRUE(contains(text, "hardly depends on it")) << text;
  }
}

TEST(FindClockOffset, SaysSoWhenTheRobotRepeatsItsPath) {
  std::vector<StampedPose2> poses;
  for (int i = 0; i < 2000; ++i) {
    const double phase = 2.0 * kPi * (0.1 * i) / 25.0;  // a figure eight in 25 s
    poses.push_back({0.1 * i, {3.0 * std::sin(phase), std::sin(2.0 * phase), 0.0}});
  }
  const Trajectory laps(poses);
  const std::string text = error_text<EvaluationError>(
      [&] { (void)find_clock_offset(recorded(laps, 4.0, 0.01), laps); });
  EXPECT_TRUE(contains(text, "two fit about equally well")) << text;
  ClockOffsetOptions near;
  near.range = 10.0;
  EXPECT_NEAR(find_clock_offset(recorded(laps, 4.0, 0.01), laps, near).offset, 4.0, 0.01);
}

TEST(FindClockOffset, SaysSoWhenTheOffsetLiesBeyondTheRange) {
  const Trajectory truth = winding_path(200.0);
  ClockOffsetOptions narrow;
  narrow.range = 4.0;
  const std::string text = error_text<EvaluationError>(
      [&] { (void)find_clock_offset(recorded(truth, 5.5), truth, narrow); });
  EXPECT_TRUE(contains(text, "search a wider one")) << text;
}

TEST(FindClockOffset, NamesBothTimeRangesWhenTheyNeverOverlap) {
  const std::string text = error_text<EvaluationError>(
      [] { (void)find_clock_offset(winding_path(10.0, 0.0), winding_path(10.0, 5000.0)); });
  EXPECT_TRUE(contains(text, "0.000 to 9.900 s")) << text;
  EXPECT_TRUE(contains(text, "5000.000 to 5009.900 s")) << text;
  EXPECT_EQ(error_text<EvaluationError>([] { (void)find_clock_offset({}, winding_path(1.0)); }),
            "the estimate holds no poses");
}

TEST(FindClockOffset, RefusesOptionsThatAreNotAllowed) {
  ClockOffsetOptions options;
  options.range = 0.0;
  const Trajectory path = winding_path(10.0);
  EXPECT_THROW((void)find_clock_offset(path, path, options), std::invalid_argument);
  options.range = 1e12;  // as many steps as no int counts
  EXPECT_THROW((void)find_clock_offset(path, path, options), std::invalid_argument);
}

TEST(FindClockOffset, FindsItInTwentyThousandPoses) {
  std::vector<StampedPose2> poses;
  const Trajectory coarse = winding_path(1000.0);
  for (int i = 0; i < 19900; ++i) {
    const double stamp = 1000.0 + 0.05 * i;
    poses.push_back({stamp, *coarse.at(stamp, 1.0)});
  }
  const Trajectory truth(poses);
  const ClockOffset found = find_clock_offset(recorded(truth, 82.2), truth);
  EXPECT_NEAR(found.offset, 82.2, 0.001);
  for (const ClockOffsetFit& fit : found.curve) {
    EXPECT_LE(fit.poses, 2000U);  // the others are left out, or it would take long
  }
}

TEST(FindClockOffset, EveryFitOfTheCurveOverlapsEnough) {
  const Trajectory whole = winding_path(200.0);
  const Trajectory estimate = recorded(part(whole, 1050.0, 1160.0), 20.0, 0.01);
  ClockOffsetOptions options;
  for (const double share : {0.3, 0.4, 0.5}) {
    options.min_overlap = share;
    const auto curve = find_clock_offset(estimate, part(whole, 1000.0, 1110.0), options).curve;
    std::size_t most = 0;
    for (const ClockOffsetFit& fit : curve) {
      most = std::max(most, fit.poses);
    }
    for (const ClockOffsetFit& fit : curve) {
      EXPECT_GE(static_cast<double>(fit.poses), share * static_cast<double>(most)) << fit.offset;
    }
  }
}

/// Turns and speeds of any seed.
Trajectory random_drive(std::mt19937& engine) {
  std::uniform_real_distribution<double> rate(0.05, 0.4);
  std::uniform_real_distribution<double> phase(0.0, 6.0);
  const auto wave = [&] {
    return [frequency = rate(engine), start = phase(engine)](double t) {
      return std::sin(frequency * t + start);
    };
  };
  const auto first = wave();
  const auto second = wave();
  const auto third = wave();
  const auto fourth = wave();
  std::vector<StampedPose2> poses;
  Pose2 pose;
  for (int i = 0; i < 2000; ++i) {
    const double t = 0.1 * i;
    poses.push_back({1000.0 + t, pose});
    const double speed = 0.5 + 0.3 * first(t) * second(t);
    pose = pose * Pose2{0.1 * speed, 0.0, 0.1 * (0.5 * third(t) + 0.4 * fourth(t))};
  }
  return Trajectory(poses);
}

TEST(FindClockOffset, NeverNamesAWrongOneForPiecesOfADrive) {
  std::size_t found = 0;
  std::size_t refused = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    std::mt19937 engine(seed);
    const Trajectory whole = random_drive(engine);
    std::uniform_real_distribution<double> start(1000.0, 1120.0);
    std::uniform_real_distribution<double> length(20.0, 80.0);
    const auto piece = [&](double from) { return part(whole, from, from + length(engine)); };
    const Trajectory truth = piece(start(engine));
    const double offset = std::uniform_real_distribution<double>(-60.0, 60.0)(engine);
    const Trajectory estimate = recorded(piece(start(engine)), offset, 0.03);
    try {
      EXPECT_NEAR(find_clock_offset(estimate, truth).offset, offset, 0.2) << "seed " << seed;
      ++found;
    } catch (const EvaluationError&) {
      ++refused;
    }
  }
  EXPECT_GT(found, 15U);  // else nothing is tested
  EXPECT_GT(refused, 15U);
}

TEST(FindClockOffset, SaysSoWhenPositionsOrHeadingsDoNotFit) {
  const Trajectory truth = winding_path(200.0);
  std::vector<StampedPose2> sideways = recorded(truth, 5.0).poses();
  std::vector<StampedPose2> strays = sideways;
  for (std::size_t i = 0; i < sideways.size(); ++i) {
    sideways[i].pose.theta += 0.4 * std::sin(0.01 * static_cast<double>(i));
    strays[i].pose.x += 2.0 * std::sin(0.1 * static_cast<double>(i));
  }
  const auto text_of = [&](const std::vector<StampedPose2>& poses) {
    return error_text<EvaluationError>([&] { (void)find_clock_offset(Trajectory(poses), truth); });
  };
  EXPECT_TRUE(contains(text_of(sideways), "headings differ by 0.28")) << text_of(sideways);
  EXPECT_TRUE(contains(text_of(strays), "positions differ by 1.")) << text_of(strays);
}

TEST(FindClockOffset, NeedsNoHeadingsAndNoParticularMounting) {
  const Trajectory truth = winding_path(200.0);
  std::vector<StampedPose2> positions = truth.poses();
  for (StampedPose2& stamped : positions) {
    stamped.pose.theta = 0.0;
  }
  EXPECT_NEAR(find_clock_offset(recorded(truth, 5.0, 0.01), Trajectory(positions)).offset, 5.0,
              0.01);
  EXPECT_NEAR(find_clock_offset(recorded(truth, 5.0, 0.01, {0.0, 0.0, kPi}), truth).offset, 5.0,
              0.01);
}

/// The bags of this day have the clock of the laser, in which truth is, 82.2 s behind the others.
TEST(FindClockOffset, FindsTheOffsetOfMitStata) {
  const std::string path = real_data("mit_stata_2012-01-25-12-33-29_part1_floor2.gt.laser.poses");
  MATCHBOX_SKIP_WITHOUT(path);
  const Trajectory laser = parse_stata_truth(read_file(path), path);
  ASSERT_EQ(laser.size(), 4000U);
  const Pose2 laser_from_base{-0.275, 0.0, 0.0};
  EXPECT_NEAR(find_clock_offset(recorded(laser, 82.2, 0.0, laser_from_base),
                                recorded(laser, 0.0, 0.0, laser_from_base))
                  .offset,
              82.2, 0.001);
  const Trajectory odd = at_odd_stamps(recorded(laser, 82.2, 0.02, laser_from_base));
  EXPECT_NEAR(find_clock_offset(odd, recorded(laser, 0.0, 0.0, laser_from_base)).offset, 82.2,
              0.05);
  // Without the lever arm the turns of the laser about the base look like a delay: 82.78 s.
  const std::string text =
      error_text<EvaluationError>([&] { (void)find_clock_offset(odd, laser); });
  EXPECT_TRUE(contains(text, "headings differ")) << text;
}

}  // namespace
}  // namespace matchbox_slam
