#include <gtest/gtest.h>

#include "common/error_text.hpp"
#include "matchbox_slam/matching/odometry_only_matcher.hpp"
#include "matching/match_scene.hpp"

namespace matchbox_slam {
namespace {

TEST(OdometryOnly, AcceptsThePredictionAsItIs) {
  MatchScene scene;
  ScanPoint point;
  point.position = {1.0, 0.0};
  point.origin = {0.0, 0.0};
  scene.scan.points.push_back(point);
  const Pose2 predicted{1.0, -2.0, 3.0};
  const MatchResult result =
      OdometryOnlyMatcher().match(scene.problem(predicted, prior_of(0.3, 0.2)));
  EXPECT_TRUE(result.accepted());
  EXPECT_EQ(result.map_from_base, predicted);
  EXPECT_EQ(result.covariance, prior_of(0.3, 0.2));
  EXPECT_EQ(result.candidates, 1U);
  EXPECT_TRUE(result.unconstrained_directions.empty());
}

TEST(OdometryOnly, HasNoOptions) {
  OdometryOnlyMatcher matcher;
  EXPECT_TRUE(matcher.options().empty());
  EXPECT_NO_THROW(matcher.configure({}));
  Parameters parameters;
  parameters.set("max_tries", 3);
  const std::string text = error_text<ConfigurationError>([&] { matcher.configure(parameters); });
  EXPECT_TRUE(contains(text, "odometry_only")) << text;
  EXPECT_TRUE(contains(text, "max_tries")) << text;
}

}  // namespace
}  // namespace matchbox_slam
