#include <gtest/gtest.h>

#include "matchbox_slam/matching/olson/olson_matcher.hpp"
#include "matching/match_scene.hpp"
#include "simulation/make_world.hpp"
#include "slam/common_ground.hpp"

namespace matchbox_slam {
namespace {

TEST(CommonGround, FollowsAScanThatIsKnownWherePredictionsAreWrong) {
  const World world = make_world("rooms", 2);
  LaserOptions laser;
  laser.beams = 360;
  const MatchScene scene = make_match_scene(world, laser, 20.0, 2);
  const OlsonMatcher matcher;
  CommonGroundMatch common;
  for (const Eigen::Vector3d& off :
       {Eigen::Vector3d(0.4, 0.0, 0.0), Eigen::Vector3d(0.0, -0.4, 0.1),
        Eigen::Vector3d(-0.3, 0.3, -0.15)}) {
    const MatchProblem problem =
        scene.problem(shifted(scene.map_from_base, off), prior_of(0.3, 0.1));
    const MatchResult found = common.match(matcher, problem, scene.map);
    EXPECT_LT(shift_between(scene.map_from_base, found.map_from_base).head<2>().norm(), 0.01);
  }
}

}  // namespace
}  // namespace matchbox_slam
