// Of tools/simulate_main.cpp: simulate as a user runs it.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

Outcome run_simulate(const std::string& arguments) {
  return run_command(MATCHBOX_SIMULATE, arguments);
}

class Simulate : public testing::Test {
 protected:
  /// The arguments of a short run whose files have this name.
  [[nodiscard]] std::string arguments(const std::string& name) const {
    return "--world rooms --duration 3 --beams 60 --bag " + (folder_ / (name + ".bag")) +
           " --truth " + (folder_ / (name + ".tum"));
  }

  void expect_one_line(int exit_code, const std::string& command_line, const std::string& word) {
    const Outcome outcome = run_simulate(command_line);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, word)) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
  }

  TemporaryFolder folder_;
};

TEST_F(Simulate, WritesBagAndTruthOfEveryScan) {
  const Outcome outcome = run_simulate(arguments("run"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "61 scans")) << outcome.output;
  EXPECT_GT(std::filesystem::file_size(folder_ / "run.bag"), 10000U);
  const Trajectory truth = read_tum(folder_ / "run.tum");
  ASSERT_EQ(truth.size(), 61U);
  EXPECT_EQ(truth.poses().front().stamp, 1327500000.0);
}

TEST_F(Simulate, HasASecondLaserThatTfHasElsewhere) {
  ASSERT_EQ(run_simulate(arguments("run") +
                         " --second-laser=-0.3,0.1,3.1 --second-laser-error=0.03,0,0.02")
                .exit_code,
            0);
  const Outcome mapped =
      run_command(MATCHBOX_MAP_BAG, (folder_ / "run.bag") + " --out " + folder_.path() +
                                        " --set 'scan_topics=[/base_scan, /second_scan]'");
  EXPECT_EQ(mapped.exit_code, 0) << mapped.output;
  EXPECT_TRUE(contains(mapped.output, "122 of 122 scans used, 60 matched")) << mapped.output;
  EXPECT_TRUE(contains(mapped.output, "the laser of /second_scan")) << mapped.output;
  expect_one_line(2, arguments("b") + " --second-laser-error 0,0,0", "--second-laser");
}

TEST_F(Simulate, TheSameSeedWritesTheSameBytes) {
  for (const char* name : {"a", "b"}) {
    EXPECT_EQ(run_simulate(arguments(name) + " --seed 5").exit_code, 0);
  }
  EXPECT_EQ(run_simulate(arguments("c") + " --seed 6").exit_code, 0);
  EXPECT_EQ(read_file(folder_ / "a.bag"), read_file(folder_ / "b.bag"));
  EXPECT_EQ(read_file(folder_ / "a.tum"), read_file(folder_ / "b.tum"));
  EXPECT_NE(read_file(folder_ / "a.bag"), read_file(folder_ / "c.bag"));
}

TEST_F(Simulate, ChangesTheWorldFromOneDayToAnother) {
  const Outcome outcome = run_simulate(arguments("day") + " --moved 0.5 --walls 1");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "81 things moved, 0 taken, 1 walls built"))
      << outcome.output;
  ASSERT_EQ(run_simulate(arguments("before")).exit_code, 0);
  EXPECT_EQ(read_file(folder_ / "day.tum"), read_file(folder_ / "before.tum"));
  EXPECT_NE(read_file(folder_ / "day.bag"), read_file(folder_ / "before.bag"));
  expect_one_line(2, arguments("b") + " --moved 1.5", "moved");
}

TEST_F(Simulate, TakesTheOptionsOfTheSimulation) {
  const Outcome outcome = run_simulate(
      arguments("run") +
      " --range-noise 0 --dropout 0 --scan-rate 10 --time-increment 0.0001 --mount-yaw -0.5"
      " --inverted-laser --no-odometry --compression lz4 --clock-offset -2 --leading-slashes");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  const Trajectory truth = read_tum(folder_ / "run.tum");
  ASSERT_EQ(truth.size(), 31U);
  EXPECT_EQ(truth.poses().front().stamp, 1327500002.0);
}

