#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "run/map_saver.hpp"
#include "slam/lost_robot.hpp"

namespace matchbox_slam {
namespace {

/// A run through rooms whose map is saved now and then.
class Saver : public testing::Test {
 protected:
  void drive(std::size_t scans) {
    for (const std::size_t end = next_ + scans; next_ < end; ++next_) {
      (void)run_.process(scan_input(drive_, next_));
    }
  }

  [[nodiscard]] std::size_t key_scans_of(const std::string& file) const {
    return read_engine_state(file, {}).key_scans.size();
  }

  TemporaryFolder folder_;
  const std::string path_ = folder_ / "map";
  const std::string file_ = path_ + ".slam";
  const std::string changes_ = path_of_changes(file_);
  const SimulatedRun drive_ = perfect_drive();
  std::size_t next_ = 0;
  MatcherLoader loader_;
  SlamRun run_{LiveConfiguration(parse_yaml_parameters("map_file: " + path_, "test"), loader_)};
  MapSaver saver_;
};

TEST_F(Saver, SavesNothingBeforeAScanWasMapped) {
  EXPECT_TRUE(saver_.is_saved(revision_of(run_)));
  EXPECT_TRUE(contains(error_text<std::runtime_error>([&] { (void)map_to_save(run_); }),
                       "no scan was mapped yet"));
}

TEST_F(Saver, SavesTheWholeAndKnowsThat) {
  drive(60);
  EXPECT_FALSE(saver_.is_saved(revision_of(run_)));
  EXPECT_EQ(saver_.unsaved_scans(revision_of(run_)), 60U);
  EXPECT_EQ(saver_.save(map_to_save(run_)), path_ + ".pgm, .yaml, .png and .slam");
  EXPECT_TRUE(saver_.is_saved(revision_of(run_)));
  for (const char* end : {".pgm", ".yaml", ".png", ".slam"}) {
    EXPECT_TRUE(std::filesystem::exists(path_ + end)) << end;
  }
  EXPECT_EQ(key_scans_of(file_), run_.key_scans().size());
  EXPECT_EQ(saver_.unsaved_scans(revision_of(run_)), 0U);
  drive(1);
  EXPECT_FALSE(saver_.is_saved(revision_of(run_)));
  EXPECT_EQ(saver_.unsaved_scans(revision_of(run_)), 1U);
}

TEST_F(Saver, WritesChangesBesideTheWholeUntilTheyAreAsLarge) {
  drive(60);
  saver_.save_changes(map_to_save(run_));
  EXPECT_FALSE(std::filesystem::exists(changes_)) << "the first is a whole";
  drive(20);
  const auto whole = std::filesystem::last_write_time(file_);
  saver_.save_changes(map_to_save(run_));
  EXPECT_TRUE(std::filesystem::exists(changes_));
  EXPECT_EQ(std::filesystem::last_write_time(file_), whole);
  EXPECT_TRUE(saver_.is_saved(revision_of(run_)));
  EXPECT_EQ(key_scans_of(file_), run_.key_scans().size());
  std::size_t changes = 1;
  while (std::filesystem::exists(changes_) && changes < 100) {
    saver_.save_changes(map_to_save(run_));
    ++changes;
  }
  EXPECT_LT(changes, 100U) << "a whole was due";
  EXPECT_EQ(key_scans_of(file_), run_.key_scans().size());
}

TEST_F(Saver, WritesTheWholeWhereSomebodyHasTouchedTheFile) {
  drive(60);
  (void)saver_.save(map_to_save(run_));
  std::filesystem::remove(file_);
  drive(10);
  saver_.save_changes(map_to_save(run_));
  EXPECT_FALSE(std::filesystem::exists(changes_));
  EXPECT_EQ(key_scans_of(file_), run_.key_scans().size());
}

TEST_F(Saver, KeepsAMapThatItDidNotGoOnFrom) {
  drive(60);
  (void)saver_.save(map_to_save(run_));
  const std::size_t before = run_.key_scans().size();
  drive(20);
  (void)saver_.save(map_to_save(run_));
  EXPECT_FALSE(std::filesystem::exists(file_ + ".1")) << "it went on from there";
  const std::size_t old = run_.key_scans().size();
  ASSERT_GT(old, before);
  run_.apply(Reset{});
  drive(5);
  (void)saver_.save(map_to_save(run_));
  EXPECT_EQ(key_scans_of(file_ + ".1"), old);
  EXPECT_LT(key_scans_of(file_), old);
}

TEST_F(Saver, DrawsNoWayOfALostRobotOverTheMap) {
  drive(60);
  run_.begin_drive(drive_.scans[next_].stamp);
  drive(1);
  ASSERT_FALSE(run_.is_in_map(drive_.scans[next_ - 1].stamp));
  const MapToSave now = map_to_save(run_);
  for (const Trajectory* drawn : {&now.trajectory, &now.odometry}) {
    ASSERT_FALSE(drawn->empty());
    EXPECT_TRUE(run_.is_in_map(drawn->poses().back().stamp));
  }
}

TEST_F(Saver, KeepsNoMapThatItHasBegunFrom) {
  drive(60);
  (void)saver_.save(map_to_save(run_));
  MapSaver next;
  next.begin_from(file_, revision_of(run_));
  drive(5);
  (void)next.save(map_to_save(run_));
  EXPECT_FALSE(std::filesystem::exists(file_ + ".1"));
  MapSaver stranger;
  drive(5);
  (void)stranger.save(map_to_save(run_));
  EXPECT_TRUE(std::filesystem::exists(file_ + ".1"));
}

TEST_F(Saver, SaysWhatStandsInItsWayAndTriesAgain) {
  drive(60);
  std::filesystem::create_directory(changes_);
  replace_file(changes_ + "/of_somebody", "");
  EXPECT_EQ(error_text<FileError>([&] { saver_.save_changes(map_to_save(run_)); }),
            "the map cannot be saved ('" + changes_ + "'): Directory not empty");
  EXPECT_FALSE(saver_.is_saved(revision_of(run_)));
  std::filesystem::remove_all(changes_);
  saver_.save_changes(map_to_save(run_));
  EXPECT_TRUE(saver_.is_saved(revision_of(run_)));
  EXPECT_FALSE(std::filesystem::exists(file_ + ".1")) << "what it has written is its own";
  EXPECT_EQ(key_scans_of(file_), run_.key_scans().size());
}

}  // namespace
}  // namespace matchbox_slam
