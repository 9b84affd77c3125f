// Of tools/bag_mapper.hpp: robots and lasers that tilt, over a floor.

#include <gtest/gtest.h>
#include <sensor_msgs/Imu.h>

#include <algorithm>

#include "common/error_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "ros/messages.hpp"
#include "ros/scan_types.hpp"
#include "simulation/make_world.hpp"
#include "tools/map_bag_run.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

/// A robot or laser that tilts, over a floor, among tables lower than the laser.
class TiltedLaser : public MapBag {
 protected:
  void simulate(const std::string& tilt) {
    simulate_drive("--world rooms --seed 1 --duration 30 --beams 520 " + tilt);
  }

  void simulate_drive(const std::string& drive) {
    const Outcome simulated =
        run_command(MATCHBOX_SIMULATE,
                    drive + " --floor --table-height 0.2 --bag " + bag_ + " --truth " + truth_);
    ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  }

  /// Of the trajectory [m].
  [[nodiscard]] double error() const {
    return absolute_trajectory_error(read_tum(out_ + "/trajectory.tum"), read_tum(truth_))
        .translation.rmse;
  }

  /// Occupied cells of the map that are farther than 0.6 m from all walls and things:
  /// half a door, which a level laser draws shut from far away, too.
  [[nodiscard]] std::size_t cells_on_the_floor() const {
    const World world = make_world("rooms", 1);
    const MapImage map = read_map(out_ + "/map.yaml");
    const Pose2 world_from_map = read_tum(truth_).poses().front().pose;
    std::size_t count = 0;
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        const Eigen::Vector2d middle =
            world_from_map *
            (map.origin * Eigen::Vector2d((x + 0.5) * map.resolution, (y + 0.5) * map.resolution));
        const bool is_far =
            std::all_of(world.segments().begin(), world.segments().end(),
                        [&](const WallSegment& line) { return distance(line, middle) > 0.6; });
        count += map.state({x, y}) == CellState::kOccupied && is_far ? 1 : 0;
      }
    }
    return count;
  }

  std::string truth_ = folder_ / "truth.tum";
};

TEST_F(TiltedLaser, ARobotThatRocksGetsAMapWithoutFloor) {
  simulate("--rock 0.0873");
  ASSERT_EQ(run("").exit_code, 0);
  EXPECT_LT(error(), 0.01);
  EXPECT_EQ(cells_on_the_floor(), 0U);
  EXPECT_EQ(report("scans/used"), report("scans/received"));
}

TEST_F(TiltedLaser, ARobotThatRocksAsOnlyItsImuTellsGetsAMapWithoutFloor) {
  simulate("--rock 0.0873 --imu");
  ASSERT_EQ(run("").exit_code, 0);
  EXPECT_GT(cells_on_the_floor(), 0U) << "it cannot know";  // 6
  ASSERT_EQ(run("--set imu_topic=imu").exit_code, 0);
  EXPECT_LT(error(), 0.01);
  EXPECT_EQ(cells_on_the_floor(), 0U);
  EXPECT_EQ(report("scans/used"), report("scans/received"));
}

TEST_F(TiltedLaser, AnImuThatMeasuresNoOrientationIsTold) {
  write_small_bag(bag_);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    sensor_msgs::Imu imu;
    imu.header.stamp = ros::Time(1000.0);
    imu.header.frame_id = "imu_link";
    imu.orientation_covariance[0] = -1.0;
    bag.write("/imu", ros::Time(1000.0), imu);
    bag.write("/imu", ros::Time(1001.0), imu);
  }
  expect_one_line(run("--quiet --set imu_topic=gyro"), 2,
                  "the bag has no topic 'gyro'; topics with orientations of an IMU: /imu");
  const Outcome outcome = run("--quiet --set imu_topic=/imu");
  EXPECT_EQ(outcome.exit_code, 1);
  for (const char* words :
       {"messages of the IMU are ignored; the first: orientation_covariance[0] is -1, which says "
        "that it measures no orientation\n",
        "skipped (no_transform): no orientation by the IMU at 1000.000: no usable message of the "
        "IMU has come yet; leave out imu_topic to map without\n"}) {
    EXPECT_TRUE(contains(outcome.output, words)) << outcome.output;
  }
}

TEST_F(TiltedLaser, ALaserThatNodsGetsAMapOfItsLevelScans) {
  simulate("--nod 0.5 --time-increment 4e-5");
  const Outcome outcome = run("");
  ASSERT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.output, "skipped (tilted): its plane is tilted by "))
      << outcome.output;
  EXPECT_LT(error(), 0.01);  // 0.026 with scans on the backs of walls
  EXPECT_EQ(cells_on_the_floor(), 0U);
  EXPECT_GT(report("scans/used"), 0.15 * report("scans/received"));
  EXPECT_EQ(report("scans/used") + report("scans/skipped/tilted"), report("scans/received"));
}

/// Between two level scans it drives 0.7 m; the first ones after see little of the way along.
TEST_F(TiltedLaser, ALaserThatNodsKeepsItsPlaceAlongACorridor) {
  simulate_drive("--world campus --seed 1 --nod 0.3 --scan-rate 20 --duration 160");
  ASSERT_EQ(run("").exit_code, 0);
  EXPECT_LT(error(), 0.02);  // 7.4 m at its end where a refinement may run off along the corridor
}

/// A crossing is alike after a quarter of a turn, and new when it comes after such a gap.
TEST_F(TiltedLaser, ALaserThatNodsGoesStraightOnThroughACrossing) {
  simulate_drive("--world campus --seed 2 --nod 0.3 --scan-rate 20 --duration 1846");
  ASSERT_EQ(run("--start 1780").exit_code, 0);
  EXPECT_LT(error(), 0.016);  // 0.011; 2.17 where a second look may turn it there
}

/// One sees a room's wall from the corridor, and 0.2 m behind it from the next room.
TEST_F(TiltedLaser, ALaserThatNodsTakesNoWallForItsOtherSide) {
  ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                        "--world campus --seed 2 --duration 36 --floor --nod 0.3 --bag " + bag_ +
                            " --truth " + truth_)
                .exit_code,
            0);
  ASSERT_EQ(run("").exit_code, 0);
  EXPECT_LT(error(), 0.009);  // 0.006; 0.067 where the other side of a wall is taken for it
}

TEST_F(TiltedLaser, OneThatIsNeverLevelGetsAClearWord) {
  simulate("--mount-pitch 0.3");
  const Outcome outcome = run("--quiet");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(
      contains(outcome.output,
               "none of 601 scans could be used; the first: scan of 1327500000.000 s skipped "
               "(tilted): its plane is tilted by 0.300 rad; scan/max_tilt allows 0.150"))
      << outcome.output;
}

}  // namespace
}  // namespace matchbox_slam
