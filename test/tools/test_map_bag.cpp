// Of tools/bag_mapper.hpp: runs map_bag as a user does: every row of the table of bad input that it
// meets, its outputs, and what it says.

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/view.h>
#include <sensor_msgs/Imu.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "bag/simulated_bag.hpp"
#include "common/error_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/common/random.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "ros/messages.hpp"
#include "ros/scan_types.hpp"
#include "run/events_file.hpp"
#include "simulation/make_world.hpp"
#include "tools/bag_mapper.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

class MapBag : public testing::Test {
 protected:
  MapBag() { ::setenv("LC_ALL", "C", 1); }

  /// Runs with the small bag and more arguments.
  Outcome run(const std::string& arguments) {
    return run_command(MATCHBOX_MAP_BAG, bag_ + " --out " + out_ + " " + arguments);
  }

  Outcome run_small(const SmallBag& recipe, const std::string& arguments = "") {
    write_small_bag(bag_, recipe);
    return run(arguments);
  }

  void expect_one_line(const Outcome& outcome, int exit_code, const std::string& words) {
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, words)) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    EXPECT_FALSE(std::filesystem::exists(out_ + "/trajectory.tum"));
  }

  /// A number of the report; `name` is a JSON pointer.
  [[nodiscard]] double report(const std::string& name) const {
    const auto values = nlohmann::json::parse(read_file(out_ + "/report.json"));
    return values.at(nlohmann::json::json_pointer("/" + name)).get<double>();
  }

  [[nodiscard]] std::size_t poses() const { return read_tum(out_ + "/trajectory.tum").size(); }

  TemporaryFolder folder_;
  std::string bag_ = folder_ / "small.bag";
  std::string out_ = folder_ / "out";
};

TEST_F(MapBag, WritesEveryFile) {
  const Outcome outcome = run_small({});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output,
                       "scan topic /scan; scan frame laser; base frame base_link; "
                       "odometry frame odom\n"))
      << outcome.output;
  EXPECT_EQ(poses(), 50U);
  const Trajectory trajectory = read_tum(out_ + "/trajectory.tum");
  const Trajectory odometry = read_tum(out_ + "/odometry.tum");
  ASSERT_EQ(odometry.size(), 50U);
  for (std::size_t k = 0; k < 50; ++k) {
    EXPECT_EQ(odometry.poses()[k].stamp, trajectory.poses()[k].stamp);
  }
  EXPECT_NEAR(odometry.poses()[10].pose.x, 0.02, 1e-6);
  const MapImage map = read_map(out_ + "/map.yaml");
  EXPECT_GT(map.width, 30);
  EXPECT_EQ(read_file(out_ + "/map.png").substr(1, 3), "PNG");
}

TEST_F(MapBag, TellsOfTheLoopsThatItCloses) {
  const Outcome simulated =
      run_command(MATCHBOX_SIMULATE, "--world loop --seed 3 --scan-rate 2.5 --beams 260 --bag " +
                                         bag_ + " --truth " + (folder_ / "truth.tum"));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  MapBagRequest request;
  request.recording.bags = {bag_};
  request.out = out_;
  request.matcher = "odometry_only";
  std::string told;
  std::string progress;
  map_bag(request, {[&](const std::string& line) { told += line + "\n"; },
                    [&](const std::string& line) { told += line + "\n"; },
                    [&](double /*fraction*/, const std::string& text) { progress += text + "\n"; },
                    [] { return false; }});
  ASSERT_EQ(report("loops/closed"), 2.0);
  EXPECT_TRUE(contains(told, ", 2 loops closed, in ")) << told;
  for (const std::string loops : {"0 loops", "1 loop", "2 loops"}) {
    EXPECT_TRUE(contains(progress, " scans, " + loops + " closed\n")) << progress;
  }
  EXPECT_GE(report("loops/tried"), 2.0 + report("loops/refused"));
  EXPECT_GT(report("loops/each/0/stamp"), report("loops/each/0/stamp_there") + 60.0);
  EXPECT_GT(report("loops/each/0/score"), 0.55);
  EXPECT_LT(report("loops/each/0/chi_square"), 16.27);
  EXPECT_GT(report("loops/each/0/moved_m"), 0.5);
  const std::string graph = read_file(out_ + "/graph.g2o");
  const auto last = std::to_string(read_tum(out_ + "/key_scans.tum").size() - 1);
  EXPECT_TRUE(contains(graph, "\nVERTEX_SE2 " + last + " ")) << last;
  EXPECT_TRUE(contains(graph, "\nEDGE_SE2 "));
  // Odometry alone told the poses, up to the loop.
  const Trajectory live = read_tum(out_ + "/trajectory_live.tum");
  const Trajectory trajectory = read_tum(out_ + "/trajectory.tum");
  ASSERT_EQ(live.size(), trajectory.size());
  const Trajectory truth = read_tum(folder_ / "truth.tum");
  const double live_error = absolute_trajectory_error(live, truth).translation.rmse;
  EXPECT_LT(absolute_trajectory_error(trajectory, truth).translation.rmse, 0.7 * live_error);
  EXPECT_EQ(live.poses().back().pose.x, trajectory.poses().back().pose.x);

  // Those of a map that the robot is only searched in were closed before.
  const std::string old = folder_ / "old.slam";
  std::filesystem::copy_file(out_ + "/map.slam", old);
  const Outcome located =
      run("--matcher odometry_only --duration 20 --set slam/update_map=false --map " + old);
  ASSERT_EQ(located.exit_code, 0) << located.output;
  EXPECT_TRUE(contains(located.output, ", 0 loops closed, in ")) << located.output;
  for (const std::string count : {"tried", "closed", "refused"}) {
    EXPECT_EQ(report("loops/" + count), 0.0) << count;
  }
  EXPECT_EQ(report("loops/closed_before"), 2.0);
}

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

TEST_F(MapBag, DrawsHoughDomainsForDebugging) {
  const std::string debug = folder_ / "debug";
  ASSERT_EQ(run_small({}, "--set slam/insert_distance=0 --debug " + debug).exit_code, 0);
  for (int i = 0; i < 20; ++i) {
    const std::string picture = read_file(debug + "/hough_" + std::to_string(i) + ".png");
    EXPECT_EQ(picture.substr(1, 3), "PNG") << i;
  }
  EXPECT_FALSE(std::filesystem::exists(debug + "/hough_20.png")) << "the first ones only";
  std::filesystem::remove_all(out_);
  replace_file(folder_ / "taken", "");
  expect_one_line(run("--debug " + (folder_ / "taken/debug")), 1, "taken");
}

TEST_F(MapBag, ReportsWhatItDid) {
  ASSERT_EQ(
      run_small({}, "--seed 5 --matcher monte_carlo --set monte_carlo/max_tries=321").exit_code, 0);
  EXPECT_EQ(report("scans/received"), 50.0);
  EXPECT_EQ(report("scans/used"), 50.0);
  EXPECT_EQ(report("scans/skipped_total"), 0.0);
  EXPECT_GT(report("match_ms/p50"), 0.0);
  EXPECT_GE(report("match_ms/p95"), report("match_ms/p50"));
  EXPECT_GE(report("match_ms/max"), report("match_ms/p95"));
  EXPECT_GE(report("scan_ms/p99"), report("match_ms/p99")) << "a scan's time holds its match's";
  EXPECT_EQ(report("scan_ms/by_state/tracking/max"), report("scan_ms/max"));
  EXPECT_GT(report("wall_s"), 0.0);
  EXPECT_GT(report("cpu_s"), 0.0);
  EXPECT_GT(report("real_time_factor"), 0.0);
  EXPECT_GT(report("peak_rss_mb"), 1.0);
  EXPECT_EQ(report("seed"), 5.0);
  EXPECT_EQ(report("configuration/monte_carlo~1max_tries"), 321.0);
  EXPECT_EQ(report("configuration/map~1resolution"), 0.05);
  EXPECT_GT(report("machine/cores"), 0.0);
}

