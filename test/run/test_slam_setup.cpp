#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "run/frames.hpp"
#include "run/slam_setup.hpp"

namespace matchbox_slam {
namespace {

SlamSetup setup_of(const std::string& yaml) {
  return make_slam_setup(parse_yaml_parameters(yaml, "test"), MatcherLoader());
}

std::string refusal_of(const std::string& yaml) {
  return error_text<ConfigurationError>([&] { (void)setup_of(yaml); });
}

TEST(MatcherLoader, NamesMatchersInTwoWays) {
  EXPECT_EQ(matcher_short_name("matchbox_slam/MonteCarlo"), "monte_carlo");
  EXPECT_EQ(matcher_short_name("my_package/ICPMatcher2"), "icp_matcher2");
  EXPECT_EQ(matcher_short_name("Plain"), "plain");
  const MatcherLoader loader;
  EXPECT_EQ(loader.find("monte_carlo"), "matchbox_slam/MonteCarlo");
  EXPECT_EQ(loader.find("matchbox_slam/OdometryOnly"), "matchbox_slam/OdometryOnly");
}

TEST(MatcherLoader, HasOurOwnAtHandAndAsPlugins) {
  const MatcherLoader loader;
  std::vector<std::string> own = loader.lookup_names();
  own.erase(
      std::remove_if(own.begin(), own.end(),
                     [](const std::string& name) { return name.rfind("matchbox_slam/", 0) != 0; }),
      own.end());
  EXPECT_EQ(loader.names_at_hand(), own);
}

/// With a matcher at hand, and plugins that it counts the searches for.
class CountingCatalog : public MatcherCatalog {
 public:
  [[nodiscard]] std::vector<std::string> names_at_hand() const override { return {"our/Olson"}; }
  [[nodiscard]] std::vector<std::string> lookup_names() const override {
    ++searches_;
    return {"other/Hough", "other/Olson", "our/Olson"};
  }
  [[nodiscard]] std::shared_ptr<ScanMatcher> create(const std::string& name) const override {
    return MatcherLoader().create("matchbox_slam" + name.substr(name.find('/')));
  }
  [[nodiscard]] int searches() const { return searches_; }

