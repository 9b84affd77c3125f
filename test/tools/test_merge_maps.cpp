// Of tools/map_merger.hpp: runs merge_maps as a user does.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "slam/maps_of_rooms.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

class MergeMapsProgram : public testing::Test {
 protected:
  MergeMapsProgram() { ::setenv("LC_ALL", "C", 1); }

  /// Of two drives that meet, and of another building.
  void write_maps(const EngineOptions& options_of_second = {}) {
    write(a_, map_of_way(3, 0, 45, {}));
    write(b_, map_of_way(3, 20, 65, {7.0, -3.0, 2.0}, options_of_second));
  }

  void write_other_building() { write(c_, map_of_way(4, 0, 8, {})); }

  static void write(const std::string& path, const EngineState& map) {
    replace_file(path, to_saved_map(map));
  }

  [[nodiscard]] Outcome run(const std::string& arguments) const {
    return run_command(MATCHBOX_MERGE_MAPS, arguments);
  }

  [[nodiscard]] Outcome merge(const std::string& maps) const {
    return run(maps + " --out " + out_);
  }

  void expect_refused(const Outcome& outcome, int exit_code, const std::string& words) const {
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, words)) << outcome.output;
    EXPECT_EQ(std::count(outcome.output.begin(), outcome.output.end(), '\n'), 1) << outcome.output;
    EXPECT_FALSE(std::filesystem::exists(out_));
  }

  TemporaryFolder folder_;
  std::string a_ = folder_ / "a.slam";
  std::string b_ = folder_ / "b.slam";
  std::string c_ = folder_ / "c.slam";
  std::string out_ = folder_ / "out";
};

TEST_F(MergeMapsProgram, MapsThatMeetBecomeOne) {
  write_maps();
  const std::string before = read_file(b_);
  const Outcome outcome = merge(a_ + " " + b_);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "map.slam: " + a_ + " and " + b_ + "; 90 key scans"))
      << outcome.output;
  EXPECT_EQ(read_saved_map(out_ + "/map.slam").key_scans.size(), 90U);
  EXPECT_GT(read_map(out_ + "/map.yaml").width, 100);
  EXPECT_EQ(read_file(out_ + "/map.png").substr(1, 3), "PNG");
  EXPECT_EQ(read_tum(out_ + "/trajectory_1.tum").size(), 45U);
  const Trajectory second = read_tum(out_ + "/trajectory_2.tum");
  ASSERT_EQ(second.size(), 45U);
  const Pose2 truth = way_through_rooms(3)[20];
  EXPECT_LE((second.poses().front().pose.translation() - truth.translation()).norm(), 0.02);
  EXPECT_FALSE(std::filesystem::exists(out_ + "/map_2.slam"));
  const auto report = nlohmann::json::parse(read_file(out_ + "/report.json"));
  EXPECT_EQ(report.at("maps").size(), 1U);
  EXPECT_EQ(report.at("inputs").at(1).at("map"), "map.slam");
  EXPECT_EQ(read_file(b_), before);
}

TEST_F(MergeMapsProgram, ADriveElsewhereIsAMapOfItsOwnAndAWarningTells) {
  write_maps();
  write_other_building();
  const Outcome outcome = merge(c_ + " " + a_ + " " + b_);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output,
                       a_ + " and " + b_ + " met " + c_ +
                           " nowhere: a map of its own, map_2.slam; to join them, let one robot"))
      << outcome.output;
  EXPECT_EQ(read_saved_map(out_ + "/map.slam").key_scans.size(), 8U);
  EXPECT_EQ(read_saved_map(out_ + "/map_2.slam").key_scans.size(), 90U);
  EXPECT_TRUE(std::filesystem::exists(out_ + "/map_2.yaml"));
  EXPECT_EQ(read_tum(out_ + "/trajectory_3.tum").size(), 45U);
}

TEST_F(MergeMapsProgram, WhatCannotBeMergedIsRefusedInOneLine) {
  write_maps();
  expect_refused(merge(a_ + " " + (folder_ / "none.slam")), 2, "none.slam");
  replace_file(c_, "this is no map");
  expect_refused(merge(a_ + " " + c_), 1, c_);
  const std::string whole = read_file(b_);
  replace_file(c_, whole.substr(0, whole.size() / 2));
  expect_refused(merge(a_ + " " + c_), 1, c_);
  EngineState image = map_of_way(3, 0, 5, {});
  image.is_of_key_scans = false;
  write(c_, image);
  expect_refused(merge(a_ + " " + c_), 1, c_ + ": holds walls of which there are no key scans");
  const EngineOptions options;
  write(c_, {SlamMap(options.map, options.field), {}, {}, {}});
  expect_refused(merge(a_ + " " + c_), 1, c_ + ": holds no key scans");
  expect_refused(merge(a_), 2, "give two or more");
  expect_refused(merge(a_ + " " + b_ + " " + a_), 2, a_ + " is given twice");
  expect_refused(merge(a_ + " " + b_ + " --set map/cells=1"), 2, "unknown parameter 'cells'");
  EXPECT_EQ(read_file(b_), whole);
}

