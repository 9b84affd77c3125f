#include <gtest/gtest.h>

#include <algorithm>

#include "common/error_text.hpp"
#include "matchbox_slam/io/yaml_parameters.hpp"
#include "ros/matcher_loader.hpp"
#include "run/live_configuration.hpp"

namespace matchbox_slam {
namespace {

class Live : public testing::Test {
 protected:
  [[nodiscard]] LiveConfiguration live(const std::string& yaml) const {
    return {parse_yaml_parameters(yaml, "test"), loader_};
  }

  static Parameters change(const std::string& name, const ParameterValue& value) {
    Parameters parameters;
    parameters.set(name, value);
    return parameters;
  }

  static const OptionDescription* find(const std::vector<OptionDescription>& rows,
                                       const std::string& name) {
    const auto row = std::find_if(rows.begin(), rows.end(),
                                  [&](const auto& candidate) { return candidate.name == name; });
    return row == rows.end() ? nullptr : &*row;
  }

  MatcherLoader loader_;
};

TEST_F(Live, ListsTheOptionsOfEveryMatcherWithTheirPresentValues) {
  const auto rows =
      live("matcher: olson\nhough: {peaks: 5}\nslam: {insert_distance: 0.7}").options();
  const OptionDescription* matcher = find(rows, "matcher");
  ASSERT_NE(matcher, nullptr);
  EXPECT_EQ(std::get<std::string>(matcher->value), "olson");
  EXPECT_NE(std::find(matcher->limits.words.begin(), matcher->limits.words.end(), "hough"),
            matcher->limits.words.end());
  ASSERT_NE(find(rows, "hough/peaks"), nullptr);
  EXPECT_EQ(std::get<std::int64_t>(find(rows, "hough/peaks")->value), 5);
  EXPECT_EQ(find(rows, "hough/peaks")->limits.high, 6.0);
  EXPECT_EQ(std::get<double>(find(rows, "slam/insert_distance")->value), 0.7);
  for (const char* fixed : {"base_frame", "seed", "map/resolution", "field/sigma", "queue_size"}) {
    EXPECT_EQ(find(rows, fixed), nullptr) << fixed;
  }
}

/// The plugins, and one that was declared and not built.
class WithBrokenPlugin : public MatcherCatalog {
 public:
  [[nodiscard]] std::vector<std::string> lookup_names() const override {
    std::vector<std::string> names = loader_.lookup_names();
    names.insert(names.begin(), "broken/Broken");
    return names;
  }
  [[nodiscard]] std::shared_ptr<ScanMatcher> create(const std::string& name) const override {
    return name == "broken/Broken" ? throw ConfigurationError("cannot be loaded")
                                   : loader_.create(name);
  }

 private:
  MatcherLoader loader_;
};

TEST_F(Live, AMatcherThatCannotBeLoadedStopsNobodyWhoHasChosenAnother) {
  const WithBrokenPlugin catalog;
  const LiveConfiguration live(parse_yaml_parameters("matcher: olson", "test"), catalog);
  EXPECT_NE(find(live.options(), "hough/peaks"), nullptr);
  EXPECT_EQ(error_text<ConfigurationError>(
                [&] { (void)live.with(change("matcher", std::string("broken"))); }),
            "cannot be loaded");
}

TEST_F(Live, ChangesTheMatcherAndKeepsWhatWasGiven) {
  const LiveConfiguration before =
      live("matcher: olson\nhough: {peaks: 5}\nmap: {resolution: 0.1}");
  const LiveConfiguration after = before.with(change("matcher", std::string("hough")));
  EXPECT_EQ(after.setup().matcher_name, "matchbox_slam/Hough");
  EXPECT_EQ(after.setup().engine.map.resolution, 0.1);
  EXPECT_EQ(after.setup().hough.alignment.peaks, 5);
  EXPECT_EQ(before.setup().matcher_name, "matchbox_slam/Olson");
}

TEST_F(Live, RefusesWithTheReason) {
  const LiveConfiguration before = live("");
  const auto refused = [&](const std::string& name, const ParameterValue& value) {
    return error_text<ConfigurationError>([&] { (void)before.with(change(name, value)); });
  };
  EXPECT_EQ(refused("hough/peaks", std::int64_t{7}),
            "hough/peaks: 7 is not allowed; allowed: 1 to 6");
  EXPECT_TRUE(contains(refused("matcher", std::string("olsen")), "there is no matcher 'olsen'"));
  EXPECT_EQ(refused("map/resolution", 0.1),
            "map/resolution: cannot be changed while running; restart the node with it");
  EXPECT_EQ(refused("base_frame", std::string("x")),
            "base_frame: cannot be changed while running; restart the node with it");
}

}  // namespace
}  // namespace matchbox_slam
