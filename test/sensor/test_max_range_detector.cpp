#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "sensor/max_range_detector.hpp"
#include "simulation/make_world.hpp"

namespace matchbox_slam {
namespace {

constexpr double kMaximum = 10.0;  // m

/// A laser of 360 beams all around.
class Drive {
 public:
  /// @param far  what is read of what is farther than range_max.
  /// @param range_max  that the messages tell.
  /// @param pillars    stand around the robot, with 20 degrees between them.
  template <typename Far>
  explicit Drive(double length, double width, double speed, Far&& far, double range_max = kMaximum,
                 bool pillars = false) {
    Random random(1);
    for (int i = 0; i < 60; ++i) {
      LaserScan scan;
      scan.stamp = 0.1 * i;
      scan.range_max = range_max;
      const double heading = speed * 0.05 * i;
      for (int k = 0; k < 360; ++k) {
        const double angle = heading + 2.0 * kPi * k / 360.0;
        const double x = 0.3 * length + speed * i;
        const double ahead = std::cos(angle) > 0.0 ? length - x : x;
        const double range =
            std::min(ahead / std::abs(std::cos(angle)), 0.5 * width / std::abs(std::sin(angle)));
        const bool is_behind_pillar = pillars && k % 40 < 20;
        scan.ranges.push_back(static_cast<float>(is_behind_pillar ? 3.0 + speed * i
                                                 : range > kMaximum
                                                     ? far(random)
                                                     : range + 0.01 * random.gaussian()));
      }
      detector_.add(scan);
    }
  }

  [[nodiscard]] std::optional<double> first_range() const { return detector_.first_range(); }

