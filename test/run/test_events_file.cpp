#include <gtest/gtest.h>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "ros/message_conversion.hpp"
#include "ros/messages.hpp"
#include "run/events_file.hpp"
#include "run/slam_run.hpp"

namespace matchbox_slam {
namespace {

class EventsFile : public testing::Test {
 protected:
  [[nodiscard]] std::vector<TimedEvent> read(const std::string& text) const {
    replace_file(path_, text);
    return read_events_file(path_, LiveConfiguration({}, loader_));
  }

  /// What it complains of, after the file's name.
  [[nodiscard]] std::string refusal_of(const std::string& text) const {
    const std::string error = error_text<ConfigurationError>([&] { (void)read(text); });
    EXPECT_EQ(error.rfind(path_, 0), 0U) << error;
    return error.substr(path_.size());
  }

  MatcherLoader loader_;
  TemporaryFolder folder_;
  std::string path_ = folder_ / "events.yaml";
};

TEST_F(EventsFile, ReadsBackWhatWasWritten) {
  SlamRun run{LiveConfiguration({}, loader_)};
  ScanInput scan;
  scan.scan = to_laser_scan(make_scan(1.0));
  (void)run.process(scan);
  EngineState map = run.snapshot();
  map.begin_anew({1.0, 2.0, 0.5}, map.motion.covariance);
  replace_file(folder_ / "a map.slam", to_saved_map(map));
  Eigen::Matrix3d covariance = Eigen::Vector3d(0.1, 0.2, 1.0 / 3.0).asDiagonal();
  covariance(0, 1) = covariance(1, 0) = 0.01;
  Parameters changes;
  changes.set("matcher", "hough");
  changes.set("hough/peaks", 5);
  changes.set("slam/insert_distance", 0.1 + 0.2);
  changes.set("map_file", "1e3");  // a text that looks like a number
  const double stamp = 1353943200.123456789;
  const std::vector<TimedEvent> events = {
      {{0, stamp, 1}, SetPose{{1.0 / 3.0, -2e-9, 3.0}, covariance}},
      {{0, stamp, 0}, CorrectPose{stamp - 0.1, {0.1, 0.7, -0.3}}},
      {{0, stamp + 1.0, 0}, Pause{true}},
      {{0, stamp + 2.0, 0}, Pause{false}},
      {{0, stamp + 2.0, 0}, Reconfigure{changes}},
      {{0, stamp + 3.0, 0}, LoadMapFile{folder_ / "a map.slam", nullptr}},
      {{0, stamp + 4.0, 1}, LeaveOut{}},
      {{2, 3.0, 0}, Reset{}},
      {{2, 3.0, 0}, BeAnywhere{}}};
  const std::vector<TimedEvent> back = read(to_events_file(events));
  ASSERT_EQ(back.size(), events.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_FALSE(back[i].scan < events[i].scan || events[i].scan < back[i].scan) << i;
    EXPECT_EQ(back[i].event.index(), events[i].event.index()) << i;
  }
  const auto& told = std::get<SetPose>(back[0].event);
  EXPECT_EQ(told.map_from_base.x, 1.0 / 3.0);
  EXPECT_EQ(told.map_from_base.y, -2e-9);
  EXPECT_EQ(told.map_from_base.theta, 3.0);
  EXPECT_EQ(told.covariance, covariance);
  const auto& corrected = std::get<CorrectPose>(back[1].event);
  EXPECT_EQ(corrected.stamp, stamp - 0.1);
  EXPECT_EQ(corrected.map_from_base.theta, -0.3);
  EXPECT_TRUE(std::get<Pause>(back[2].event).paused);
  EXPECT_FALSE(std::get<Pause>(back[3].event).paused);
  EXPECT_EQ(std::get<Reconfigure>(back[4].event).changes.values(), changes.values());
  EXPECT_EQ(std::get<LoadMapFile>(back[5].event).map->motion.fixed_from_base.y, 2.0);
}

TEST_F(EventsFile, EachKeyIsInTheDocumentation) {
  Parameters changes;
  changes.set("matcher", "hough");
  replace_file(path_, to_events_file({{{1, 2.0, 1}, SetPose{{}, Eigen::Matrix3d::Identity()}},
                                      {{1, 2.0, 1}, CorrectPose{1.0, {}}},
                                      {{1, 2.0, 1}, Pause{true}},
                                      {{1, 2.0, 1}, Reconfigure{changes}},
                                      {{1, 2.0, 1}, LoadMapFile{"map.slam", nullptr}},
                                      {{1, 2.0, 1}, LeaveOut{}},
                                      {{1, 2.0, 1}, Reset{}},
                                      {{1, 2.0, 1}, BeAnywhere{}}}));
  const std::string page = read_file(std::string(MATCHBOX_SOURCE_DIR) + "/doc/node.md");
  const std::size_t begin = page.find("## Repeating a run");
  const std::string table = page.substr(begin, page.find("\n## ", begin) - begin);
  for (const ParameterEntry& entry : read_yaml_list(path_)) {
    for (const auto& [name, value] : entry.parameters.values()) {
      for (const std::string& key : split(name, '/')) {
        EXPECT_TRUE(name.rfind("reconfigure/", 0) == 0 || contains(table, "`" + key + "`")) << key;
      }
    }
  }
  EXPECT_TRUE(contains(table, "`reconfigure`"));
}

TEST_F(EventsFile, AnAngleMayHaveWholeTurns) {
  const std::vector<TimedEvent> events =
      read("- {scan: 2.0, correct_pose: {scan: 1.0, x: 0, y: 0, theta: 6.5}}");
  EXPECT_EQ(std::get<CorrectPose>(events.front().event).map_from_base.theta, wrap_angle(6.5));
}

TEST_F(EventsFile, NoEventsAreAnEmptyList) { EXPECT_TRUE(read(to_events_file({})).empty()); }

TEST_F(EventsFile, SaysWhatIsWrongAndWhere) {
  const std::string pose = "x: 1, y: 2, theta: 3";
  const std::string first = "- {scan: 1.0, reset: true}\n";
  EXPECT_EQ(refusal_of("reset: true"), ":1: has to be a list, each entry after a '-'");
  EXPECT_EQ(refusal_of(first + "- reset"), ":2: has to be a map of names to values");
  EXPECT_EQ(refusal_of(first + "- {reset: true}"),
            ":2: scan is missing: the stamp of the scan before which the event comes");
  EXPECT_EQ(refusal_of(first + "- {scan: 0.5, reset: true}"),
            ":2: scan: the entry before comes later; they have to be in order");
  EXPECT_EQ(
      refusal_of("- {scan: 1.0}"),
      ":1: an entry has to give one of set_pose, correct_pose, be_anywhere, reset, load, pause, "
      "reconfigure, leave_out; it gives none");
  EXPECT_TRUE(
      contains(refusal_of("- {scan: 1.0, reset: true, pause: true}"), "it gives reset, pause"));
  EXPECT_TRUE(contains(refusal_of("- {scan: .inf, reset: true}"), ":1: scan: "));
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, reste: true}"), "did you mean 'reset'?"));
  EXPECT_EQ(refusal_of("- {scan: 1.0, set_poze: {" + pose + "}}"),
            ":1: unknown parameter 'set_poze'; did you mean 'set_pose'? Known: scan, laser, "
            "time_jumps, set_pose, correct_pose, be_anywhere, reset, load, pause, reconfigure, "
            "leave_out.");
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, reset: {all: true}}"), "'reset/all'"));
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, reset: false}"), ":1: reset: false"));
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, pause: 2}"), ":1: pause: "));
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, set_pose: 2}"),
                       ":1: set_pose: has to be a map of names to values"));
  EXPECT_EQ(refusal_of("- {scan: 1.0, set_pose: {" + pose + "}}"),
            ":1: set_pose/covariance is missing");
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, set_pose: {" + pose +
                                  ", covariance: [1, 0, 0, 0, -1, 0, 0, 0, 1]}}"),
                       ":1: set_pose/covariance is none"));
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, correct_pose: {" + pose + "}}"),
                       ":1: correct_pose/scan is missing"));
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, load: /nowhere.slam}"), ":1: cannot read"));
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, reconfigure: {hough/peaks: 7}}"),
                       ":1: hough/peaks: 7 is not allowed; allowed: 1 to 6"));
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, reconfigure: {base_frame: x}}"),
                       ":1: base_frame: cannot be changed while running"));
  EXPECT_TRUE(contains(refusal_of("- {scan: 1.0, reset: true"), "not YAML"));
}

}  // namespace
}  // namespace matchbox_slam