TEST_F(MergeMapsProgram, AnInputIsNotWrittenOverUnasked) {
  write_maps();
  std::filesystem::create_directory(out_);
  const std::string held = out_ + "/map.slam";
  std::filesystem::copy_file(a_, held);
  const std::string before = read_file(held);
  const Outcome refused = merge(b_ + " " + held);
  EXPECT_EQ(refused.exit_code, 2) << refused.output;
  EXPECT_TRUE(contains(refused.output, "--overwrite")) << refused.output;
  EXPECT_EQ(read_file(held), before);
  const Outcome asked = merge("--overwrite " + b_ + " " + held);
  EXPECT_EQ(asked.exit_code, 0) << asked.output;
  EXPECT_EQ(read_saved_map(held).key_scans.size(), 90U);
}

TEST_F(MergeMapsProgram, AnInputThatHasTheNameOfAnotherResultIsNotWrittenOverEither) {
  write_maps();
  std::filesystem::create_directory(out_);
  const std::string held = out_ + "/map_7.slam";
  std::filesystem::copy_file(a_, held);
  const Outcome refused = merge(b_ + " " + held);
  EXPECT_EQ(refused.exit_code, 2) << refused.output;
  EXPECT_TRUE(contains(refused.output, "--overwrite")) << refused.output;
}

TEST_F(MergeMapsProgram, WhatAnEarlierMergeLeftGoesAside) {
  write_maps();
  write_other_building();
  ASSERT_EQ(merge(c_ + " " + a_ + " " + b_).exit_code, 0);
  const std::string left = read_file(out_ + "/map_2.slam");
  replace_file(out_ + "/map_9.slam", "of the user");
  const Outcome again = merge(a_ + " " + b_);
  ASSERT_EQ(again.exit_code, 0) << again.output;
  EXPECT_TRUE(contains(again.output, out_ + "/earlier")) << again.output;
  EXPECT_FALSE(std::filesystem::exists(out_ + "/map_2.slam"));
  EXPECT_FALSE(std::filesystem::exists(out_ + "/trajectory_3.tum"));
  EXPECT_EQ(read_file(out_ + "/earlier/map_2.slam"), left);
  EXPECT_EQ(read_file(out_ + "/map_9.slam"), "of the user");
}

TEST_F(MergeMapsProgram, SaysWhatToGiveInPlaceOfWhatIsNoMap) {
  write_maps();
  std::filesystem::create_directory(folder_ / "drive");
  expect_refused(merge(a_ + " " + (folder_ / "drive")), 2, "give the map in it, as");
  expect_refused(merge(a_ + " " + (folder_ / "drive.bag")), 2, "map_bag");
  expect_refused(merge(a_ + " " + (folder_ / "map.yaml")), 2, "give the .slam");
}

TEST_F(MergeMapsProgram, MapsOfOtherCellsAreDrawnInThoseOfTheFirst) {
  EngineOptions coarse;
  coarse.map.resolution = 0.1;
  write_maps(coarse);
  const Outcome outcome = merge(a_ + " " + b_);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, b_ + ": is drawn anew in cells of 0.05 m in place of 0.1 m"))
      << outcome.output;
  EXPECT_EQ(read_map(out_ + "/map.yaml").resolution, 0.05);
}

TEST_F(MergeMapsProgram, HalvesOfABuildingWithARailingMeetWhereTheyShareScans) {
  // At the right place 11.5 % of the key scans see through walls, as half of the beams pass.
  const char* given = std::getenv("MATCHBOX_DATA");
  const std::string bag = (given != nullptr ? given : MATCHBOX_SOURCE_DIR "/../shared/data") +
                          std::string("/csail.bag");
  if (!std::filesystem::exists(bag)) {
    GTEST_SKIP() << "SKIPPED: there is no " << bag
                 << "; set MATCHBOX_DATA to the folder with the real recordings";
  }
  for (const std::string& part : {"--duration 270 --out " + (folder_ / "first"),
                                  "--start 136 --out " + (folder_ / "second")}) {
    ASSERT_EQ(run_command(MATCHBOX_MAP_BAG, bag + " --quiet " + part).exit_code, 0);
  }
  const Outcome outcome = merge((folder_ / "first/map.slam") + " " + (folder_ / "second/map.slam"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_FALSE(std::filesystem::exists(out_ + "/map_2.slam")) << outcome.output;
  const std::vector<StampedPose2> first = read_tum(out_ + "/trajectory_1.tum").poses();
  const Trajectory all_second = read_tum(out_ + "/trajectory_2.tum");
  std::size_t shared = 0;
  for (const StampedPose2& second : all_second.poses()) {
    for (const StampedPose2& pose : first) {
      if (pose.stamp == second.stamp) {
        ++shared;
        EXPECT_LE((pose.pose.translation() - second.pose.translation()).norm(), 0.05);
      }
    }
  }
  EXPECT_GE(shared, 120U);
}

TEST_F(MergeMapsProgram, InterruptedItWritesNothing) {
  write_maps();
  const Outcome outcome = run_interrupted(MATCHBOX_MERGE_MAPS, a_ + " " + b_ + " --out " + out_);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "2 maps were searched in each other; nothing was written"))
      << outcome.output;
  EXPECT_FALSE(std::filesystem::exists(out_));
}

}  // namespace
}  // namespace matchbox_slam