TEST_F(MapBag, WarnsWhenHardlyAScanMatches) {
  const std::string warning = "scans match the map; the others are placed by the prediction alone";
  Outcome outcome = run_small({});
  EXPECT_TRUE(contains(outcome.output, "50 of 50 scans used, 49 matched")) << outcome.output;
  EXPECT_FALSE(contains(outcome.output, warning)) << outcome.output;
  outcome = run("--set slam/min_points=100000 --quiet");
  EXPECT_TRUE(contains(outcome.output, "only 0 of 49 " + warning + "; 49 have too few hits: "))
      << outcome.output;
  outcome = run("--set scan/masked_angles=[-3.14,3.14] --quiet");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.output, "only 0 of 49 " + warning + "; 49 met no map: "))
      << outcome.output;
}

/// Key scans since a fork are given up at a jump from one place that nobody knows to the next, also
/// where another hypothesis takes over with that scan.
TEST_F(MapBag, GoesOnWhereAJumpInDoubtIsOvertaken) {
  const Outcome simulated = run_command(
      MATCHBOX_SIMULATE,
      "--world hotel --seed 22561 --sensor lds01 --odometry none --scan-rate 1.6667 --duration 240 "
      "--fault people:random:10:0.5 --bag " +
          bag_ + " --truth " + (folder_ / "truth.tum"));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  const Outcome mapped = run("--quiet --no-odom");
  EXPECT_EQ(mapped.exit_code, 0) << mapped.output;
  EXPECT_EQ(report("scans/used"), 402.0);
}

TEST_F(MapBag, SaysAtItsEndThatTheScansFitPoorly) {
  const Outcome simulated = run_command(
      MATCHBOX_SIMULATE, "--world rooms --seed 2 --duration 10 --scan-rate 5 --beams 260 --bag " +
                             bag_ + " --truth " + (folder_ / "truth.tum") + " --range-noise 0.3");
  ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  const std::string told = run("--quiet").output;
  EXPECT_TRUE(contains(told, "warning: the scans fit the map poorly (in the median a score of 0."))
      << told;
}

TEST_F(MapBag, OneSeedGivesTheSameBytesWithAnyNumberOfThreads) {
  ASSERT_EQ(run_small({}).exit_code, 0);
  const std::string trajectory = read_file(out_ + "/trajectory.tum");
  const std::string map = read_file(out_ + "/map.pgm");
  for (const char* more : {"", "--threads 2", "--threads 4"}) {
    ASSERT_EQ(run(more).exit_code, 0);
    EXPECT_EQ(read_file(out_ + "/trajectory.tum"), trajectory) << more;
    EXPECT_EQ(read_file(out_ + "/map.pgm"), map) << more;
  }
}

std::string last_lines(const std::string& text, std::size_t lines) {
  std::size_t at = text.size();
  for (; lines > 0; --lines) {
    at = text.rfind('\n', at - 2) + 1;
  }
  return text.substr(at);
}

TEST_F(MapBag, GoesOnWithItsMapAsIfItHadNeverStopped) {
  const std::string every = " --set slam/insert_distance=0 --set slam/insert_angle=0";
  for (const std::string matcher : {"olson", "hough", "monte_carlo"}) {
    for (const std::string odometry : {"", " --no-odom"}) {
      const std::string options = "--matcher " + matcher + odometry + every;
      ASSERT_EQ(run_small({}, options).exit_code, 0);
      const std::string whole = read_file(out_ + "/trajectory.tum");
      const std::string map = read_file(out_ + "/map.pgm");
      const std::string saved = read_file(out_ + "/map.slam");
      SmallBag half;
      half.scans = 25;
      ASSERT_EQ(run_small(half, options).exit_code, 0);
      const std::string old = folder_ / "old.slam";
      std::filesystem::copy_file(out_ + "/map.slam", old,
                                 std::filesystem::copy_options::overwrite_existing);
      SmallBag rest;
      rest.first_scan = 25;
      const Outcome outcome = run_small(rest, options + " --map " + old);
      ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
      EXPECT_TRUE(contains(outcome.output, "whose drive goes on")) << outcome.output;
      EXPECT_TRUE(contains(outcome.output, "25 of 25 scans used, 25 matched")) << outcome.output;
      EXPECT_EQ(last_lines(read_file(out_ + "/trajectory.tum"), 25), last_lines(whole, 25))
          << options;
      EXPECT_TRUE(read_file(out_ + "/map.pgm") == map) << options;
      EXPECT_TRUE(read_file(out_ + "/map.slam") == saved) << options;
    }
  }
}

TEST_F(MapBag, TheFolderOfTheMapIsNotWrittenOverUnasked) {
  write_small_bag(bag_);
  ASSERT_EQ(run("--duration 2").exit_code, 0);
  const std::string map = read_file(out_ + "/map.slam");
  const Outcome refused = run("--start 2.1 --map " + out_ + "/map.slam");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_TRUE(contains(refused.output, "--out: '" + out_ + "' is the folder of " + out_ +
                                           "/map.slam, which would be written over; give another "
                                           "--out, or --overwrite"))
      << refused.output;
  EXPECT_EQ(read_file(out_ + "/map.slam"), map);
  const Outcome asked = run("--start 2.1 --overwrite --map " + out_ + "/map.slam");
  EXPECT_EQ(asked.exit_code, 0) << asked.output;
  const std::string first_line =
      "# Of this drive alone, in the frame of the map that it went on "
      "with: " +
      out_ + "/map.slam\n";
  EXPECT_EQ(read_file(out_ + "/trajectory.tum").substr(0, first_line.size()), first_line);
  EXPECT_EQ(read_file(out_ + "/odometry.tum").substr(0, 1), "1") << "which is in no map";
  EXPECT_TRUE(contains(read_file(out_ + "/key_scans.tum"), "# Of the whole map"));
}

TEST_F(MapBag, ARobotAtRestGetsFreeGround) {
  SmallBag recipe;
  write_small_bag(bag_, recipe);
  ASSERT_EQ(run("").exit_code, 0);
  const MapImage map = read_map(out_ + "/map.yaml");
  int free = 0;
  int occupied = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      free += map.state({x, y}) == CellState::kFree ? 1 : 0;
      occupied += map.state({x, y}) == CellState::kOccupied ? 1 : 0;
    }
  }
  EXPECT_GT(free, 1000);  // of 16 m^2 with a blind sector
  EXPECT_GT(occupied, 100);
}

TEST_F(MapBag, ScansThatANodeHadNoTimeForAreLeftOutAgain) {
  write_small_bag(bag_);
  const std::string events = folder_ / "events.yaml";
  replace_file(events,
               "- scan: 1001.0\n  leave_out: true\n- scan: 1001.05\n  leave_out: true\n"
               "- scan: 1002.0\n  leave_out: true\n");
  const Outcome outcome = run("--events " + events);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(poses(), 48U) << "that of 1001.05 was never there";
  EXPECT_EQ(report("scans/skipped/too_late"), 2.0);
  const Trajectory trajectory = read_tum(out_ + "/trajectory.tum");
  for (const StampedPose2& pose : trajectory.poses()) {
    EXPECT_NE(pose.stamp, 1001.0);
    EXPECT_NE(pose.stamp, 1002.0);
  }
}

