#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

#include "matchbox_slam/matching/scan_matcher.hpp"
#include "matching/match_scene.hpp"

namespace matchbox_slam {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool is_valid(const Pose2& predicted, const Eigen::Matrix3d& covariance) {
  const MatchScene scene;
  return is_valid_prior(scene.problem(predicted, covariance));
}

TEST(MatchStatus, HasAWordForEach) {
  EXPECT_STREQ(to_string(MatchStatus::kAccepted), "accepted");
  std::set<std::string> words;
  for (const MatchStatus status :
       {MatchStatus::kRejectedNoReference, MatchStatus::kRejectedTooFewPoints,
        MatchStatus::kRejectedLowScore, MatchStatus::kRejectedUnexpected,
        MatchStatus::kRejectedInvalidPrior}) {
    const std::string word = to_string(status);
    EXPECT_EQ(word.rfind("rejected_", 0), 0U) << word;
    EXPECT_TRUE(words.insert(word).second) << word;
  }
}

TEST(IsValidPrior, TakesEveryCovariance) {
  EXPECT_TRUE(is_valid({}, prior_of(0.1, 0.1)));
  EXPECT_TRUE(is_valid({1e6, -1e6, 3.0}, prior_of(1e3, 1e3)));
  EXPECT_TRUE(is_valid({}, Eigen::Matrix3d::Zero()));
  const Eigen::Vector3d along(1.0, 2.0, -0.5);
  EXPECT_TRUE(is_valid({}, along * along.transpose())) << "of rank one";
  EXPECT_TRUE(is_valid({}, 1e-30 * along * along.transpose()));
}

TEST(IsValidPrior, RefusesWhatIsNone) {
  EXPECT_FALSE(is_valid({kNan, 0.0, 0.0}, prior_of(0.1, 0.1)));
  EXPECT_FALSE(is_valid({0.0, 0.0, kNan}, prior_of(0.1, 0.1)));
  EXPECT_FALSE(is_valid({}, Eigen::Matrix3d::Constant(kNan)));
  EXPECT_FALSE(is_valid({}, Eigen::Matrix3d(-prior_of(0.1, 0.1))));
  Eigen::Matrix3d asymmetric = Eigen::Matrix3d::Identity();
  asymmetric(0, 2) = 0.1;
  EXPECT_FALSE(is_valid({}, asymmetric));
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Identity();
  indefinite(0, 1) = 1.1;
  indefinite(1, 0) = 1.1;
  EXPECT_FALSE(is_valid({}, indefinite));
}

TEST(Rejected, IsThePriorAndTheReason) {
  const MatchScene scene;
  const Pose2 predicted{1.0, 2.0, 0.3};
  const MatchResult result =
      rejected(scene.problem(predicted, prior_of(0.2, 0.1)), MatchStatus::kRejectedLowScore);
  EXPECT_EQ(result.map_from_base, predicted);
  EXPECT_EQ(result.covariance, prior_of(0.2, 0.1));
  EXPECT_EQ(result.status, MatchStatus::kRejectedLowScore);
  EXPECT_FALSE(result.accepted());
  EXPECT_EQ(result.score, 0.0);
}

TEST(RejectUnmatchable, GoesOnOnlyWithAPriorPointsAndAMap) {
  const auto status = [](const MatchScene& scene, const Pose2& predicted) {
    const auto rejection = reject_unmatchable(scene.problem(predicted, prior_of(0.1, 0.1)));
    return rejection ? rejection->status : MatchStatus::kAccepted;
  };
  MatchScene scene;
  EXPECT_EQ(status(scene, {kNan, 0.0, 0.0}), MatchStatus::kRejectedInvalidPrior);
  EXPECT_EQ(status(scene, {}), MatchStatus::kRejectedTooFewPoints);
  scene.scan.points.resize(1);
  EXPECT_EQ(status(scene, {}), MatchStatus::kRejectedNoReference);
  scene.map.field.update({{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()}}, {});
  EXPECT_EQ(status(scene, {}), MatchStatus::kAccepted);
}

TEST(OptimalityProof, GapIsWhatTheBoundLeavesOpen) {
  OptimalityProof proof;
  proof.best_score = 0.8;
  proof.remaining_bound = 0.5;
  EXPECT_EQ(proof.gap(), 0.0);
  EXPECT_TRUE(proof.is_proven());
  proof.remaining_bound = 1.1;
  EXPECT_DOUBLE_EQ(proof.gap(), 0.3);
  EXPECT_FALSE(proof.is_proven());
}

}  // namespace
}  // namespace matchbox_slam
