// Of tools/evaluate_map.hpp: `evaluate map` as a user runs it.

#include <gtest/gtest.h>

#include <string>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "tools/evaluate_program.hpp"

namespace matchbox_slam {
namespace {

/// A free square of 40 x 40 cells within walls of one cell.
MapImage square_room() {
  MapImage map;
  map.width = 42;
  map.height = 42;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const bool is_wall = x == 0 || y == 0 || x == map.width - 1 || y == map.height - 1;
      map.pixels.push_back(is_wall ? MapImage::kOccupiedPixel : MapImage::kFreePixel);
    }
  }
  return map;
}

class EvaluateMap : public ::testing::Test {
 protected:
  EvaluateMap() {
    write_map(folder_ / "room", square_room());
    MapImage open = square_room();
    for (int y = 0; y < open.height; ++y) {  // without its left wall
      open.pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(open.width)] =
          MapImage::kUnknownPixel;
    }
    write_map(folder_ / "open", open);
  }

  TemporaryFolder folder_;
  std::string room_ = folder_ / "room.yaml";
  std::string open_ = folder_ / "open.yaml";
};

TEST_F(EvaluateMap, PrintsARowAMap) {
  const Outcome outcome = run_evaluate("map " + room_ + " " + open_);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(line_count(outcome.output), 6U) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "0.050  2.1 x 2.1         1764")) << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "0.0930         0.1025        4               1\n"))
      << outcome.output;
  EXPECT_TRUE(contains(outcome.output, "               0\n")) << outcome.output;
}

TEST_F(EvaluateMap, PrintsJson) {
  const Outcome outcome = run_evaluate("map " + room_ + " --json");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.output.front(), '{');
  for (const char* part :
       {R"("metric": "map")", R"("corners": 4)", R"("enclosed_areas": 1)", R"("free_cells": 1600)",
        R"("known_cells": 1764)", R"("occupied_cells": 164)", R"("occupied_of_free": 0.1025)",
        R"("occupied_of_known": 0.0929)", R"("resolution_m": 0.05)", R"("width_m": 2.1)"}) {
    EXPECT_TRUE(contains(outcome.output, part)) << part << " in " << outcome.output;
  }
}

TEST_F(EvaluateMap, WritesAPictureOfAllMaps) {
  if (!has_matplotlib()) {
    GTEST_SKIP() << "SKIPPED: /usr/bin/python3 has no matplotlib; install python3-matplotlib";
  }
  const std::string picture = folder_ / "plot.png";
  EXPECT_EQ(run_evaluate("map " + room_ + " --plot " + picture).exit_code, 0);
  const std::string one = read_file(picture);
  EXPECT_EQ(one.substr(1, 3), "PNG");
  EXPECT_EQ(run_evaluate("map " + room_ + " " + open_ + " --plot " + picture).exit_code, 0);
  const auto width = [](const std::string& png) {  // in the head, most significant byte first
    return static_cast<unsigned char>(png[18]) * 256 + static_cast<unsigned char>(png[19]);
  };
  EXPECT_GE(width(one), 16 * 42);
  EXPECT_GE(width(read_file(picture)), 2 * 16 * 42);
}

TEST_F(EvaluateMap, WrongUsageExitsWithTwoAndOneLine) {
  for (const std::string& arguments :
       {std::string("map"), "map " + room_ + " --plot", "map " + room_ + " --truth " + room_,
        "map " + room_ + " --plot " + (folder_ / "plot.jpg"),
        "map " + room_ + " " + (folder_ / "none.yaml")}) {
    const Outcome outcome = run_evaluate(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments;
    EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
  }
}

TEST_F(EvaluateMap, FailedWorkExitsWithOneAndOneLine) {
  replace_file(folder_ / "broken.yaml", "image: room.pgm\n");
  MapImage blank = square_room();
  blank.pixels.assign(blank.pixels.size(), MapImage::kUnknownPixel);
  write_map(folder_ / "blank", blank);
  for (const std::string name : {"broken.yaml", "blank.yaml", "room.pgm"}) {
    const Outcome outcome = run_evaluate("map " + room_ + " " + (folder_ / name));
    EXPECT_EQ(outcome.exit_code, 1) << name;
    EXPECT_EQ(line_count(outcome.output), 1U) << outcome.output;
    EXPECT_TRUE(contains(outcome.output, name)) << outcome.output;
  }
  // The map that is missing would fail too, were it read first.
  const Outcome unwritable = run_evaluate("map " + (folder_ / "none.yaml") + " --plot " +
                                          (folder_ / "no_folder/plot.png"));
  EXPECT_EQ(unwritable.exit_code, 1);
  EXPECT_EQ(line_count(unwritable.output), 1U) << unwritable.output;
  EXPECT_TRUE(contains(unwritable.output, "no_folder")) << unwritable.output;
}

}  // namespace
}  // namespace matchbox_slam
