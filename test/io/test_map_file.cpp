#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>

#include "common/error_text.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"

namespace matchbox_slam {
namespace {

/// Three columns and two rows of cells, the lower left of them at (-2, -1):
///   occupied  free     unsure
///   unknown   unknown  free
OccupancyGrid small_grid() {
  OccupancyGrid grid(0.1);
  grid.blend({-2, 0}, 1.0, 1.0);
  grid.blend({-1, 0}, 0.0, 1.0);
  grid.blend({0, 0}, 0.4, 1.0);
  grid.blend({0, -1}, 0.1, 1.0);
  return grid;
}

TEST(MakeMapImage, PutsTheTopRowFirstAndTheOriginInTheLowerLeftCorner) {
  const MapImage map = make_map_image(small_grid());
  EXPECT_EQ(map.width, 3);
  EXPECT_EQ(map.height, 2);
  EXPECT_EQ(map.pixels, (std::vector<std::uint8_t>{0, 254, 205, 205, 205, 254}));
  EXPECT_EQ(map.resolution, 0.1);
  EXPECT_NEAR(map.origin.x, -0.2, 1e-12);
  EXPECT_NEAR(map.origin.y, -0.1, 1e-12);
  EXPECT_EQ(map.origin.theta, 0.0);
}

TEST(MakeMapImage, StatesAreThoseThatMapServerReads) {
  const MapImage map = make_map_image(small_grid());
  EXPECT_EQ(map.state({0, 1}), CellState::kOccupied);
  EXPECT_EQ(map.state({1, 1}), CellState::kFree);
  EXPECT_EQ(map.state({2, 1}), CellState::kUnknown);
  EXPECT_EQ(map.state({0, 0}), CellState::kUnknown);
  EXPECT_EQ(map.state({2, 0}), CellState::kFree);
}

TEST(MakeMapImage, ThresholdsBelongToOccupiedAndFree) {
  OccupancyGrid grid(0.1);
  grid.blend({0, 0}, 0.66, 1.0);
  grid.blend({1, 0}, 0.64, 1.0);
  grid.blend({2, 0}, 0.26, 1.0);
  grid.blend({3, 0}, 0.24, 1.0);
  EXPECT_EQ(make_map_image(grid).pixels, (std::vector<std::uint8_t>{0, 205, 205, 254}));
  EXPECT_EQ(make_map_image(grid, {0.6, 0.3}).pixels, (std::vector<std::uint8_t>{0, 0, 254, 254}));
  EXPECT_EQ(make_map_image(grid, {1.0, 0.0}).pixels,
            (std::vector<std::uint8_t>{205, 205, 205, 205}));
  EXPECT_EQ(error_text<std::invalid_argument>([&] {
              (void)make_map_image(grid, {0.3, 0.6});
            }),
            "the thresholds of a map have to be 0 <= free (0.6) < occupied (0.3) <= 1");
}

TEST(MakeMapImage, AnEmptyGridIsOneUnknownPixel) {
  const MapImage map = make_map_image(OccupancyGrid(0.05));
  EXPECT_EQ(map.width, 1);
  EXPECT_EQ(map.height, 1);
  EXPECT_EQ(map.pixels, std::vector<std::uint8_t>{205});
}

TEST(WriteMap, WritesTheBytesThatMapSaverWrites) {
  const TemporaryFolder folder;
  write_map(folder / "my_map", make_map_image(small_grid()));
  EXPECT_EQ(read_file(folder / "my_map.pgm"),
            std::string("P5\n# CREATOR: matchbox_slam 0.100 m/pix\n3 2\n255\n") +
                std::string("\x00\xfe\xcd\xcd\xcd\xfe", 6));
  EXPECT_EQ(read_file(folder / "my_map.yaml"),
            "image: my_map.pgm\n"
            "resolution: 0.100000\n"
            "origin: [-0.200000, -0.100000, 0.000000]\n"
            "negate: 0\n"
            "occupied_thresh: 0.65\n"
            "free_thresh: 0.196\n\n");
  EXPECT_EQ(folder.file_count(), 2U);
}

/// Independent of rows and columns: a wall is found again at its place in metres.
TEST(ReadMap, FindsCellsAtTheirPlaceInTheMapFrame) {
  const TemporaryFolder folder;
  OccupancyGrid grid(0.05);
  const Eigen::Vector2d wall(-3.33, 2.71);
  const Eigen::Vector2d free(4.02, -7.77);
  grid.blend(grid.geometry().cell_at(wall), 1.0, 1.0);
  grid.blend(grid.geometry().cell_at(free), 0.0, 1.0);
  write_map(folder / "map", make_map_image(grid));
  const MapImage map = read_map(folder / "map.yaml");
  const auto cell_at = [&map](const Eigen::Vector2d& point) {
    return Cell{static_cast<int>((point.x() - map.origin.x) / map.resolution),
                static_cast<int>((point.y() - map.origin.y) / map.resolution)};
  };
  EXPECT_EQ(map.state(cell_at(wall)), CellState::kOccupied);
  EXPECT_EQ(map.state(cell_at(free)), CellState::kFree);
  EXPECT_EQ(cell_at(wall).x, 0);
  EXPECT_EQ(cell_at(free).y, 0);
}

TEST(ReadMap, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  MapImage map = make_map_image(small_grid());
  map.origin = {-12.35, 0.75, 0.5};
  write_map(folder / "map", map);
  const MapImage read = read_map(folder / "map.yaml");
  EXPECT_EQ(read.width, map.width);
  EXPECT_EQ(read.height, map.height);
  EXPECT_EQ(read.pixels, map.pixels);
  EXPECT_EQ(read.resolution, map.resolution);
  EXPECT_EQ(read.origin, map.origin);
  EXPECT_EQ(read.negate, map.negate);
  EXPECT_EQ(read.occupied_threshold, map.occupied_threshold);
  EXPECT_EQ(read.free_threshold, map.free_threshold);
}

class ReadMapOfOthers : public ::testing::Test {
 protected:
  [[nodiscard]] MapImage read(const std::string& image, const std::string& change = "negate: 0") {
    std::filesystem::create_directories(folder_ / "images");
    replace_file(folder_ / "images/a.pgm", image);
    replace_file(folder_ / "map.yaml",
                 "image: images/a.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
                 "occupied_thresh: 0.65\nfree_thresh: 0.196\n" +
                     change + "\n");
    return read_map(folder_ / "map.yaml");
  }