TEST_F(Simulate, SensorAndOdometryAreSetByNameAndOverriddenByOptions) {
  const auto scans = [&](const std::string& options) {
    const Outcome outcome = run_simulate(arguments("run") + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    return read_tum(folder_ / "run.tum").size();
  };
  EXPECT_EQ(scans(" --sensor ranger32 --odometry perfect"), 31U);
  EXPECT_EQ(scans(" --sensor ranger32 --scan-rate 20"), 61U);
  EXPECT_EQ(scans(" --sensor in_parts --odometry awful"), 310U);
  EXPECT_EQ(scans(" --sensor lds01_as_sent --scan-rate 0.5 --odometry bad"), 3U);
  expect_one_line(2, arguments("run") + " --sensor sick", "one of utm30, sick180");
  expect_one_line(2, arguments("run") + " --odometry worse", "one of perfect, good, bad, awful");
}

TEST_F(Simulate, Utm30AndGoodOdometryAreWhatItHasWithoutThem) {
  ASSERT_EQ(run_simulate(arguments("a")).exit_code, 0);
  ASSERT_EQ(run_simulate(arguments("b") + " --sensor utm30 --odometry good").exit_code, 0);
  EXPECT_EQ(read_file(folder_ / "a.bag"), read_file(folder_ / "b.bag"));
  ASSERT_EQ(run_simulate(arguments("b") + " --odometry bad").exit_code, 0);
  EXPECT_NE(read_file(folder_ / "a.bag"), read_file(folder_ / "b.bag"));
}

TEST_F(Simulate, WithOdometryNoneThereIsNone) {
  ASSERT_EQ(run_simulate(arguments("a") + " --odometry none").exit_code, 0);
  ASSERT_EQ(run_simulate(arguments("b") + " --no-odometry").exit_code, 0);
  EXPECT_EQ(read_file(folder_ / "a.bag"), read_file(folder_ / "b.bag"));
  const Outcome mapped =
      run_command(MATCHBOX_MAP_BAG, (folder_ / "a.bag") + " --no-odom --out " + folder_.path());
  EXPECT_EQ(mapped.exit_code, 0) << mapped.output;
}

TEST_F(Simulate, TakesFaults) {
  const Outcome outcome =
      run_simulate(arguments("run") + " --fault dropout:1:1 --fault freeze:random:0.5");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(read_tum(folder_ / "run.tum").size(), 41U);
  expect_one_line(2, arguments("run") + " --fault slip:1", "heading_slip");
}

TEST_F(Simulate, DrivesTheWayTwice) {
  const std::string quick = "--world rooms --beams 60 --scan-rate 2 --speed 1.5 --no-odometry";
  const auto scans = [&](const std::string& name) {
    const Outcome outcome =
        run_simulate(quick + " --bag " + (folder_ / (name + ".bag")) + " --truth " +
                     (folder_ / (name + ".tum")) + (name == "once" ? "" : " --laps 2"));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    return static_cast<double>(read_tum(folder_ / (name + ".tum")).size());
  };
  const double once = scans("once");
  EXPECT_NEAR(scans("twice") / once, 2.0, 0.1);
  expect_one_line(2, arguments("run") + " --laps 0", "laps: 0 is not allowed; allowed: 1 to 1000");
  EXPECT_TRUE(contains(run_simulate("--help").output, "--laps"));
}

TEST_F(Simulate, HelpListsTheOptionsWithDefaultAndUnit) {
  const Outcome outcome = run_simulate("--help");
  EXPECT_EQ(outcome.exit_code, 0);
  for (const char* text :
       {"--range-noise", "--heading-bias", "--speed", "[rad/m]", "default 1040"}) {
    EXPECT_TRUE(contains(outcome.output, text)) << text;
  }
}

TEST_F(Simulate, WrongUsageIsOneLineAndTwo) {
  expect_one_line(2, "--world rooms", "--bag");
  expect_one_line(2, "--world room --bag a.bag --truth a.tum", "rooms, random, corridor, loop");
  expect_one_line(2, arguments("run") + " --range-noise -1", "range_noise");
  expect_one_line(2, arguments("run") + " --beams many", "beams");
  expect_one_line(2, arguments("run") + " --seed -1",
                  "--seed: -1 is not allowed; allowed: at least 0\n");
  expect_one_line(2,
                  "--world rooms --bag " + (folder_ / "same") + " --truth " + (folder_ / "./same"),
                  "--bag and --truth name the same file");
  expect_one_line(2, arguments("run") + " --compression zip", "one of none, bz2, lz4");
  expect_one_line(2, arguments("run") + " --colour red", "--colour");
  expect_one_line(2, arguments("run") + " --moved 0.7 --taken 0.5", "allowed: 1 together");
  expect_one_line(2, arguments("run") + " --time-increment 0.5", "time_increment");
  expect_one_line(2, arguments("run") + " --inverted-laser --mount-roll 1", "--mount-roll");
}

TEST_F(Simulate, AnOutputThatCannotBeWrittenIsOneLineAndOne) {
  std::filesystem::create_directory(folder_ / "run.bag");
  expect_one_line(1, arguments("run"), "run.bag");
  std::filesystem::create_directory(folder_ / "other.tum");
  expect_one_line(1, arguments("other"), "other.tum");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "other.bag"));
}

TEST_F(Simulate, AnInterruptLeavesNothing) {
  const Outcome outcome = run_interrupted(MATCHBOX_SIMULATE, arguments("run"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(outcome.output, "simulate: interrupted; nothing is written\n");
  EXPECT_EQ(folder_.file_count(), 0U);
}

TEST_F(Simulate, AFullDiskIsOneLineAndLeavesWhatWasThere) {
  ASSERT_EQ(run_simulate(arguments("run")).exit_code, 0);
  const std::string bag = read_file(folder_ / "run.bag");
  const Outcome outcome = run_on_full_disk(MATCHBOX_SIMULATE, arguments("run") + " --seed 2");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "run.bag: the bag cannot be written")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "is the disk full?")) << outcome.output;
  EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
  EXPECT_TRUE(read_file(folder_ / "run.bag") == bag);
  EXPECT_EQ(folder_.file_count(), 2U);
}

}  // namespace
}  // namespace matchbox_slam