 private:
  MaxRangeDetector detector_;
};

TEST(MaxRangeDetector, IsFoundAboutTheLargestRange) {
  for (const double noise : {0.005, 0.02, 0.04}) {
    for (const double speed : {0.0, 0.1}) {
      const Drive drive(100.0, 30.0, speed,
                        [&](Random& random) { return kMaximum + noise * random.gaussian(); });
      ASSERT_TRUE(drive.first_range()) << noise;
      EXPECT_NEAR(*drive.first_range(), kMaximum - 5.0 * noise, 1.5 * noise) << speed;
    }
  }
}

TEST(MaxRangeDetector, MayLieABitOff) {
  const Drive drive(100.0, 30.0, 0.1,
                    [](Random& random) { return kMaximum - 0.05 + 0.01 * random.gaussian(); });
  ASSERT_TRUE(drive.first_range());
  EXPECT_NEAR(*drive.first_range(), kMaximum - 0.1, 0.02);
}

/// One in twenty lies a centimetre lower.
TEST(MaxRangeDetector, IsCutWholeWhereRangesAreRounded) {
  const auto far = [](Random& random) { return random.uniform() < 0.05 ? 9.99 : 10.0; };
  const Drive drive(20.0, 30.0, 0.1, far, 8.0 * kMaximum, true);
  ASSERT_TRUE(drive.first_range());
  EXPECT_LT(*drive.first_range(), 9.99);
  EXPECT_GT(*drive.first_range(), 9.97);
}

TEST(MaxRangeDetector, MayLieFarBelowWhatMessagesTell) {
  const auto far = [](Random& random) { return kMaximum + 0.01 * random.gaussian(); };
  const Drive drive(20.0, 30.0, 0.1, far, 8.0 * kMaximum, true);
  ASSERT_TRUE(drive.first_range());
  EXPECT_NEAR(*drive.first_range(), kMaximum - 0.05, 0.02);
  EXPECT_FALSE(Drive(20.0, 30.0, 0.0, far, 8.0 * kMaximum, true).first_range()) << "at rest";
  EXPECT_FALSE(Drive(20.0, 30.0, 0.1, far, 8.0 * kMaximum).first_range()) << "two arcs";
}

/// Five of 120 beams meet nothing, in other directions each time; one reads the same all the time.
TEST(MaxRangeDetector, IsFoundBesideABeamThatIsStuck) {
  for (const int stuck : {0, 1, 3}) {
    MaxRangeDetector detector;
    Random random(1);
    for (int i = 0; i < 60; ++i) {
      LaserScan scan;
      scan.stamp = 0.1 * i;
      scan.range_max = kMaximum;
      for (int k = 0; k < 120; ++k) {
        const bool is_far = k % 24 == i % 24;
        scan.ranges.push_back(static_cast<float>(k < stuck ? kMaximum - 0.9
                                                 : is_far  ? kMaximum + 0.01 * random.gaussian()
                                                           : random.uniform(1.0, 5.0)));
      }
      detector.add(scan);
    }
    EXPECT_EQ(detector.first_range().has_value(), stuck < 2) << stuck;
  }
}

/// By stamps and their number, so that who reads faster or later finds the same.
TEST(MaxRangeDetector, IsNotLookedForWithoutEnd) {
  const auto scans_until_complete = [](double period) {
    MaxRangeDetector detector;
    int scans = 0;
    for (; !detector.is_complete() && scans < 1000; ++scans) {
      LaserScan scan;
      scan.stamp = 100.0 + period * scans;
      scan.range_max = kMaximum;
      scan.ranges.assign(120, 3.0F);
      detector.add(scan);
    }
    return scans;
  };
  EXPECT_EQ(scans_until_complete(0.025), 402) << "ten seconds";
  EXPECT_EQ(scans_until_complete(0.2), 100) << "a hundred scans";
  EXPECT_EQ(scans_until_complete(2.0), 62) << "two minutes";
}

/// What is there: nothing, as all walls are within reach.
TEST(MaxRangeDetector, IsNotSeenByWhoTurnsInARoom) {
  std::size_t turns = 0;
  for (const char* name : {"loop", "rooms", "corridor", "hotel", "atrium"}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const World world = make_world(name, seed);
      Random random(seed);
      const auto& places = world.route().waypoints;
      const Eigen::Vector2d at =
          places[static_cast<std::size_t>(random.uniform() * static_cast<double>(places.size()))];
      for (const double field : {120.0, 180.0, 270.0, 360.0}) {
        MaxRangeDetector detector;
        for (int i = 0; i < 60; ++i) {
          LaserScan scan;
          scan.stamp = 0.1 * i;
          scan.range_max = 80.0;
          for (int k = 0; k < 90; ++k) {
            const double angle = degrees_to_radians(6.0 * i + field * ((k + 0.5) / 90.0 - 0.5));
            const auto hit = world.cast_ray(at, {std::cos(angle), std::sin(angle)}, 80.0, {},
                                            {scan.stamp, static_cast<std::uint64_t>(k)});
            scan.ranges.push_back(hit ? static_cast<float>(hit->range + 0.01 * random.gaussian())
                                      : 80.0F);
          }
          detector.add(scan);
        }
        EXPECT_FALSE(detector.first_range()) << name << " " << seed << ", " << field << " degrees";
        ++turns;
      }
    }
  }
  EXPECT_EQ(turns, 400U);
}

/// A robot that turns on the spot sees the end of a corridor in all directions, one by one.
TEST(MaxRangeDetector, IsNotTheEndOfACorridor) {
  MaxRangeDetector detector;
  for (int i = 0; i < 60; ++i) {
    LaserScan scan;
    scan.range_max = 80.0;
    for (int k = 0; k < 120; ++k) {
      const double angle = degrees_to_radians(k + 0.5 + 6.0 * i);
      const double ahead = (std::cos(angle) > 0.0 ? 20.0 : 12.0) / std::abs(std::cos(angle));
      scan.ranges.push_back(static_cast<float>(std::min(ahead, 1.0 / std::abs(std::sin(angle)))));
    }
    detector.add(scan);
  }
  EXPECT_FALSE(detector.first_range());
}

TEST(MaxRangeDetector, IsNotSeenInWallsOrInWhatIsNoReturnAnyway) {
  const auto infinite = [](Random& /*random*/) { return std::numeric_limits<double>::infinity(); };
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