TEST_F(MapBag, LocalisesInItsMapWithoutChangingIt) {
  const std::string every = "--set slam/insert_distance=0 --set slam/insert_angle=0 ";
  ASSERT_EQ(run_small({}, every).exit_code, 0);
  const std::vector<StampedPose2> whole = read_tum(out_ + "/trajectory.tum").poses();
  SmallBag half;
  half.scans = 25;
  ASSERT_EQ(run_small(half, every).exit_code, 0);
  const std::string old = folder_ / "old.slam";
  std::filesystem::copy_file(out_ + "/map.slam", old);
  const std::string map = read_file(out_ + "/map.pgm");
  SmallBag rest;
  rest.first_scan = 25;
  const Outcome outcome = run_small(rest, every + "--set slam/update_map=false --map " + old);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "25 of 25 scans used, 25 matched")) << outcome.output;
  EXPECT_TRUE(read_file(out_ + "/map.pgm") == map);
  EXPECT_TRUE(std::filesystem::exists(out_ + "/map.slam"));
  const std::vector<StampedPose2> located = read_tum(out_ + "/trajectory.tum").poses();
  ASSERT_EQ(located.size(), 25U);
  for (std::size_t i = 0; i < located.size(); ++i) {
    EXPECT_LT(difference(located[i].pose, whole[25 + i].pose).norm(), 0.01) << i;
  }
}

TEST_F(MapBag, ARobotOfAnotherDriveIsLostUntilItMoves) {
  ASSERT_EQ(run_small({}).exit_code, 0);
  const std::string old = folder_ / "old.slam";
  std::filesystem::copy_file(out_ + "/map.slam", old);
  const std::string map = read_file(out_ + "/map.pgm");
  for (const double begin : {500.0, 2000.0}) {
    SmallBag other;
    other.begin = begin;
    const Outcome outcome = run_small(other, "--map " + old);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(contains(outcome.output,
                         "old.slam; this is another drive, as its first scan is " +
                             std::string(begin < 1000.0 ? "504.900 s older" : "995.100 s newer") +
                             " than the last one of the map: the robot is searched"))
        << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "found nowhere in the map: 1; ")) << outcome.output;
    EXPECT_TRUE(read_file(out_ + "/map.pgm") == map);
    EXPECT_EQ(report("scans/state/lost"), 50.0);
    EXPECT_GT(report("scans/inserted"), 0.0);
  }
  ASSERT_EQ(run("--set slam/update_map=false --map " + old).exit_code, 0);
  EXPECT_EQ(report("scans/state/lost"), 50.0);
  EXPECT_EQ(report("scans/inserted"), 0.0);
  EXPECT_FALSE(contains(read_file(out_ + "/scans.csv"), ",1\n"));
  std::filesystem::remove_all(out_);
  expect_one_line(run("--map " + (folder_ / "none.slam")), 2, "none.slam");
  expect_one_line(run("--quiet --map " + old + " --set map/resolution=0.1"), 2, "map/resolution");
}

/// Part of a run as a drive of its own, whose odometry begins at zero.
SimulatedRun part_of(const SimulatedRun& run, std::size_t from, std::size_t to) {
  SimulatedRun part;
  part.base_from_laser = run.base_from_laser;
  part.scans = {run.scans.begin() + static_cast<std::ptrdiff_t>(from),
                run.scans.begin() + static_cast<std::ptrdiff_t>(to)};
  const double begin = part.scans.front().stamp - 0.1;
  const double end = part.scans.back().stamp + 0.1;
  for (const OdometryReading& reading : run.odometry) {
    if (reading.stamp > begin && reading.stamp < end) {
      part.odometry.push_back(reading);
    }
  }
  const Pose2 odom_from_begin = part.odometry.front().odom_from_base;
  for (OdometryReading& reading : part.odometry) {
    reading.odom_from_base = odom_from_begin.inverse() * reading.odom_from_base;
  }
  return part;
}

/// Two drives in one world, the second an hour later and from another start, which it sees again.
class TwoDrives : public MapBag {
 protected:
  TwoDrives() {
    const World world = make_world("loop", 3);
    SimulationOptions options;
    options.laser.beams = 260;
    options.laser.scan_rate = 2.5;
    options.drive.speed = 1.0;
    const auto record = [&](const std::string& bag, std::uint64_t seed, std::size_t from,
                            std::size_t to) {
      const SimulatedRun run = simulate_run(world, world.route(), options, seed);
      SimulatedBagWriter(bag, {}).write(part_of(run, from, std::min(to, run.scans.size())),
                                        {"loop", 3, options.laser, {}});
      for (std::size_t i = 0; i < run.scans.size(); ++i) {
        truth_[std::lround(1e3 * run.scans[i].stamp)] = run.world_from_base[i];
      }
      return run.world_from_base[from];
    };
    world_from_map_ = record(bag_, 3, 0, 190);
    options.time.start_stamp += 3600.0;
    record(second_, 4, 80, 1000);
  }

  /// Farthest from the truth [m] of a file of poses.
  double worst(const std::string& file) {
    double worst = 0.0;
    const Trajectory poses = read_tum(out_ + "/" + file);
    for (const StampedPose2& pose : poses.poses()) {
      const Pose2 truth = world_from_map_.inverse() * truth_.at(std::lround(1e3 * pose.stamp));
      worst = std::max(worst, (pose.pose.translation() - truth.translation()).norm());
    }
    return worst;
  }

  const std::string second_ = folder_ / "second.bag";
  std::map<long, Pose2> truth_;  ///< world_from_base by stamp [ms]
  Pose2 world_from_map_;
};

TEST_F(TwoDrives, BecomeOneMap) {
  const auto expect_one_map = [this](const Outcome& outcome, const std::string& told) {
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, told)) << outcome.output;
    EXPECT_LT(worst("trajectory.tum"), 0.02);  // 0.012
    EXPECT_LT(worst("key_scans.tum"), 0.02) << "a wall is drawn twice";
    EXPECT_GE(report("loops/closed"), 1.0);  // where the second one ends and the first began
    EXPECT_EQ(report("scans/maps_apart"), 0.0);
  };
  expect_one_map(run(second_), "\nanother drive begins after 190 scans: the robot is searched for");
  ASSERT_EQ(run("").exit_code, 0);
  const std::string old = folder_ / "old.slam";
  std::filesystem::copy_file(out_ + "/map.slam", old);
  expect_one_map(run_command(MATCHBOX_MAP_BAG, second_ + " --out " + out_ + " --map " + old),
                 " newer than the last one of the map: the robot is searched for in the map");
}

TEST_F(MapBag, DrivesThatNeverMeetAreNotDrawnOverEachOther) {
  const auto drive = [this](const std::string& bag, const std::string& world, int seed,
                            double begin) {
    SimulationOptions options;
    options.laser.beams = 260;
    options.laser.scan_rate = 5.0;
    options.time.start_stamp = begin;
    const World there = make_world(world, static_cast<std::uint64_t>(seed));
    SimulatedRun run =
        simulate_run(there, there.route(), options, static_cast<std::uint64_t>(seed));
    SimulatedBagWriter(bag, {}).write(part_of(run, 0, 100), {world, 3, options.laser, {}});
  };
  const std::string second = folder_ / "second.bag";
  drive(bag_, "rooms", 3, 1000.0);
  drive(second, "loop", 3, 5000.0);
  const Outcome outcome = run(second);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output,
                       "100 of 200 poses are in such maps, each in a frame of its "
                       "own that has nothing to do with the map's"))
      << outcome.output;
  EXPECT_EQ(poses(), 200U);
}

TEST_F(MapBag, TellsOfFilesWhoseScansAreOfTheSameTime) {
  SmallBag recipe;
  write_small_bag(bag_, recipe);
  const std::string second = folder_ / "second.bag";
  recipe.begin = 1002.05;
  write_small_bag(second, recipe);
  const Outcome mixed = run(second);
  EXPECT_TRUE(contains(mixed.output, "warning: " + bag_ + " and " + second +
                                         " both hold scans of /scan, and are of the same time for "
                                         "3.2 s: they are read as one recording"))
      << mixed.output;
  EXPECT_TRUE(contains(mixed.output, "merge_maps A/map.slam B/map.slam --out DIR")) << mixed.output;
  recipe.begin = 1004.5;  // as the files of a drive that is split
  write_small_bag(second, recipe);
  EXPECT_FALSE(contains(run(second).output, "the same time"));
  recipe.begin = 1002.05;
  recipe.scan_topic = "/rear_scan";
  write_small_bag(second, recipe);
  EXPECT_FALSE(contains(run(second + " --scan-topic /scan --scan-topic /rear_scan").output,
                        "the same time"));
}

