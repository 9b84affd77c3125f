#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "sensor/no_return_pile.hpp"

namespace matchbox_slam {
namespace {

constexpr double kMaximum = 10.0;  // m
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A laser of 360 beams all around.
class Drive {
 public:
  /// @param far  what is read of what is farther than range_max.
  /// @param range_max  that the messages tell.
  template <typename Far>
  explicit Drive(double length, double width, double speed, Far&& far,
                 double range_max = kMaximum) {
    Random random(1);
    for (int i = 0; i < 60; ++i) {
      LaserScan scan;
      scan.range_max = range_max;
      const double heading = speed * 0.05 * i;
      for (int k = 0; k < 360; ++k) {
        const double angle = heading + 2.0 * kPi * k / 360.0;
        const double x = 0.3 * length + speed * i;
        const double ahead = std::cos(angle) > 0.0 ? length - x : x;
        const double range =
            std::min(ahead / std::abs(std::cos(angle)), 0.5 * width / std::abs(std::sin(angle)));
        scan.ranges.push_back(
            static_cast<float>(range > kMaximum ? far(random) : range + 0.01 * random.gaussian()));
      }
      pile_.add(scan);
    }
  }

  [[nodiscard]] std::optional<double> first_range() const { return pile_.first_range(); }

 private:
  NoReturnPile pile_;
};

TEST(NoReturnPile, IsFoundAboutTheLargestRange) {
  for (const double noise : {0.005, 0.02, 0.04}) {
    for (const double speed : {0.0, 0.1}) {
      const Drive drive(100.0, 30.0, speed,
                        [&](Random& random) { return kMaximum + noise * random.gaussian(); });
      ASSERT_TRUE(drive.first_range()) << noise;
      EXPECT_NEAR(*drive.first_range(), kMaximum - 5.0 * noise, 1.5 * noise) << speed;
    }
  }
}

TEST(NoReturnPile, MayLieABitOff) {
  const Drive drive(100.0, 30.0, 0.1,
                    [](Random& random) { return kMaximum - 0.05 + 0.01 * random.gaussian(); });
  ASSERT_TRUE(drive.first_range());
  EXPECT_NEAR(*drive.first_range(), kMaximum - 0.1, 0.02);
}

TEST(NoReturnPile, MayLieFarBelowWhatMessagesTell) {
  const auto far = [](Random& random) { return kMaximum + 0.01 * random.gaussian(); };
  const Drive drive(20.0, 30.0, 0.1, far, 8.0 * kMaximum);
  ASSERT_TRUE(drive.first_range());
  EXPECT_NEAR(*drive.first_range(), kMaximum - 0.05, 0.02);
  EXPECT_FALSE(Drive(20.0, 30.0, 0.0, far, 8.0 * kMaximum).first_range()) << "at rest";
}

/// A robot that turns on the spot sees the end of a corridor in all directions, one by one.
TEST(NoReturnPile, IsNotTheEndOfACorridor) {
  NoReturnPile pile;
  for (int i = 0; i < 60; ++i) {
    LaserScan scan;
    scan.range_max = 80.0;
    for (int k = 0; k < 120; ++k) {
      const double angle = degrees_to_radians(k + 0.5 + 6.0 * i);
      const double ahead = (std::cos(angle) > 0.0 ? 20.0 : 12.0) / std::abs(std::cos(angle));
      scan.ranges.push_back(static_cast<float>(std::min(ahead, 1.0 / std::abs(std::sin(angle)))));
    }
    pile.add(scan);
  }
  EXPECT_FALSE(pile.first_range());
}

TEST(NoReturnPile, IsNotSeenInWallsOrInWhatIsNoReturnAnyway) {
  const auto infinite = [](Random& /*random*/) { return kInfinity; };
  const auto maximum = [](Random& /*random*/) { return kMaximum; };
  for (const double speed : {0.0, 0.1}) {
    for (const double width : {3.0, 19.0, 19.9, 30.0}) {
      EXPECT_FALSE(Drive(100.0, width, speed, infinite).first_range()) << width;
      EXPECT_FALSE(Drive(100.0, width, speed, maximum).first_range()) << width;
      EXPECT_FALSE(Drive(30.0, width, speed, infinite).first_range()) << width;
    }
  }
}

}  // namespace
}  // namespace matchbox_slam
