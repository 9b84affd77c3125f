// Of tools/bag_mapper.hpp: runs map_bag as a user does: its outputs, and what it says of the
// mapping.

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "common/error_text.hpp"
#include "evaluation/absolute_trajectory_error.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/geometry/pose_covariance.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "ros/messages.hpp"
#include "ros/scan_types.hpp"
#include "run/events_file.hpp"
#include "tools/bag_mapper.hpp"
#include "tools/map_bag_run.hpp"
#include "tools/run_command.hpp"

namespace matchbox_slam {
namespace {

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

TEST_F(MapBag, TellsWhatIsLeftOfWhatWasAskedForAfterAnInterruption) {
  ASSERT_EQ(run_small({}, "--start 1 --duration 3").exit_code, 0);
  const std::size_t all = poses();
  MapBagRequest request;
  request.recording.bags = {bag_};
  request.recording.period = {1.0, 3.0};
  request.out = out_;
  std::string told;
  bool is_interrupted = false;
  map_bag(request, {[](const std::string& /*line*/) {},
                    [&](const std::string& line) { told += line + "\n"; },
                    [&](double fraction, const std::string& /*text*/) {
                      is_interrupted = is_interrupted || fraction > 0.3;
                    },
                    [&] { return is_interrupted; }});
  const std::size_t first = poses();
  ASSERT_LT(first, all);
  const std::size_t rest = told.find("--start ");
  ASSERT_NE(rest, std::string::npos) << told;
  const std::string first_map = out_ + "/map.slam";
  out_ = folder_ / "rest";
  const Outcome outcome =
      run(told.substr(rest, told.find(" --map ") - rest) + " --map " + first_map);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(first + poses(), all) << told;
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

/// Names of values, and those of the values in them, but for those that are counts by name.
std::set<std::string> keys_of(const nlohmann::json& values) {
  static const std::set<std::string> kByName = {"skipped", "matches",  "certainty",
                                                "state",   "by_state", "configuration"};
  std::set<std::string> keys;
  for (const auto& [key, value] : values.items()) {
    if (values.is_object()) {
      keys.insert(key);
    }
    if (value.is_structured() && kByName.count(key) == 0) {
      keys.merge(keys_of(value));
    }
  }
  return keys;
}

TEST_F(MapBag, EachKeyOfItsReportIsInTheDocumentation) {
  ASSERT_EQ(run_command(MATCHBOX_SIMULATE,
                        "--world loop --seed 2 --duration 200 --scan-rate 5 --beams 261 "
                        "--second-laser -0.3,0,3.14 --bag " +
                            bag_ + " --truth " + (folder_ / "truth.tum"))
                .exit_code,
            0);
  ASSERT_EQ(run("--scan-topic /base_scan --scan-topic /second_scan").exit_code, 0);
  const auto report = nlohmann::json::parse(read_file(out_ + "/report.json"));
  EXPECT_FALSE(report.at("loops").at("each").empty());
  EXPECT_FALSE(report.at("further_lasers").empty());
  const std::string page = read_file(std::string(MATCHBOX_SOURCE_DIR) + "/doc/first_map.md");
  const std::size_t begin = page.find("What is in `report.json`");
  ASSERT_NE(begin, std::string::npos);
  const std::string table = page.substr(begin, page.find("`--movie map.gif`") - begin);
  for (const std::string& key : keys_of(report)) {
    EXPECT_TRUE(contains(table, "`" + key + "`")) << key;
  }
}

TEST_F(MapBag, WhatAnEarlierRunLeftIsNotTakenForItsOwn) {
  ASSERT_EQ(run_small({}, "--set map_format=png").exit_code, 0);
  const auto is_there = [this](const std::string& name) {
    return std::filesystem::exists(out_ + "/" + name);
  };
  const auto leave = [this](const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      replace_file(out_ + "/" + name, "of an earlier run");
    }
  };
  EXPECT_TRUE(is_there("map.occupancy.png"));
  leave({"trajectory.1.tum", "trajectory.2.tum", "odometry.1.tum", "trajectory_live.1.tum",
         "map.slam.changes", "notes.txt", "trajectory.old.tum"});
  EXPECT_EQ(run("--start 1000").exit_code, 1);
  EXPECT_TRUE(is_there("map.occupancy.png")) << "nothing was written";
  ASSERT_EQ(run("").exit_code, 0);
  for (const char* gone : {"map.occupancy.png", "trajectory.1.tum", "trajectory.2.tum",
                           "odometry.1.tum", "trajectory_live.1.tum", "map.slam.changes"}) {
    EXPECT_FALSE(is_there(gone)) << gone;
  }
  EXPECT_TRUE(is_there("map.pgm") && is_there("notes.txt") && is_there("trajectory.old.tum"));
  ASSERT_EQ(run("--set map_format=png").exit_code, 0);
  EXPECT_FALSE(is_there("map.pgm"));
}

TEST_F(MapBag, SaysWhichLineOfWhichFileIsWrong) {
  write_small_bag(bag_);
  const std::string good = folder_ / "good.yaml";
  const std::string bad = folder_ / "bad.yaml";
  replace_file(good, "matcher: olson\n");
  replace_file(bad, "seed: 3\nslam:\n  insert_distance: -1\n");
  const std::string files = "--config " + good + " --config " + bad;
  expect_one_line(run(files), 2, bad + ":3: slam/insert_distance: -1 is not allowed");
  EXPECT_EQ(run(files + " --set slam/insert_distance=1").exit_code, 0) << "that counts";
  std::filesystem::remove_all(out_);
  replace_file(bad, "\nslam/insert_dist: 1\n");
  expect_one_line(run(files), 2,
                  bad +
                      ":2: slam: unknown parameter 'insert_dist'; did you mean "
                      "'insert_distance'?");
  replace_file(bad, "publish_tf: true\n");
  expect_one_line(run(files), 2, bad + ":1: publish_tf: only the node has this option");
  expect_one_line(run("--config " + good + " --set seed=-1"), 2, "map_bag: seed: -1");
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
  expect_one_line(run("--set insert_dist=1"), 2, "did you mean 'slam/insert_distance'?");
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
  for (const char* told : {"--threads N=1 ", "--start SECONDS=0 ", "else olson)", "as configured",
                           "Exits with 0 when done, 1 where the work failed, 2 for wrong usage"}) {
    EXPECT_TRUE(contains(help.output, told)) << told << help.output;
  }
  EXPECT_FALSE(contains(help.output, "=[]"));
  EXPECT_FALSE(contains(help.output, "=inf"));
}

TEST_F(MapBag, SaysWhereTheMapFrameIsTheBagsOwn) {
  write_small_bag(bag_);
  expect_one_line(run("--set map_frame=odom"), 2,
                  "map_frame: tf has 'odom' itself, and what touches it is left out (odom -> "
                  "base_link); if that is the robot's own, as its odometry, give the map another "
                  "name: --set map_frame=map; without it tf ");
  expect_one_line(run("--set map_frame=odom --laser-pose 0.2,0,0"), 2, "--set map_frame=map; ");
  expect_one_line(run("--set map_frame=base_link"), 2,
                  "left out (base_link -> laser, odom -> base_link)");
  SmallBag recipe;
  recipe.odom_frame = "map";
  write_small_bag(bag_, recipe);
  expect_one_line(run(""), 2, "map_frame: tf has 'map' itself, and what touches it is left out");
  EXPECT_EQ(run("--set map_frame=slam_map").exit_code, 0);
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
  recipe.scans = 50000;  // which take some seconds
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
  recipe.scans = 50000;  // which take some seconds
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
  EXPECT_FALSE(std::filesystem::exists(out_));
}

}  // namespace
}  // namespace matchbox_slam