TEST_F(MapBag, WhatIsNoMapToGoOnWithIsRefusedWithWhatToGive) {
  write_small_bag(bag_);
  expect_one_line(run("--map " + (folder_ / "")), 2, "is a folder; give the map in it");
  expect_one_line(run("--map " + bag_), 2, "is a recording; map_bag");
  expect_one_line(run("--map map.png"), 2, "is the image of a map; give the .slam");
}

TEST_F(MapBag, LaterConfigurationsReplaceEarlierOnes) {
  replace_file(folder_ / "a.yaml", "matcher: odometry_only\nseed: 3\nmap: {resolution: 0.1}\n");
  replace_file(folder_ / "b.yaml", "map: {resolution: 0.2}\nseed: 4\n");
  const std::string files =
      "--config " + (folder_ / "a.yaml") + " --config " + (folder_ / "b.yaml");
  ASSERT_EQ(run_small({}, files).exit_code, 0);
  EXPECT_EQ(report("configuration/map~1resolution"), 0.2);
  EXPECT_EQ(report("seed"), 4.0);
  ASSERT_EQ(run(files + " --seed 5 --matcher monte_carlo --set map/resolution=0.08").exit_code, 0);
  EXPECT_EQ(report("configuration/map~1resolution"), 0.08);
  EXPECT_EQ(report("seed"), 5.0);
  EXPECT_TRUE(contains(read_file(out_ + "/report.json"), "matchbox_slam/MonteCarlo"));
}

TEST_F(MapBag, TakesEachKindOfBag) {
  for (const auto compression : {rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    SmallBag recipe;
    recipe.compression = compression;
    ASSERT_EQ(run_small(recipe).exit_code, 0);
    EXPECT_EQ(poses(), 50U);
  }
}

TEST_F(MapBag, TakesSeveralBagsInAnyOrder) {
  SmallBag second;
  second.begin = 1005.0;
  write_small_bag(folder_ / "second.bag", second);
  ASSERT_EQ(run_small({}, "").exit_code, 0);
  const Outcome outcome = run(folder_ / "second.bag");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(poses(), 100U);
}

TEST_F(MapBag, TakesAPeriod) {
  ASSERT_EQ(run_small({}, "--start 2.05 --duration 1").exit_code, 0);
  EXPECT_EQ(poses(), 10U);
  EXPECT_EQ(run("--quiet --start 2.05 --duration 1").output, "");
  std::filesystem::remove_all(out_);
  expect_one_line(run("--start 1000"), 1, "holds no scan on topic /scan in the period asked for");
}

TEST_F(MapBag, TakesFramesWithLeadingSlashes) {
  SmallBag recipe;
  recipe.odom_frame = "/odom_combined";
  recipe.base_frame = "/base_footprint";
  recipe.laser_frame = "/base_laser_link";
  for (const char* frames : {"", "--base-frame /base_footprint --odom-frame odom_combined"}) {
    ASSERT_EQ(run_small(recipe, frames).exit_code, 0);
    EXPECT_EQ(poses(), 50U);
  }
}

TEST_F(MapBag, IgnoresAMapThatTheBagHoldsAndSaysSoOnce) {
  SmallBag recipe;
  recipe.other_parent = "/map";
  const Outcome outcome = run_small(recipe);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const std::string said = "tf in the bag that touches the map frame is ignored: map -> odom";
  const std::size_t first = outcome.output.find(said);
  EXPECT_NE(first, std::string::npos) << outcome.output;
  EXPECT_EQ(outcome.output.find(said, first + 1), std::string::npos) << outcome.output;
  EXPECT_EQ(poses(), 50U);
}

TEST_F(MapBag, WaitsForTransformsThatComeAfterTheirScan) {
  SmallBag recipe;
  recipe.transform_delay = 1.5;
  ASSERT_EQ(run_small(recipe).exit_code, 0);
  EXPECT_EQ(poses(), 50U);
}

TEST_F(MapBag, CountsScansThatTransformsDoNotReach) {
  SmallBag recipe;
  recipe.transform_delay = 3.0;
  const Outcome outcome = run_small(recipe, "--set transform_timeout=1");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(contains(outcome.output,
                       "none of 50 scans could be used; the first: scan of "
                       "1000.000 s skipped (no_transform): no transform from "
                       "'laser' to 'base_link'"))
      << outcome.output;
}

TEST_F(MapBag, FindsAndCorrectsAnOffsetOfTheClocks) {
  SmallBag recipe;
  recipe.scan_clock = -82.2;
  const Outcome plain = run_small(recipe);
  EXPECT_EQ(plain.exit_code, 1);
  EXPECT_TRUE(contains(plain.output,
                       "the clocks of scans and tf differ: scans are 82.2 s behind; to "
                       "correct that give --set scan_time_offset=auto"))
      << plain.output;
  for (const char* offset : {"auto", "82.2"}) {
    const Outcome corrected = run(std::string("--set scan_time_offset=") + offset);
    EXPECT_EQ(corrected.exit_code, 0) << corrected.output;
    EXPECT_EQ(poses(), 50U);
    EXPECT_NEAR(report("estimated_clock_offset_s"), 82.2, 1e-3);
    EXPECT_NEAR(report("scan_time_offset_s"), 82.2, 1e-3);
  }
}

TEST_F(MapBag, MapsWithSeveralLasers) {
  write_small_bag(bag_);
  SmallBag back;
  back.scan_topic = "/back_scan";
  back.with_transforms = false;
  const std::string second = folder_ / "back.bag";
  write_small_bag(second, back);
  const Outcome outcome = run(second + " --set 'scan_topics=[/scan, /back_scan]'");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(report("scans/used"), 100.0);
  EXPECT_EQ(poses(), 50U) << "two lasers at one moment give one pose";
  const std::string first = read_file(out_ + "/trajectory.tum");
  const Outcome by_flags = run(second + " --scan-topic /scan --scan-topic /back_scan");
  EXPECT_EQ(by_flags.exit_code, 0) << by_flags.output;
  EXPECT_EQ(report("scans/used"), 100.0);
  EXPECT_EQ(read_file(out_ + "/trajectory.tum"), first);
}

TEST_F(MapBag, MapsFromTheLaserAlone) {
  SmallBag recipe;
  recipe.with_transforms = false;
  expect_one_line(
      run_small(recipe), 2,
      "tf in the bag says nothing of the scan's frame 'laser', so there is no odometry; "
      "to map from the laser alone give --no-odom");
  const Outcome outcome = run("--no-odom");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(poses(), 50U);
  EXPECT_EQ(read_tum(out_ + "/odometry.tum").size(), 0U);
}

/// A copy of a bag in which the odometry is no tf, but nav_msgs/Odometry on /odom.
void move_odometry_to_topic(const std::string& from, const std::string& to) {
  rosbag::Bag in(from, rosbag::bagmode::Read);
  rosbag::Bag out(to, rosbag::bagmode::Write);
  for (const rosbag::MessageInstance& message : rosbag::View(in)) {
    const auto links = message.instantiate<tf2_msgs::TFMessage>();
    if (links == nullptr) {
      out.write(message.getTopic(), message.getTime(), message, message.getConnectionHeader());
      continue;
    }
    for (const geometry_msgs::TransformStamped& link : links->transforms) {
      if (link.header.frame_id != "odom_combined") {
        out.write("/tf", message.getTime(), make_transforms({link}));
        continue;
      }
      nav_msgs::Odometry odometry;
      odometry.header = link.header;
      odometry.child_frame_id = link.child_frame_id;
      odometry.pose.pose.position.x = link.transform.translation.x;
      odometry.pose.pose.position.y = link.transform.translation.y;
      odometry.pose.pose.orientation = link.transform.rotation;
      out.write("/odom", message.getTime(), odometry);
    }
  }
}

TEST_F(MapBag, OdometryOnATopicGivesTheBytesThatItGivesOnTf) {
  ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                        "--world rooms --seed 4 --duration 10 --beams 260 --scan-rate 5 --bag " +
                            bag_ + " --truth " + (folder_ / "truth.tum"))
                .exit_code,
            0);
  ASSERT_EQ(run("").exit_code, 0);
  const std::string trajectory = read_file(out_ + "/trajectory.tum");
  const std::string odometry = read_file(out_ + "/odometry.tum");
  const std::string by_topic = folder_ / "topic.bag";
  move_odometry_to_topic(bag_, by_topic);
  for (const std::string named : {"", " --odom-topic odom"}) {
    const Outcome outcome = run_command(MATCHBOX_MAP_BAG, by_topic + " --out " + out_ + named);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(
        contains(outcome.output, "; odometry on topic /odom, of base_footprint in odom_combined\n"))
        << outcome.output;
    EXPECT_EQ(read_file(out_ + "/trajectory.tum"), trajectory);
    EXPECT_EQ(read_file(out_ + "/odometry.tum"), odometry);
  }
  EXPECT_EQ(report("invalid_odometry"), 0.0);
}

