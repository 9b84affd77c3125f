#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "matchbox_slam/common/random.hpp"
#include "matching/hough/relocalise.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "simulation/robot.hpp"

namespace matchbox_slam {
namespace {

/// A pose of the route within a metre of the one at a time, turned anyhow.
Pose2 pose_around(const RobotMotion& motion, double time, Random& random) {
  Pose2 pose;
  do {
    pose = motion.pose(time + random.uniform(-2.5, 2.5));
  } while ((pose.translation() - motion.pose(time).translation()).norm() > 1.0);
  pose.theta = wrap_angle(random.uniform(-kPi, kPi));
  return pose;
}

std::size_t rank_of(const Pose2& truth, const Relocalisation& found) {
  std::size_t rank = 0;
  for (; rank < found.poses.size(); ++rank) {
    const Eigen::Vector3d error = shift_between(truth, found.poses[rank].map_from_base);
    if (error.head<2>().norm() < 0.02 && std::abs(error.z()) < 0.01) {
      break;
    }
  }
  return rank;
}

TEST(Relocalise, FindsTheRightPoseWithoutAPrior) {
  HoughOptions options;
  options.alignment.max_window_xy = 1.2;
  Random random(1);
  int tried = 0;
  int first = 0;
  int among_four = 0;
  for (std::uint64_t seed = 20; seed < 25; ++seed) {
    const World world = make_rooms_world(seed);
    const RobotMotion motion = drive(world.route(), {});
    for (std::uint64_t i = 0; i < 40; ++i, ++tried) {
      const double time = random.uniform(3.0, 100.0);
      const Pose2 truth = pose_around(motion, time, random);
      const PlacedScans key_scans = {
          placed(look_around(world, {}, motion.pose(time), i), motion.pose(time))};
      const PointScan scan = look_around(world, {}, truth, i + 100);
      const std::size_t rank = rank_of(truth, relocalise(scan, key_scans, options));
      first += rank == 0 ? 1 : 0;
      among_four += rank < 4 ? 1 : 0;
    }
  }
  EXPECT_GE(first, 0.9 * tried);
  EXPECT_GE(among_four, 0.97 * tried);
}

TEST(Relocalise, RanksPosesAndTellsHowClearTheBestIs) {
  const MatchScene& scene = rooms_scene();
  const Relocalisation found = relocalise(scene.scan, scene.key_scans, {});
  ASSERT_GE(found.poses.size(), 2U);
  EXPECT_LE(found.poses.size(), 8U);
  EXPECT_EQ(rank_of(scene.map_from_base, found), 0U);
  for (std::size_t i = 1; i < found.poses.size(); ++i) {
    EXPECT_GE(found.poses[i - 1].score, found.poses[i].score);
  }
  EXPECT_DOUBLE_EQ(found.ratio, found.poses[0].score / found.poses[1].score);
  EXPECT_GT(found.ratio, 1.2);
  EXPECT_EQ(relocalise(
                scene.scan, scene.key_scans, {}, [] { return false; }, 1)
                .poses.size(),
            1U);
}

TEST(Relocalise, FindsAFewPosesByAShareOfThePoints) {
  Random random(2);
  int tried = 0;
  int found = 0;
  for (std::uint64_t seed = 20; seed < 25; ++seed) {
    const World world = make_rooms_world(seed);
    const RobotMotion motion = drive(world.route(), {});
    for (std::uint64_t i = 0; i < 20; ++i, ++tried) {
      const double time = random.uniform(3.0, 100.0);
      const Pose2 truth = pose_around(motion, time, random);
      const PlacedScan key =
          placed(look_around(world, {}, motion.pose(time), i), motion.pose(time));
      const SearchedScan scan(look_around(world, {}, truth, i + 100), 0.03);
      const std::vector<RankedPose> poses = search_anywhere(scan, key, {}, 3).poses;
      EXPECT_LE(poses.size(), 3U);
      found += std::any_of(poses.begin(), poses.end(),
                           [&](const RankedPose& pose) {
                             const Eigen::Vector3d error = shift_between(truth, pose.map_from_base);
                             return error.head<2>().norm() < 0.2 && std::abs(error.z()) < 0.05;
                           })
                   ? 1
                   : 0;
    }
  }
  EXPECT_GE(found, 0.9 * tried);
}

TEST(Relocalise, SearchesAmongKeyScansThatSeeTheSameOnlyTheNewest) {
  const MatchScene& scene = rooms_scene();
  PlacedScans many;
  for (int i = 0; i < 40; ++i) {  // two laps of 10 m with 0.5 m between scans
    many.push_back(scene.key_scans.front());
    many.back().map_from_base = {0.5 * (i % 20), 0.01 * i, 0.0};
  }
  const PlacedScans chosen = spread_out(many);
  ASSERT_EQ(chosen.size(), 10U);
  EXPECT_EQ(chosen.front().map_from_base, many.back().map_from_base);
  for (const PlacedScan& one : many) {
    EXPECT_TRUE(std::any_of(chosen.begin(), chosen.end(), [&](const PlacedScan& other) {
      return (one.map_from_base.translation() - other.map_from_base.translation()).norm() < 1.0;
    }));
  }
  many.back().map_from_base.theta = 1.0;
  EXPECT_EQ(spread_out(many).size(), 11U) << "turned, it sees something else";
}

TEST(Relocalise, EndsWhenItIsInterrupted) {
  const MatchScene& scene = rooms_scene();
  PlacedScans far_apart = scene.key_scans;
  for (std::size_t i = 0; i < far_apart.size(); ++i) {
    far_apart[i].map_from_base.x += 10.0 * static_cast<double>(i);
  }
  int asked = 0;
  const Relocalisation found = relocalise(scene.scan, far_apart, {}, [&] { return ++asked == 3; });
  EXPECT_EQ(asked, 3);
  EXPECT_TRUE(found.interrupted);
  EXPECT_TRUE(found.poses.empty());
  EXPECT_FALSE(relocalise(scene.scan, scene.key_scans, {}).interrupted);
}

TEST(Relocalise, FindsNothingInNothing) {
  const MatchScene& scene = rooms_scene();
  EXPECT_TRUE(relocalise(scene.scan, {}, {}).poses.empty());
  EXPECT_TRUE(relocalise({}, scene.key_scans, {}).poses.empty());
  EXPECT_EQ(relocalise({}, scene.key_scans, {}).ratio, 0.0);
}

}  // namespace
}  // namespace matchbox_slam