  [[nodiscard]] std::string refusal(const std::string& image,
                                    const std::string& change = "negate: 0") {
    return error_text<FileError>([&] { (void)read(image, change); });
  }

  TemporaryFolder folder_;
};

TEST_F(ReadMapOfOthers, TakesCommentsAndOtherSpaceInTheHead) {
  // The first pixel is a line end, which does not belong to the head.
  const MapImage map = read("P5 # a comment\n#another\n  2\t1\n255 \n\xfe");
  EXPECT_EQ(map.pixels, (std::vector<std::uint8_t>{'\n', 254}));
  EXPECT_EQ(map.state({0, 0}), CellState::kOccupied);
}

TEST_F(ReadMapOfOthers, NegatedImagesAreOccupiedWhereBright) {
  const MapImage map = read("P5\n3 1\n255\n\xfe\x01\x80", "negate: 1");
  EXPECT_EQ(map.state({0, 0}), CellState::kOccupied);
  EXPECT_EQ(map.state({1, 0}), CellState::kFree);
  EXPECT_EQ(map.state({2, 0}), CellState::kUnknown);
}

TEST_F(ReadMapOfOthers, SaysWhatIsWrong) {
  EXPECT_TRUE(contains(refusal("P2\n1 1\n255\n0"), "a.pgm' is not a binary PGM"));
  EXPECT_TRUE(contains(refusal(""), "a.pgm' is not a binary PGM"));
  EXPECT_TRUE(contains(refusal("P5\n0 1\n255\n"), "a.pgm' has no usable width"));
  EXPECT_TRUE(contains(refusal("P5\n99999999999 1\n255\n"), "a.pgm' has no usable width"));
  EXPECT_TRUE(contains(refusal("P5\n3"), "a.pgm' has no usable height"));
  EXPECT_TRUE(contains(refusal("P5\n1 1\n65535\nab"), "a.pgm' has the brightest value 65535"));
  EXPECT_TRUE(contains(refusal("P5\n2 2\n255\nabc"),
                       "a.pgm' is cut off: 2 x 2 pixels are announced, 3 are there"));
  EXPECT_TRUE(contains(refusal("P5\n1 1\n255"), "0 are there"));
  const std::string image = "P5\n1 1\n255\na";
  EXPECT_TRUE(contains(refusal(image, ""), "map.yaml' has no 'negate'"));
  EXPECT_TRUE(contains(refusal(image, "negate: maybe"), "has a 'negate' that cannot be read"));
  EXPECT_TRUE(contains(refusal(image, "negate: 0\nmode: raw"), "mode has to be trinary"));
  EXPECT_TRUE(contains(refusal(image, "negate: [0"), "map.yaml' is not YAML"));
}

TEST_F(ReadMapOfOthers, SaysWhichFileIsMissing) {
  (void)read("P5\n1 1\n255\na");
  std::filesystem::remove(folder_ / "images/a.pgm");
  EXPECT_EQ(error_text<FileError>([&] { (void)read_map(folder_ / "map.yaml"); }),
            "cannot read '" + (folder_ / "images/a.pgm") + "': No such file or directory");
}

}  // namespace
}  // namespace matchbox_slam