TEST_F(MapBag, TakesTheLaserWhereItIsSaidToBe) {
  SmallBag recipe;
  recipe.laser_frame = "lidar";
  write_small_bag(bag_, recipe);
  ASSERT_EQ(run("").exit_code, 0);
  const std::string trajectory = read_file(out_ + "/trajectory.tum");
  // The same without the laser's place in tf.
  recipe.with_transforms = false;
  write_small_bag(bag_, recipe);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    for (int k = -2; k < 105; ++k) {
      const double stamp = 1000.0 + 0.05 * k;
      bag.write("/tf", ros::Time(stamp), make_link(stamp, "odom", "base_link", 0.001 * k));
    }
  }
  std::filesystem::remove_all(out_);
  expect_one_line(run(""), 2, "or say where the laser is on the robot with --laser-pose X,Y,YAW");
  expect_one_line(run("--laser-pose 0.2,zero,0"), 2, "allowed: [x, y, yaw] in m and rad");
  const Outcome outcome = run("--laser-pose 0.2,0,0");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(read_file(out_ + "/trajectory.tum"), trajectory);
  EXPECT_EQ(run("--laser-pose -0.2,0,0").exit_code, 0);
}

TEST_F(MapBag, AJumpWhileItIsInDoubtLosesNothing) {
  ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                        "--world rooms --seed 8 --duration 70 --sensor rplidar_a1 --turn-rate 2.5 "
                        "--turn-acceleration 20 --imu --no-odometry --rotation-noise 0.002 "
                        "--heading-noise 0.0005 --heading-bias 0 --rotation-bias 0.005 --bag " +
                            bag_ + " --truth " + (folder_ / "truth.tum"))
                .exit_code,
            0);
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
}

TEST_F(MapBag, AdvisesToMaskBeamsThatEndOnTheRobot) {
  const std::string healthy = folder_ / "healthy.bag";
  ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                        "--world rooms --seed 4 --duration 120 --beams 261 --scan-rate 5 --bag " +
                            healthy + " --truth " + (folder_ / "truth.tum"))
                .exit_code,
            0);
  const Outcome silent = run_command(MATCHBOX_MAP_BAG, healthy + " --out " + out_);
  EXPECT_FALSE(contains(silent.output, "warning")) << silent.output;
  convert_bag(healthy, bag_, "/base_scan", "/base_scan", [](sensor_msgs::LaserScan scan) {
    for (std::size_t k = 20; k < 30; ++k) {
      scan.ranges[k] = 0.45F;
    }
    return scan;
  });
  const Outcome told = run("");
  EXPECT_EQ(told.exit_code, 0);
  EXPECT_TRUE(contains(told.output,
                       "warning: beams end on the robot itself: in 1 sector the range stays the "
                       "same wherever it is; to leave them out of every laser's scans give --set "
                       "scan/masked_angles=[-1.947,-1.739]\n"))
      << told.output;
  const Outcome masked = run("--set scan/masked_angles=[-1.947,-1.739]");
  EXPECT_FALSE(contains(masked.output, "warning")) << masked.output;
}

TEST_F(MapBag, ScansOfFewReturnsAreTold) {
  for (const auto& [beams, is_told] : {std::pair("8", true), {"32", true}, {"64", false}}) {
    ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                          "--world rooms --seed 5 --duration 15 --sensor ranger32 --beams " +
                              std::string(beams) + " --bag " + bag_ + " --truth " +
                              (folder_ / "truth.tum"))
                  .exit_code,
              0);
    const Outcome mapped = run("");
    EXPECT_EQ(mapped.exit_code, 0);
    EXPECT_EQ(contains(mapped.output,
                       " returns in the median; with fewer than 40 the map is hardly better than "
                       "odometry, and may be worse"),
              is_told)
        << mapped.output;
  }
}

/// A bag whose scans start over at an earlier stamp, as when the robot's clock was set back.
void write_bag_with_time_jump(const std::string& path) {
  SmallBag recipe;
  recipe.scans = 30;
  write_small_bag(path, recipe);
  rosbag::Bag bag(path, rosbag::bagmode::Append);
  for (int k = 0; k < 60; ++k) {
    const double stamp = 900.0 + 0.05 * k;
    const ros::Time recorded(1010.0 + 0.05 * k);
    bag.write("/tf", recorded,
              make_transforms({make_transform(stamp, "odom", "base_link", 0.001 * k),
                               make_transform(stamp, "base_link", "laser", 0.2)}));
    bag.write("/scan", recorded, make_scan(stamp));
  }
}

TEST_F(MapBag, CutsBeamsThatReadTheLargestRangePlusNoise) {
  write_small_bag(bag_);
  rosbag::Bag bag(bag_, rosbag::bagmode::Append);
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const double stamp = 1000.01 + 0.1 * i;
    sensor_msgs::LaserScan scan = make_scan(stamp);
    for (std::size_t k = 0; k < scan.ranges.size(); k += 2) {
      scan.ranges[k] = scan.range_max + 0.02F * static_cast<float>(random.gaussian());
    }
    bag.write("/far_scan", ros::Time(stamp), scan);
  }
  bag.close();
  const Outcome cut = run("--scan-topic /far_scan");
  EXPECT_EQ(cut.exit_code, 0) << cut.output;
  EXPECT_TRUE(contains(cut.output,
                       "beams of a laser read one range plus noise; scan/max_range "
                       "is set to 29."))
      << cut.output;
  EXPECT_NEAR(report("configuration/scan~1max_range"), 29.9, 0.02);
  EXPECT_LT(read_map(out_ + "/map.yaml").width, 200);
  const Outcome kept = run("--scan-topic /far_scan --set scan/max_range=40");
  EXPECT_FALSE(contains(kept.output, "plus noise")) << kept.output;
  EXPECT_GT(read_map(out_ + "/map.yaml").width, 500) << "walls at 30 m";
  EXPECT_FALSE(contains(run("--scan-topic /scan").output, "plus noise"));
}

