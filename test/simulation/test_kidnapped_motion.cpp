#include <gtest/gtest.h>

#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/common/options.hpp"
#include "simulation/kidnapped_motion.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

class Kidnapped : public testing::Test {
 protected:
  RobotMotion motion_ = drive(make_rooms_world(1).route(), DriveOptions{});
};

TEST_F(Kidnapped, WithoutKidnappingTheDriveIsAsItWas) {
  const KidnappedMotion same(motion_, {parse_fault("freeze:10")}, 1);
  for (double time = -1.0; time < 100.0; time += 0.7) {
    EXPECT_EQ(same.pose(time), motion_.pose(time));
    EXPECT_EQ(same.pose_on_wheels(time), motion_.pose(time));
  }
}

TEST_F(Kidnapped, TheRobotIsCarriedFarEnoughAndGoesOnAlongItsWay) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const KidnappedMotion carried(motion_, {parse_fault("kidnap:40:3:4")}, seed);
    EXPECT_EQ(carried.pose(39.9), motion_.pose(39.9));
    const Pose2 taken = carried.pose(40.0);
    const Pose2 put_down = carried.pose(43.0);
    EXPECT_GE((taken.translation() - put_down.translation()).norm(), 4.0);
    // Straight from the one place to the other.
    const Pose2 between = carried.pose(41.5);
    EXPECT_LT((between.translation() - 0.5 * (taken.translation() + put_down.translation())).norm(),
              1e-9);
    // Afterwards it drives as it would from there.
    const Pose2 moved = put_down.inverse() * carried.pose(45.0);
    EXPECT_LT(moved.translation().norm(), 2.0 * DriveOptions{}.speed + 1e-9);
  }
}

TEST_F(Kidnapped, WheelsFeelNothingOfIt) {
  const KidnappedMotion carried(motion_, {parse_fault("kidnap:40:3"), parse_fault("kidnap:60:2")},
                                7);
  for (double time = 0.0; time < 120.0; time += 0.05) {
    const Pose2 felt = carried.pose_on_wheels(time).inverse() * carried.pose_on_wheels(time + 0.05);
    const bool is_carried =
        (time >= 40.0 && time + 0.05 <= 43.0) || (time >= 60.0 && time + 0.05 <= 62.0);
    EXPECT_LE(felt.translation().norm(), is_carried ? 1e-9 : 0.05 * DriveOptions{}.speed + 1e-9)
        << time;
    if (time > 43.1 && time + 0.05 < 59.9) {
      const Pose2 moved = carried.pose(time).inverse() * carried.pose(time + 0.05);
      EXPECT_LT((felt.translation() - moved.translation()).norm(), 1e-9);
    }
  }
}

TEST_F(Kidnapped, WhoIsTakenWhileBeingCarriedIsCarriedOn) {
  const KidnappedMotion carried(
      motion_, {parse_fault("kidnap:40:3"), parse_fault("kidnap:41:3"), parse_fault("kidnap:42:3")},
      7);
  for (const double begin : {40.0, 43.0, 46.0}) {
    const Pose2 taken = carried.pose(begin);
    EXPECT_LT((taken.translation() - carried.pose(begin - 1e-6).translation()).norm(), 1e-3);
    EXPECT_GE((taken.translation() - carried.pose(begin + 3.0).translation()).norm(), 3.0) << begin;
    EXPECT_LT(difference(carried.pose_on_wheels(begin), carried.pose_on_wheels(40.0)).norm(), 1e-9);
  }
}

TEST_F(Kidnapped, APlaceThatIsTooFarIsRefused) {
  EXPECT_TRUE(contains(error_text<ConfigurationError>([&] {
                         (void)KidnappedMotion(motion_, {parse_fault("kidnap:40:3:500")}, 1);
                       }),
                       "no place"));
}

}  // namespace
}  // namespace matchbox_slam