 private:
  mutable int searches_ = 0;
};

TEST(MatcherCatalog, SearchesForPluginsOnlyWhereNoneAtHandIsMeant) {
  const CountingCatalog catalog;
  const auto setup = [&](const std::string& yaml) {
    return make_slam_setup(parse_yaml_parameters(yaml, "test"), catalog);
  };
  EXPECT_EQ(setup("matcher: olson\nmap: {resolution: 0.1}\nolson: {window_xy: 1.0}").matcher_name,
            "our/Olson");
  EXPECT_EQ(catalog.searches(), 0);
  EXPECT_EQ(setup("matcher: other/Olson").matcher_name, "other/Olson");
  EXPECT_EQ(setup("matcher: hough").matcher_name, "other/Hough");
  EXPECT_GT(catalog.searches(), 0);
  EXPECT_EQ(setup("matcher: olson\nhough: {peaks: 5}").matcher_name, "our/Olson");
  EXPECT_TRUE(contains(
      error_text<ConfigurationError>([&] { (void)setup("matcher: olson\nhough: {peaks: 7}"); }),
      "hough/peaks: 7 is not allowed"));
}

TEST(MatcherLoader, AnUnknownNameListsTheKnown) {
  const std::string text =
      error_text<ConfigurationError>([] { (void)MatcherLoader().find("carlo"); });
  EXPECT_TRUE(contains(text, "no matcher 'carlo'")) << text;
  EXPECT_TRUE(contains(text, "monte_carlo, ")) << text;
  EXPECT_TRUE(contains(text, "matchbox_slam/MonteCarlo")) << text;
}

TEST(MatcherLoader, MatchersOutliveTheLoader) {
  std::shared_ptr<ScanMatcher> matcher;
  {
    const MatcherLoader loader;
    matcher = loader.create("matchbox_slam/MonteCarlo");
  }
  EXPECT_FALSE(matcher->options().empty());
}

TEST(SlamSetup, DefaultsAreComplete) {
  const SlamSetup setup = setup_of("");
  EXPECT_EQ(setup.matcher_name, "matchbox_slam/Olson");
  EXPECT_NE(setup.matcher, nullptr);
}

TEST(SlamSetup, ReadsEverySection) {
  const SlamSetup setup = setup_of(
      "matcher: odometry_only\nseed: 7\npublish_tf: false\nscan_time_offset: 82.2\n"
      "slam: {insert_distance: 0.7}\nscan/max_range: 12\nmap: {resolution: 0.1}\n"
      "motion: {rotation_by_way: 0.01}\nfield: {reach: 0.3}\nmonte_carlo: {max_tries: 3}\n");
  EXPECT_EQ(setup.matcher_name, "matchbox_slam/OdometryOnly");
  EXPECT_EQ(setup.run.seed, 7);
  EXPECT_EQ(setup.run.scan_time_offset, "82.2");
  EXPECT_FALSE(setup.node.publish_tf);
  EXPECT_DOUBLE_EQ(setup.engine.slam.insert_distance, 0.7);
  EXPECT_DOUBLE_EQ(setup.engine.scan.max_range, 12.0);
  EXPECT_DOUBLE_EQ(setup.engine.map.resolution, 0.1);
  EXPECT_DOUBLE_EQ(setup.engine.motion.rotation_by_way, 0.01);
  EXPECT_DOUBLE_EQ(setup.engine.field.reach, 0.3);
}

TEST(SlamSetup, ThePlaceOfALaserIsAListOrText) {
  const std::vector<double> expected = {0.2, -0.1, 3.14};
  for (const char* text : {"[0.2, -0.1, 3.14]", "'0.2,-0.1,3.14'", "'[0.2, -0.1, 3.14]'"}) {
    EXPECT_EQ(setup_of(std::string("laser_pose: ") + text).run.laser_pose, expected) << text;
  }
  EXPECT_TRUE(setup_of("laser_pose: ''").run.laser_pose.empty());
  const auto refusal = [](const std::string& yaml) {
    return error_text<ConfigurationError>([&] { (void)setup_of(yaml); });
  };
  EXPECT_EQ(refusal("laser_pose: 'ahead'"),
            "laser_pose: 'ahead' is not allowed; allowed: [x, y, yaw] in m and rad, such as "
            "0.2,0,3.14");
  EXPECT_EQ(refusal("laser_pose: [1, 2]"),
            "laser_pose: 2 numbers are not allowed; allowed: three for each laser: x, y, yaw");
  EXPECT_EQ(refusal("scan_topics: [a]\nlaser_pose: [1, 2, 0, 3, 4, 0]"),
            "laser_pose: 2 places are not allowed; there are 1 scan_topics");
}

TEST(SlamSetup, ATopicOfOdometryAndNoOdometryContradict) {
  EXPECT_TRUE(contains(error_text<ConfigurationError>(
                           [] { (void)setup_of("odom_topic: /odom\nuse_odometry: false"); }),
                       "leave out one of the two"));
}

TEST(SlamSetup, KeepsTheHoughOptionsWhateverTheMatcher) {
  EXPECT_EQ(setup_of("matcher: olson").hough.alignment.peaks, HoughOptions{}.alignment.peaks);
  for (const std::string matcher : {"olson", "hough"}) {
    const SlamSetup setup =
        setup_of("{matcher: " + matcher + ", hough: {peaks: 5, refine_iterations: 3}}");
    EXPECT_EQ(setup.hough.alignment.peaks, 5) << matcher;
    EXPECT_EQ(setup.hough.refinement.iterations, 3) << matcher;
  }
}

TEST(SlamSetup, TheDescriptionReadsBackAsTheSame) {
  const SlamSetup setup =
      setup_of("matcher: monte_carlo\nmonte_carlo: {max_tries: 321}\nmap: {resolution: 0.1}\n");
  Parameters described;
  for (const OptionDescription& row : describe_setup(setup)) {
    described.set(row.name, row.value);
  }
  EXPECT_EQ(std::get<std::int64_t>(*described.find("monte_carlo/max_tries")), 321);
  const SlamSetup again = make_slam_setup(described, MatcherLoader());
  EXPECT_DOUBLE_EQ(again.engine.map.resolution, 0.1);
}

TEST(SlamSetup, RefusesWhatItDoesNotKnow) {
  EXPECT_TRUE(contains(refusal_of("base_fram: x"), "did you mean 'base_frame'"));
  EXPECT_TRUE(contains(refusal_of("monte_carl: {max_tries: 3}"),
                       "unknown section 'monte_carl'; did you mean 'monte_carlo'? Known: slam, "));
  EXPECT_TRUE(contains(refusal_of("monte_carlo: {max_trys: 3}"), "did you mean 'max_tries'"));
  EXPECT_TRUE(contains(refusal_of("slam: {insert_distanc: 3}"), "'insert_distance'"));
  EXPECT_TRUE(contains(refusal_of("matcher: olsen"), "no matcher 'olsen'"));
  EXPECT_TRUE(contains(refusal_of("seed: -1"), "seed: -1 is not allowed; allowed: at least 0"));
  EXPECT_TRUE(contains(refusal_of("time_jump: panic"), "one of go_on, reset, stop"));
  for (const std::string offset : {"soon", "-1e7", ".inf", ".nan", "nan"}) {
    const std::string text = refusal_of("scan_time_offset: " + offset);
    EXPECT_TRUE(contains(text, "scan_time_offset: ")) << text;
    EXPECT_TRUE(contains(text, "allowed: a number of seconds from -1000000 to 1000000, auto"))
        << text;
  }
}

TEST(SlamSetup, SaysWhatTookThePlaceOfAFormerOption) {
  EXPECT_TRUE(contains(refusal_of("doubt: {enabled: false}"),
                       "doubt/enabled: there is no such option since version 2; "
                       "hypotheses/enabled took its place"));
  EXPECT_TRUE(contains(refusal_of("tracking: {lost_after: 2}"), "hypotheses/* took its place"));
  EXPECT_TRUE(contains(refusal_of("recovery: {key_scans: 2}"), "recovery/places took its place"));
  EXPECT_TRUE(
      contains(refusal_of("recovery: {far_confirmations: 2}"), "recovery/sure took its place"));
  EXPECT_EQ(refusal_of("olson: {widenings: 2}"),
            "olson/widenings: there is no such option since version 2; windows are not widened, "
            "olson/window_sigmas, window_xy and window_theta say how wide they are; leave it out");
}

TEST(SlamSetup, SaysHowARenamedOptionIsCalledNow) {
  EXPECT_EQ(refusal_of("motion: {least_share: 1}"),
            "motion/least_share: since version 2 this option is called motion/min_noise_scale; "
            "write that");
  EXPECT_TRUE(
      contains(refusal_of("loops: {least_mutual_fit: 0.5}"), "loops/decisive took its place"));
  EXPECT_TRUE(contains(refusal_of("loops: {apart: 1}"), "called loops/max_relative_sigma"));
}

TEST(SlamSetup, SaysWhatAnOptionIsThatIsNoneAnyMore) {
  EXPECT_EQ(refusal_of("hypotheses: {search_xy: 1}"),
            "hypotheses/search_xy: this is no option, it is 0.5 m for everybody; leave it out");
  EXPECT_TRUE(contains(refusal_of("loops: {search_way: 2}"), "it is 1 m for everybody"));
}

TEST(SlamSetup, SaysInWhichSectionAnOptionIs) {
  EXPECT_TRUE(contains(refusal_of("insert_distance: 1"),
                       "unknown parameter 'insert_distance'; did you mean 'slam/insert_distance'? "
                       "Known: matcher, "));
  EXPECT_TRUE(contains(refusal_of("insert_dist: 1"), "did you mean 'slam/insert_distance'?"));
  EXPECT_TRUE(contains(refusal_of("max_tries: 1"), "did you mean 'monte_carlo/max_tries'?"));
  EXPECT_TRUE(contains(refusal_of("min_height: 1"), "did you mean 'cloud/min_height'?"));
  EXPECT_TRUE(contains(refusal_of("min_score: 1"), "/min_score' or '"));
}

TEST(SlamSetup, OfAProgramKnowsNoOptionOfTheNode) {
  const auto refusal = [](SetupOf whose) {
    return error_text<ConfigurationError>([&] {
      (void)make_slam_setup(parse_yaml_parameters("nothing_like_it: 1", "test"), MatcherLoader(),
                            whose);
    });
  };
  EXPECT_TRUE(contains(refusal(SetupOf::kNode), "map_format, start_x, start_y, start_theta, pub"));
  EXPECT_TRUE(contains(refusal(SetupOf::kProgram), "start_theta."));
}

TEST(SlamSetup, StripsTheLeadingSlashOfFrames) {
  const SlamSetup setup = setup_of("base_frame: /base\nodom_frame: /odom2\nmap_frame: /world\n");
  EXPECT_EQ(setup.run.base_frame, "base");
  EXPECT_EQ(setup.run.odom_frame, "odom2");
  EXPECT_EQ(setup.run.map_frame, "world");
}

TEST(SlamSetup, FramesHaveToDiffer) {
  const auto refusal = [](const std::string& yaml) {
    const SlamSetup setup = setup_of(yaml);
    return error_text<ConfigurationError>([&] { check_frames(setup.run); });
  };
  EXPECT_EQ(refusal("base_frame: /odom"),
            "odom_frame: 'odom' is not allowed; allowed: a frame other than base_frame");
  EXPECT_EQ(refusal("map_frame: base_link"),
            "base_frame: 'base_link' is not allowed; allowed: a frame other than map_frame");
  EXPECT_EQ(refusal("map_frame: odom"),
            "odom_frame: 'odom' is not allowed; allowed: a frame other than map_frame");
  EXPECT_NO_THROW(check_frames(setup_of("map_frame: odom\nuse_odometry: false").run));
}

TEST(Options, TellTheirMeaningInSentencesOfTheirOwn) {
  for (const std::string name : {"monte_carlo", "olson", "hough"}) {
    Parameters matcher;
    matcher.set("matcher", name);
    for (const OptionDescription& row : describe_setup(make_slam_setup(matcher, MatcherLoader()))) {
      const std::string& text = row.meaning;
      EXPECT_NE(text.substr(0, 3), "...") << row.name << ": " << text;
      EXPECT_NE(text.substr(text.size() - 3), "...") << row.name << ": " << text;
      EXPECT_EQ(text.back(), '.') << row.name << ": " << text;
    }
  }
}

TEST(ShippedConfig, EveryFileIsReadAndNamesAMatcher) {
  std::size_t files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(MATCHBOX_SOURCE_DIR) + "/config")) {
    const Parameters parameters = read_yaml_parameters({entry.path().string()});
    const SlamSetup setup = make_slam_setup(parameters, MatcherLoader());
    EXPECT_EQ(matcher_short_name(setup.matcher_name), entry.path().stem().string());
    ++files;
  }
  EXPECT_GE(files, 3U);
}

TEST(ShippedConfig, EveryMatcherHasOne) {
  for (const std::string& name : MatcherLoader().lookup_names()) {
    if (name.rfind("matchbox_slam/", 0) != 0) {
      continue;  // of another package in the workspace
    }
    EXPECT_TRUE(std::filesystem::exists(std::string(MATCHBOX_SOURCE_DIR) + "/config/" +
                                        matcher_short_name(name) + ".yaml"))
        << name;
  }
}

}  // namespace
}  // namespace matchbox_slam