TEST_F(MapBag, GoesOnStartsAnewOrStopsWhenTimeJumpsBack) {
  write_bag_with_time_jump(bag_);
  const Outcome on = run("");
  EXPECT_EQ(on.exit_code, 0) << on.output;
  EXPECT_TRUE(contains(on.output, "after 30 scans: the map goes on, as time_jump is 'go_on'"))
      << on.output;
  EXPECT_TRUE(contains(on.output, "poses of before the first step are in " + out_ +
                                      "/trajectory.1.tum, those since the last one in"))
      << on.output;
  for (const std::string name : {"trajectory", "trajectory_live", "odometry"}) {
    EXPECT_EQ(read_tum(out_ + "/" + name + ".1.tum").size(), 30U) << name;
    const Trajectory since = read_tum(out_ + "/" + name + ".tum");
    EXPECT_EQ(30.0 + static_cast<double>(since.size()), report("scans/used")) << name;
    EXPECT_LT(since.poses().back().stamp, 910.0) << name;
  }
  EXPECT_EQ(report("clock_steps"), 1.0);
  EXPECT_EQ(report("resets"), 0.0);
  EXPECT_EQ(report("scans/received"), report("scans/used") + report("scans/skipped_total"));
  const Outcome reset = run("--set time_jump=reset");
  EXPECT_EQ(reset.exit_code, 0) << reset.output;
  EXPECT_TRUE(contains(reset.output, "after 30 scans: starting a new map, as time_jump is 'reset'"))
      << reset.output;
  EXPECT_LT(read_tum(out_ + "/trajectory.tum").poses().front().stamp, 910.0);
  EXPECT_EQ(report("resets"), 1.0);
  EXPECT_EQ(report("scans/used"), static_cast<double>(poses()));
  EXPECT_EQ(report("scans/skipped/before_reset"), 30.0);
  EXPECT_EQ(report("scans/skipped/out_of_order"), 2.0);
  EXPECT_EQ(report("scans/received"), report("scans/used") + report("scans/skipped_total"));
  const Outcome stop = run("--set time_jump=stop");
  EXPECT_EQ(stop.exit_code, 0) << stop.output;
  EXPECT_TRUE(contains(stop.output, "stopping there, as time_jump is 'stop'")) << stop.output;
  EXPECT_EQ(poses(), 30U);
}

TEST_F(MapBag, WhenNothingAfterATimeJumpCanBeUsedItSaysThat) {
  SmallBag recipe;
  recipe.scans = 30;
  write_small_bag(bag_, recipe);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    for (int k = 0; k < 40; ++k) {  // without transforms
      bag.write("/scan", ros::Time(1010.0 + 0.05 * k), make_scan(900.0 + 0.05 * k));
    }
  }
  EXPECT_EQ(run("").exit_code, 0) << "what was mapped before is a map";
  EXPECT_EQ(poses(), 30U);
  const Outcome outcome = run("--quiet --set time_jump=reset");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  const std::string last = outcome.output.substr(outcome.output.find("map_bag: "));
  EXPECT_TRUE(contains(last,
                       "of 70 scans 30 were used before time jumped back and none since, the "
                       "first: scan of 900.1"))
      << last;
  EXPECT_TRUE(contains(last, "(no_transform)")) << last;
  EXPECT_TRUE(contains(last, "--set time_jump=stop")) << last;
}

TEST_F(MapBag, OneScanWithAWrongStampCostsNoMap) {
  write_small_bag(bag_);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    bag.write("/scan", ros::Time(1002.01), make_scan(900.0));
  }
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(poses(), 50U);
  EXPECT_EQ(report("resets"), 0.0);
  EXPECT_EQ(report("scans/skipped/out_of_order"), 1.0);
}

TEST_F(MapBag, FixedLinksOnTfAreNoOdometry) {
  const Outcome simulated =
      run_command(MATCHBOX_SIMULATE, "--world rooms --duration 3 --beams 60 --no-odometry --bag " +
                                         bag_ + " --truth " + (folder_ / "truth.tum"));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  expect_one_line(run(""), 2,
                  "tf holds no link that moves, so there is no odometry; to map from the laser "
                  "alone give --no-odom, or name --odom-frame and --base-frame");
  const Outcome alone = run("--no-odom");
  EXPECT_EQ(alone.exit_code, 0) << alone.output;
  EXPECT_EQ(poses(), 61U);
  EXPECT_EQ(read_tum(out_ + "/odometry.tum").size(), 0U);
  const Outcome named = run("--odom-frame base_footprint --base-frame base_link");
  EXPECT_EQ(named.exit_code, 0) << named.output;
  EXPECT_GT(poses(), 50U);
}

TEST_F(MapBag, SkipsScansThatAreNoneAndSaysWhy) {
  write_small_bag(bag_);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    sensor_msgs::LaserScan scan = make_scan(1000.05);
    scan.ranges.clear();
    bag.write("/scan", ros::Time(1000.05), scan);
    scan = make_scan(1000.06);
    scan.angle_increment = std::nanf("");
    bag.write("/scan", ros::Time(1000.06), scan);
    bag.write("/scan", ros::Time(1000.11), make_scan(1000.1));
  }
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "skipped (empty): it has no ranges")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "skipped (invalid): its angle_min")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "skipped (duplicate_stamp)")) << outcome.output;
  EXPECT_EQ(poses(), 50U);
  EXPECT_EQ(report("scans/received"), 53.0);
  EXPECT_EQ(report("scans/skipped/empty"), 1.0);
  EXPECT_EQ(report("scans/skipped/invalid"), 1.0);
  EXPECT_EQ(report("scans/skipped/duplicate_stamp"), 1.0);
}

TEST_F(MapBag, RefusesBagsThatCannotBeRead) {
  expect_one_line(run(""), 2, "bag '" + bag_ + "' does not exist");
  replace_file(bag_, "");
  expect_one_line(run(""), 1, "is empty (0 bytes)");
  replace_file(bag_, "no bag");
  expect_one_line(run(""), 1, "is no bag");
  write_small_bag(bag_);
  const std::string bytes = read_file(bag_);
  replace_file(bag_, bytes.substr(0, bytes.size() / 2));
  expect_one_line(
      run(""), 1,
      "makes it readable, but only up to the first damage: what is behind that is lost");
}

TEST_F(MapBag, WritesThePartBeforeADamage) {
  SmallBag recipe;
  recipe.scans = 4000;
  recipe.compression = rosbag::compression::BZ2;
  write_small_bag(bag_, recipe);
  std::string bytes = read_file(bag_);
  const std::size_t chunk = bytes.find("BZh", bytes.size() / 2);
  ASSERT_NE(chunk, std::string::npos);
  bytes.replace(chunk + 200, 64, std::string(64, 'x'));
  replace_file(bag_, bytes);
  for (const char* threads : {"", "--threads 2"}) {
    const Outcome outcome = run(threads);
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "the results cover the part before")) << outcome.output;
    EXPECT_GT(poses(), 100U);
    EXPECT_LT(poses(), 4000U);
  }
}

TEST_F(MapBag, WritesNothingWhereTheBeginningOrAHeaderIsDamaged) {
  SmallBag recipe;
  recipe.scans = 4000;
  recipe.compression = rosbag::compression::BZ2;
  write_small_bag(bag_, recipe);
  const std::string whole = read_file(bag_);
  const auto expect_nothing = [&](std::size_t place) {
    ASSERT_NE(place, std::string::npos);
    std::string bytes = whole;
    bytes.replace(place, 64, std::string(64, 'x'));
    replace_file(bag_, bytes);
    expect_one_line(run(""), 1, "is damaged at byte ");
  };
  expect_nothing(whole.find("BZh") + 200);
  expect_nothing(whole.find("compression=bz2", whole.size() / 2));
}

TEST_F(MapBag, RefusesWhatCannotBeWrittenBeforeItStarts) {
  write_small_bag(bag_);
  replace_file(folder_ / "file", "");
  out_ = folder_ / "file/out";
  const Outcome outcome = run("");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, out_)) << outcome.output;
  EXPECT_FALSE(contains(outcome.output, "scan topic")) << outcome.output;
}

