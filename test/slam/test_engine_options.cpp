#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "common/error_text.hpp"
#include "matchbox_slam/slam/engine_options.hpp"

namespace matchbox_slam {
namespace {

TEST(EngineOptionsReader, ReadsItsSectionsAndLeavesOthersAlone) {
  Parameters parameters;
  parameters.set("map/resolution", 0.1);
  parameters.set("slam/recent_scans", 7);
  parameters.set("scan/max_range", 12);
  parameters.set("field/sigma", 0.08);
  parameters.set("motion/rotation_floor", 0.5);
  parameters.set("monte_carlo/max_tries", 3);
  parameters.set("matcher", "olson");
  const EngineOptions options = read_engine_options(parameters);
  EXPECT_EQ(options.map.resolution, 0.1);
  EXPECT_EQ(options.slam.recent_scans, 7);
  EXPECT_EQ(options.scan.max_range, 12.0);
  EXPECT_EQ(options.field.sigma, 0.08);
  EXPECT_EQ(options.motion.rotation_floor, 0.5);
  EXPECT_EQ(options.map.quality, MapOptions{}.quality);
}

TEST(EngineOptionsReader, RefusesAThresholdThatNoFirstHitReaches) {
  Parameters parameters;
  parameters.set("map/occupied_threshold", 0.8);
  EXPECT_TRUE(
      contains(error_text<ConfigurationError>([&] { (void)read_engine_options(parameters); }),
               "map/occupied_threshold: 0.8 is not allowed"));
  parameters.set("map/quality", 0.6);
  EXPECT_EQ(read_engine_options(parameters).map.occupied_threshold, 0.8);
}

TEST(EngineOptionsReader, RefusesUnknownKeysOfItsSections) {
  for (const std::string section : {"slam", "scan", "map", "field", "motion"}) {
    Parameters parameters;
    parameters.set(section + "/no_such_option", 1);
    const std::string text =
        error_text<ConfigurationError>([&] { (void)read_engine_options(parameters); });
    EXPECT_TRUE(contains(text, section + ": unknown parameter 'no_such_option'")) << text;
  }
}

TEST(EngineOptionsReader, DescribesWhatItReads) {
  const std::vector<OptionDescription> rows = describe_engine_options({});
  Parameters parameters;
  for (const OptionDescription& row : rows) {
    EXPECT_NE(row.name.find('/'), std::string::npos) << row.name;
    EXPECT_FALSE(row.meaning.empty()) << row.name;
    parameters.set(row.name, row.value);
  }
  const std::vector<OptionDescription> again =
      describe_engine_options(read_engine_options(parameters));
  ASSERT_EQ(again.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(again[i].name, rows[i].name);
    EXPECT_EQ(again[i].value, rows[i].value) << rows[i].name;
  }
}

}  // namespace
}  // namespace matchbox_slam
