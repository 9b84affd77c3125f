#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "slam/key_scans_of_rooms.hpp"
#include "slam/pose_uncertainty.hpp"

namespace matchbox_slam {
namespace {

TEST(BesideDrawn, IsNeverMoreThanWhatWasDrawnNorThanThePose) {
  const Eigen::Matrix3d sure = covariance_of(0.001, 0.001);
  EXPECT_TRUE(beside_drawn(sure).isApprox(sure, 1e-3));
  Eigen::Matrix3d unsure = covariance_of(100.0, 3.0);
  unsure(0, 1) = unsure(1, 0) = 3333.3;
  unsure(0, 2) = unsure(2, 0) = -77.7;
  const Eigen::Matrix3d beside = beside_drawn(unsure);
  EXPECT_NEAR(std::sqrt(beside(0, 0)), 0.15, 1e-3);
  EXPECT_NEAR(std::sqrt(beside(2, 2)), 0.05, 1e-3);
  EXPECT_TRUE(beside.isApprox(beside.transpose(), 0.0));
}

class ToldCovarianceTest : public testing::Test {
 protected:
  ToldCovarianceTest()
      : components_({{SlamMap(MapOptions{}, LikelihoodFieldOptions{}), {}, {}, 0.0}}) {
    for (const PlacedScan& key : drive_through_rooms(2)) {
      components_.map().key_scans.add(key);
      insert_scan(*key.scan->points(), key.map_from_base, MapOptions{}, components_.map().map);
    }
    const Pose2& first = components_.map().key_scans.all().front().map_from_base;
    outcome_.map_from_base = {first.x + 100.0, first.y, first.theta};
    outcome_.match.status = MatchStatus::kAccepted;
    outcome_.match.covariance = covariance_of(0.01, 0.001);
    outcome_.covariance = outcome_.match.covariance;
  }

  MapComponents components_;
  ScanOutcome outcome_;
};

TEST_F(ToldCovarianceTest, WhileMappingHoldsThatOfTheMapTwiceOverAndItsBend) {
  const Eigen::Matrix3d told = reported_covariance(outcome_, components_, true);
  // 100 m away a heading that is known to 0.1 mrad is 1 cm.
  EXPECT_TRUE(told.isApprox(2.0 * outcome_.match.covariance + covariance_of(0.01, 1e-4), 1e-9));
}

TEST_F(ToldCovarianceTest, InAMapThatStaysIsTheMatchs) {
  EXPECT_EQ(reported_covariance(outcome_, components_, false), outcome_.covariance);
  outcome_.match.status = MatchStatus::kRejectedLowScore;
  EXPECT_EQ(reported_covariance(outcome_, components_, true), outcome_.covariance);
}

TEST_F(ToldCovarianceTest, OfALostRobotCoversTheMap) {
  static_cast<void>(
      components_.begin_component({SlamMap(MapOptions{}, LikelihoodFieldOptions{}), {}, {}, 1.0}));
  const Eigen::Matrix3d told = reported_covariance(outcome_, components_, true);
  const CellBox box = components_.map().map.occupancy.known_bounds();
  EXPECT_GE(std::sqrt(told(0, 0)), 0.05 * std::max(box.width(), box.height()));
  EXPECT_GE(std::sqrt(told(2, 2)), 3.14);
}

}  // namespace
}  // namespace matchbox_slam