TEST_F(MapBag, AFullDiskLeavesTheOldResults) {
  ASSERT_EQ(run_small({}).exit_code, 0);
  std::map<std::string, std::string> old;
  for (const auto& file : std::filesystem::directory_iterator(out_)) {
    old[file.path().string()] = read_file(file.path().string());
  }
  const Outcome outcome =
      run_on_full_disk(MATCHBOX_MAP_BAG, bag_ + " --quiet --set map/resolution=0.02 --out " + out_);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_EQ(outcome.output, "map_bag: cannot write '" + out_ + "/scans.csv': File too large\n");
  std::size_t files = 0;
  for (const auto& file : std::filesystem::directory_iterator(out_)) {
    EXPECT_TRUE(read_file(file.path().string()) == old[file.path().string()]) << file.path();
    ++files;
  }
  EXPECT_EQ(files, old.size());
}

TEST_F(MapBag, LeavesAWildPoseOutOfTheMap) {
  write_small_bag(bag_);
  {
    rosbag::Bag bag(bag_, rosbag::bagmode::Append);
    for (const double stamp : {1010.0, 1010.1}) {  // 10000 km to the north-east
      tf2_msgs::TFMessage message = make_robot_transforms(stamp, {});
      message.transforms[0].transform.translation.x = 1e7;
      message.transforms[0].transform.translation.y = 1e7;
      bag.write("/tf", ros::Time(stamp), message);
    }
    bag.write("/scan", ros::Time(1010.05), make_scan(1010.05));
  }
  const Outcome outcome = run("--matcher odometry_only");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "a scan is left out of the map")) << outcome.output;
  EXPECT_EQ(poses(), 51U);
  EXPECT_LT(read_map(out_ + "/map.yaml").width, 200);
}

/// What old recordings have besides: a map of their own, odometry that names no child, tf twice.
void add_old_habits(const std::string& path) {
  rosbag::Bag bag(path, rosbag::bagmode::Append);
  for (int k = 0; k < 20; ++k) {
    const double stamp = 1327500000.0 + 0.05 * k;
    bag.write("/tf", ros::Time(stamp), make_link(stamp, "/map", "/odom_combined", 1.0));
    bag.write("/tf", ros::Time(stamp), make_link(1327500000.0, "/base_footprint", "/tilt", 1.0));
    nav_msgs::Odometry odometry;
    odometry.header.stamp = ros::Time(stamp);
    odometry.header.frame_id = "/odom_combined";
    bag.write("/base_odometry/odom", ros::Time(stamp), odometry);
  }
}

TEST_F(MapBag, TakesABagWithEveryQuirkOfMitStata) {
  const std::string truth_file = folder_ / "truth.tum";
  const Outcome simulated =
      run_command(MATCHBOX_SIMULATE,
                  "--world rooms --duration 10 --beams 360 --clock-offset 82.2 --leading-slashes "
                  "--compression bz2 --bag " +
                      bag_ + " --truth " + truth_file);
  ASSERT_EQ(simulated.exit_code, 0) << simulated.output;
  add_old_habits(bag_);
  const Outcome outcome = run("--set scan_time_offset=auto");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "map -> odom_combined")) << outcome.output;
  EXPECT_NEAR(report("scan_time_offset_s"), 82.2, 0.05);
  // By the clock of the laser, as MIT's is.
  std::vector<StampedPose2> truth;
  const Trajectory recorded = read_tum(truth_file);
  for (StampedPose2 pose : recorded.poses()) {
    pose.stamp += report("scan_time_offset_s");
    truth.push_back(pose);
  }
  const Trajectory estimate = read_tum(out_ + "/trajectory.tum");
  EXPECT_GE(estimate.size() + 2, truth.size());
  EXPECT_LT(absolute_trajectory_error(estimate, Trajectory(truth)).translation.rmse, 0.02);
}

TEST_F(MapBag, RefusesWrongUsage) {
  write_small_bag(bag_);
  expect_one_line(run("--matcher monte_carlo --set monte_carlo/max_trys=3"), 2,
                  "did you mean 'max_tries'");
  expect_one_line(run("--set map/resolution=0"), 2, "0.005 to 1");
  expect_one_line(run("--matcher olsen"), 2, "there is no matcher 'olsen'; known: ");
  expect_one_line(run("--config " + (folder_ / "none.yaml")), 2, "none.yaml");
  expect_one_line(run("--scan-topic /tf"), 2, "topic '/tf' of the bag holds tf2_msgs/TFMessage");
  expect_one_line(run("--scan-topic /back"), 2, "the bag has no topic '/back'");
  expect_one_line(run("--odom-frame world"), 2, "odometry frame 'world' is not above");
  expect_one_line(run("--odom-frame /laser --base-frame laser"), 2,
                  "odom_frame: 'laser' is not allowed; allowed: a frame other than base_frame");
  expect_one_line(run("--odom-frame odom --set map_frame=odom"), 2,
                  "odom_frame: 'odom' is not allowed; allowed: a frame other than map_frame");
  expect_one_line(run("--set scan_time_offset=1e7"), 2,
                  "scan_time_offset: 10000000.0 is not allowed");
  expect_one_line(run("--set publish_tf=false"), 2,
                  "publish_tf: only the node has this option; leave it out");
  replace_file(folder_ / "node.yaml", "initial_map: old.slam\n");
  expect_one_line(run("--config " + (folder_ / "node.yaml")), 2,
                  "initial_map: only the node has this option; leave it out");
  expect_one_line(run("--threads 0"), 2, "--threads: 0 is not allowed; allowed: 1 to 1024");
  expect_one_line(run("--duration abc"), 2,
                  "--duration: abc is not a number; allowed: 0 to 1000000000");
  expect_one_line(run("--start -1"), 2, "--start: -1 is not allowed; allowed: 0 to 1000000000");
  expect_one_line(run("--seed 1.5"), 2, "--seed: 1.5 is not a whole number");
  expect_one_line(run("--set slam/update_map=false"), 2,
                  "slam/update_map: false needs a map to find the robot in; give one with --map");
  expect_one_line(run("--set insert_distance=1"), 2, "did you mean 'slam/insert_distance'?");
  const Outcome unknown = run("--set nothing_like_it=1");
  expect_one_line(unknown, 2, "unknown parameter 'nothing_like_it'. Known: matcher, ");
  EXPECT_FALSE(contains(unknown.output, "publish_tf")) << "only the node has it";
  expect_one_line(run_command(MATCHBOX_MAP_BAG, bag_ + " --out ''"), 2,
                  "'' is no name of a folder");
  expect_one_line(run_command(MATCHBOX_MAP_BAG, ""), 2, "--help");
  expect_one_line(run_command(MATCHBOX_MAP_BAG, bag_ + " --uot " + out_), 2,
                  "The following argument was not expected: --uot; did you mean --out? See --help");
  expect_one_line(run("--scan_topic /scan"), 2, "; did you mean --scan-topic? See --help");
  expect_one_line(run("--scan_topic=/scan"), 2, "; did you mean --scan-topic? See --help");
  expect_one_line(run("--frobnicate"), 2, "not expected: --frobnicate; see --help");
  expect_one_line(run_command(MATCHBOX_MAP_BAG, bag_), 2,
                  "give a folder for the map with --out, or a bag to write with --convert");
  const std::string package = read_file(std::string(MATCHBOX_SOURCE_DIR) + "/package.xml");
  const Outcome version = run_command(MATCHBOX_MAP_BAG, "--version");
  EXPECT_EQ(version.exit_code, 0);
  const std::string number = version.output.substr(std::string("map_bag of matchbox_slam ").size());
  EXPECT_TRUE(contains(package, "<version>" + number.substr(0, number.size() - 1) + "</version>"))
      << version.output;
  const Outcome help = run_command(MATCHBOX_MAP_BAG, "--help");
  EXPECT_EQ(help.exit_code, 0);
  for (const char* flag :
       {"--out", "--config", "--matcher", "--set", "--scan-topic", "--base-frame", "--odom-frame",
        "--no-odom", "--odom-topic", "--laser-pose", "--start", "--duration", "--seed", "--threads",
        "--quiet", "--convert", "--movie"}) {
    EXPECT_TRUE(contains(help.output, flag)) << flag;
  }
}

