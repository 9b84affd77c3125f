#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/angles.hpp"
#include "sensor/robot_beams.hpp"

namespace matchbox_slam {
namespace {

constexpr int kBeamCount = 360;

double angle_of(int beam) { return -kPi + 2.0 * kPi * beam / kBeamCount; }

/// The range in a corridor along x that is open at both ends.
double range_in_corridor(const Pose2& pose, double angle, double width) {
  const double across = std::sin(wrap_angle(pose.theta + angle));
  const double wall = across > 0.0 ? 0.5 * width - pose.y : 0.5 * width + pose.y;
  return std::min(20.0, wall / std::max(1e-6, std::abs(across)));
}

struct CorridorDrive {
  double width = 3.0;   ///< [m] of the corridor
  bool turns = true;    ///< also all around; else it looks straight on
  double noise = 0.01;  ///< [m]
  /// Of a beam and its range by the walls.
  std::function<double(int, double)> read = [](int /*beam*/, double range) { return range; };
  ProjectionOptions options;
  bool is_clockwise = false;

  [[nodiscard]] std::vector<double> sectors() const {
    Random random(1);
    RobotBeams beams;
    for (int i = 0; i < 400; ++i) {
      const Pose2 pose{0.1 * i, 0.2 * std::sin(0.1 * i), turns ? wrap_angle(0.12 * i) : 0.0};
      LaserScan scan;
      scan.angle_min = is_clockwise ? angle_of(kBeamCount - 1) : angle_of(0);
      scan.angle_increment = (is_clockwise ? -2.0 : 2.0) * kPi / kBeamCount;
      scan.range_min = 0.05;
      scan.range_max = 30.0;
      for (int k = 0; k < kBeamCount; ++k) {
        const int beam = is_clockwise ? kBeamCount - 1 - k : k;
        const double range = read(beam, range_in_corridor(pose, angle_of(beam), width));
        scan.ranges.push_back(static_cast<float>(range + noise * random.gaussian()));
      }
      beams.add(scan, pose, options);
    }
    return beams.sectors();
  }
};

/// A mast behind, and a thin rod to the left.
double with_mast(int beam, double range) { return beam < 10 ? 0.4 : beam == 270 ? 0.7 : range; }

TEST(RobotBeams, AreFoundWithTheSectorsToMask) {
  for (const bool is_clockwise : {false, true}) {
    CorridorDrive drive;
    drive.read = with_mast;
    drive.is_clockwise = is_clockwise;
    std::vector<double> sectors = drive.sectors();
    ASSERT_EQ(sectors.size(), 4U);
    const std::size_t mast = is_clockwise ? 2 : 0;
    const double step = 2.0 * kPi / kBeamCount;
    EXPECT_NEAR(sectors[mast], angle_of(0) - 1.5 * step, 1e-9);
    EXPECT_NEAR(sectors[mast + 1], angle_of(9) + 1.5 * step, 1e-9);
    EXPECT_NEAR(sectors[2 - mast], angle_of(270) - 1.5 * step, 1e-9);
    EXPECT_NEAR(sectors[3 - mast], angle_of(270) + 1.5 * step, 1e-9);
  }
}

TEST(RobotBeams, OfTheNoiseAndTheLostReadingsOfCheapLasers) {
  Random random(2);
  CorridorDrive drive;
  drive.noise = 0.015;
  drive.read = [&](int beam, double range) {
    return random.uniform() < 0.2 ? NAN : with_mast(beam, range);
  };
  EXPECT_EQ(drive.sectors().size(), 4U);
}

TEST(RobotBeams, AreNoneWhereTheRangeChangesOrIsFar) {
  for (const double width : {1.0, 2.0, 3.0}) {
    CorridorDrive drive;
    drive.width = width;
    EXPECT_TRUE(drive.sectors().empty()) << width;
  }
  CorridorDrive drive;
  drive.read = [](int beam, double range) { return beam < 10 ? 1.7 : range; };
  EXPECT_TRUE(drive.sectors().empty()) << "no robot is as long";
  drive.read = [](int beam, double range) { return beam < 10 ? INFINITY : range; };
  EXPECT_TRUE(drive.sectors().empty());
}

TEST(RobotBeams, AWallThatIsFollowedIsNoRobot) {
  CorridorDrive drive;
  drive.width = 1.0;
  drive.turns = false;
  drive.read = with_mast;
  EXPECT_TRUE(drive.sectors().empty()) << "it has not looked around";
}

TEST(RobotBeams, ThatAreLeftOutAlreadyAreNotTold) {
  CorridorDrive drive;
  drive.read = with_mast;
  drive.options.masked_angles = {angle_of(270) - 0.1, angle_of(270) + 0.1};
  EXPECT_EQ(drive.sectors().size(), 2U);
  drive.options.min_range = 0.5;
  EXPECT_TRUE(drive.sectors().empty());
}

}  // namespace
}  // namespace matchbox_slam