TEST_F(MapBag, MapsOnWhenNobodyReadsWhatItSays) {
  write_small_bag(bag_);
  const Outcome outcome =
      run_command("/bin/sh", "-c '{ " + std::string(MATCHBOX_MAP_BAG) + " " + bag_ + " --out " +
                                 out_ + "; echo exit $? >&2; } | true'");
  EXPECT_EQ(outcome.output, "exit 0\n");
  EXPECT_EQ(poses(), 50U);
}

TEST_F(MapBag, EventsComeBetweenTheScansThatTheyName) {
  write_small_bag(bag_, {});
  ASSERT_EQ(run("").exit_code, 0);
  const Trajectory plain = read_tum(out_ + "/trajectory.tum");
  const auto stamp = [&](std::size_t number) {
    return std::to_string(plain.poses().at(number).stamp - 1e-4);
  };
  const std::string events = folder_ / "events.yaml";
  replace_file(events, "- {scan: " + stamp(5) + ", reset: true}\n" + "- {scan: " + stamp(10) +
                           ", pause: true}\n" + "- {scan: " + stamp(13) + ", pause: false}\n" +
                           "- {scan: " + stamp(20) + ", reconfigure: {matcher: odometry_only}}\n" +
                           "- {scan: 1e10, reset: true}\n");
  const Outcome outcome = run("--events " + events);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "1 events have no scan after them and took no effect"))
      << outcome.output;
  EXPECT_EQ(report("scans/skipped/before_reset"), 5.0);
  EXPECT_EQ(report("scans/skipped/paused"), 3.0);
  EXPECT_EQ(report("scans/used"), 42.0);
  EXPECT_EQ(report("resets"), 1.0);
  const Trajectory trajectory = read_tum(out_ + "/trajectory.tum");
  ASSERT_EQ(trajectory.size(), 42U);
  EXPECT_EQ(trajectory.poses()[0].stamp, plain.poses()[5].stamp);
  EXPECT_EQ(trajectory.poses()[0].pose.x, 0.0);
  EXPECT_EQ(trajectory.poses()[5].stamp, plain.poses()[13].stamp);
  EXPECT_EQ(nlohmann::json::parse(read_file(out_ + "/report.json")).at("matcher"),
            "matchbox_slam/OdometryOnly");
}

TEST_F(MapBag, EventsBeforeTheFirstScanComeAfterTheSavedMap) {
  const std::string options = "--matcher odometry_only";
  ASSERT_EQ(run_small({}, options).exit_code, 0);
  const std::string old = folder_ / "old.slam";
  std::filesystem::copy_file(out_ + "/map.slam", old);
  const std::string events = folder_ / "events.yaml";
  replace_file(events,
               "- {scan: 1.0, set_pose: {x: 7.0, y: 2.0, theta: 0.0, "
               "covariance: [0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1]}}\n");
  const Outcome outcome = run(options + " --map " + old + " --events " + events);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "going on with")) << outcome.output;
  EXPECT_EQ(read_tum(out_ + "/trajectory.tum").poses().front().pose.x, 7.0);
}

TEST_F(MapBag, APoseToldIsAnEventBeforeTheFirstScan) {
  ASSERT_EQ(run_small({}).exit_code, 0);
  const std::string old = folder_ / "old.slam";
  std::filesystem::copy_file(out_ + "/map.slam", old);
  SmallBag other;
  other.begin = 2000.0;
  const auto results = [&](const std::string& told) {
    const Outcome outcome = run_small(other, "--map " + old + " " + told);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "; where the robot is in it has been told"))
        << outcome.output;
    std::vector<std::string> files;
    for (const std::string file : {"trajectory.tum", "scans.csv", "map.slam", "map.pgm"}) {
      files.push_back(read_file(out_ + "/" + file));
    }
    return files;
  };
  const std::string events = folder_ / "events.yaml";
  const Pose2 told{-0.1, 0.05, 0.03};
  replace_file(events, to_events_file({{{0, 1.0, 0}, SetPose{told, covariance_of(0.3, 0.2)}}}));
  const std::vector<std::string> by_event = results("--events " + events);
  EXPECT_EQ(report("scans/state/tracking"), 50.0);
  EXPECT_EQ(report("scans/maps_apart"), 0.0);
  EXPECT_TRUE(results("--pose -0.1,0.05,0.03") == by_event);
  // An event before the first scan comes after it.
  replace_file(events, "- {scan: 1.0, pause: true}\n- {scan: 2000.5, pause: false}\n");
  results("--pose -0.1,0.05,0.03 --events " + events);
  EXPECT_NEAR(read_tum(out_ + "/trajectory.tum").poses().front().pose.y, 0.0, 0.02);
  std::filesystem::remove_all(out_);
  for (const std::string text : {"1,2", "1,2,3,4", "1,2,east", "2e8,0,0", "''"}) {
    SCOPED_TRACE(text);
    expect_one_line(run("--map " + old + " --pose " + text), 2,
                    "allowed: X,Y,THETA in metres and radians");
  }
  expect_one_line(run("--pose 1,2,3"), 2, "--pose requires --map");
}

TEST_F(MapBag, RefusesEventsThatMakeNoSense) {
  write_small_bag(bag_, {});
  const std::string events = folder_ / "events.yaml";
  replace_file(events, "- {scan: 1.0, reset: true}\n- {scan: 2.0, paus: true}\n");
  expect_one_line(run("--events " + events), 2, events + ":2: unknown parameter 'paus'");
  expect_one_line(run("--events " + (folder_ / "nowhere.yaml")), 2, "nowhere.yaml");
}

TEST_F(MapBag, AnInterruptEndsItInGoodOrder) {
  SmallBag recipe;
  recipe.scans = 100000;  // which take some five seconds
  write_small_bag(bag_, recipe);
  for (const char* signal : {"INT", "TERM"}) {
    const Outcome outcome = run_command(
        "/bin/sh", std::string("-c '\"$@\" & pid=$!; sleep 1; kill -") + signal +
                       " $pid; wait $pid' sh " + MATCHBOX_MAP_BAG + " " + bag_ + " --out " + out_);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, "interrupted")) << outcome.output;
    EXPECT_GT(poses(), 0U);
    EXPECT_LT(poses(), 100000U);
  }
}

/// As its last line says.
TEST_F(MapBag, AnInterruptedRunIsGoneOnWithWhereItEnded) {
  SmallBag recipe;
  recipe.scans = 100000;  // which take some five seconds
  write_small_bag(bag_, recipe);
  const Outcome outcome = run_command(
      "/bin/sh", std::string("-c '\"$@\" & pid=$!; sleep 1; kill -INT $pid; wait $pid' sh ") +
                     MATCHBOX_MAP_BAG + " " + bag_ + " --out " + out_);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const std::size_t at = outcome.output.find("--start ");
  ASSERT_NE(at, std::string::npos) << outcome.output;
  const std::string arguments = outcome.output.substr(at);
  const std::size_t covered = poses();
  const Outcome rest = run("--overwrite " + arguments.substr(0, arguments.find('\n')));
  ASSERT_EQ(rest.exit_code, 0) << rest.output;
  EXPECT_TRUE(contains(rest.output, "map.slam, whose drive goes on")) << rest.output;
  EXPECT_EQ(covered + poses(), recipe.scans);
}

TEST_F(MapBag, AnInterruptBeforeTheFirstScanWritesNothing) {
  write_small_bag(bag_);
  const Outcome outcome = run_interrupted(MATCHBOX_MAP_BAG, bag_ + " --out " + out_);
  expect_one_line(outcome, 0, "interrupted before the first scan was used; nothing is written");
  EXPECT_TRUE(std::filesystem::is_empty(out_));
}

}  // namespace
}  // namespace matchbox_slam
