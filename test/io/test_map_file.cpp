#include <gtest/gtest.h>
#include <png.h>
#include <zlib.h>

#include <array>
#include <filesystem>
#include <stdexcept>

#include "common/error_text.hpp"
#include "io/png_image.hpp"
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

TEST(WriteMap, WritesAPngBesideThePictureForPeople) {
  const TemporaryFolder folder;
  const MapImage map = make_map_image(small_grid());
  write_map(folder / "my_map", map, MapFormat::kPng);
  EXPECT_EQ(folder.file_count(), 2U);
  EXPECT_TRUE(is_png(read_file(folder / "my_map.occupancy.png")));
  EXPECT_EQ(read_file(folder / "my_map.yaml").substr(0, 29), "image: my_map.occupancy.png\nr");
  const MapImage read = read_map(folder / "my_map.yaml");
  EXPECT_EQ(read.width, 3);
  EXPECT_EQ(read.height, 2);
  EXPECT_EQ(read.pixels, map.pixels);
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

TEST_F(ReadMapOfOthers, TakesPixelsThatAreWrittenAsNumbers) {
  const MapImage map = read("P2\n# by hand\n3 2\n255\n0 254\n205  10 20 30\n");
  EXPECT_EQ(map.pixels, (std::vector<std::uint8_t>{0, 254, 205, 10, 20, 30}));
  EXPECT_EQ(map.state({0, 1}), CellState::kOccupied);
}

TEST_F(ReadMapOfOthers, NegatedImagesAreOccupiedWhereBright) {
  const MapImage map = read("P5\n3 1\n255\n\xfe\x01\x80", "negate: 1");
  EXPECT_EQ(map.state({0, 0}), CellState::kOccupied);
  EXPECT_EQ(map.state({1, 0}), CellState::kFree);
  EXPECT_EQ(map.state({2, 0}), CellState::kUnknown);
}

TEST_F(ReadMapOfOthers, SaysWhatIsWrong) {
  EXPECT_TRUE(contains(refusal("P6\n1 1\n255\n0"), "a.pgm' is not a PGM"));
  EXPECT_TRUE(contains(refusal(""), "a.pgm' is not a PGM"));
  EXPECT_TRUE(contains(refusal("P2\n2 1\n255\n7"),
                       "a.pgm' is cut off or damaged: 2 x 1 pixels are announced, 1 are there"));
  EXPECT_TRUE(contains(refusal("P2\n2 1\n255\n7 256"), "1 are there, each 0 to 255"));
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
  EXPECT_TRUE(
      contains(refusal(image, "negate: 0\nmode: gray"),
               "mode 'gray' is not allowed; allowed: trinary, scale, raw, or leave it out"));
  EXPECT_TRUE(contains(refusal(image, "negate: [0"), "map.yaml' is not YAML"));
}

/// The states of an image's row, as letters.
std::string states(const MapImage& map) {
  std::string letters;
  for (int x = 0; x < map.width; ++x) {
    letters += "ufo"[static_cast<int>(map.state({x, 0}))];  // unknown, free, occupied
  }
  return letters;
}

TEST_F(ReadMapOfOthers, ModesAreThoseOfMapServer) {
  // Of 0 to 255: occupied below 89.25, free above 205.02.
  const std::string image = "P5\n7 1\n255\n" + std::string("\x00\x59\x5a\xa0\xcc\xce\xff", 7);
  EXPECT_EQ(states(read(image)), "oouuuff");
  EXPECT_EQ(states(read(image, "negate: 0\nmode: trinary")), "oouuuff");
  // 100, 100, 99, 39, 2, 0, 0 percent
  EXPECT_EQ(states(read(image, "negate: 0\nmode: scale")), "oooufff");
  EXPECT_EQ(states(read(image, "negate: 1\nmode: scale")), "fuuoooo");
  const std::string percents = "P5\n7 1\n255\n" + std::string("\x00\x19\x1a\x40\x41\x64\x65", 7);
  EXPECT_EQ(states(read(percents, "negate: 0\nmode: raw")), "ffuuoou");
}

/// PNG files of one row, as other programs write them.
class ReadPngOfOthers : public ReadMapOfOthers {
 protected:
  /// @param channels  1, or 2 with alpha; 3, or 4 with alpha.
  [[nodiscard]] static std::string png(const std::vector<std::uint8_t>& samples,
                                       unsigned channels) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(samples.size() / channels);
    image.height = 1;
    image.format = std::array<png_uint_32, 5>{0, PNG_FORMAT_GRAY, PNG_FORMAT_GA, PNG_FORMAT_RGB,
                                              PNG_FORMAT_RGBA}
                       .at(channels);
    std::string bytes(10000, '\0');
    png_alloc_size_t size = bytes.size();
    EXPECT_NE(png_image_write_to_memory(&image, bytes.data(), &size, 0, samples.data(), 0, nullptr),
              0);
    bytes.resize(size);
    return bytes;
  }
};

TEST_F(ReadPngOfOthers, KeepsTheGrayOfItsPixels) {
  const std::vector<std::uint8_t> pixels = {0, 1, 89, 90, 204, 205, 206, 254, 255};
  const MapImage map = read(png(pixels, 1));
  EXPECT_EQ(map.pixels, pixels);
  EXPECT_EQ(states(map), "ooouuufff");
  EXPECT_EQ(states(read(png(pixels, 1), "negate: 1")), "ffuuooooo");
  EXPECT_EQ(states(read(png(pixels, 1), "negate: 0\nmode: scale")), "oooofffff");
}

/// A chunk of a PNG.
std::string chunk(const std::string& type, const std::string& contents) {
  const auto number = [](unsigned long value) {
    std::string bytes;
    for (const unsigned shift : {24U, 16U, 8U, 0U}) {
      bytes += static_cast<char>((value >> shift) & 0xFFU);
    }
    return bytes;
  };
  const std::string body = type + contents;
  return number(contents.size()) + body +
         number(::crc32(0, reinterpret_cast<const Bytef*>(body.data()),
                        static_cast<uInt>(body.size())));
}

/// map_server looks at the pixels as they are in the file.
TEST_F(ReadPngOfOthers, WhatAFileSaysOfItsGammaChangesNothing) {
  constexpr std::size_t kHead = 33;  // bytes of the signature and the first chunk
  const std::vector<std::uint8_t> pixels = {0, 1, 89, 90, 204, 205, 206, 254, 255};
  std::string bytes = png(pixels, 1);
  const std::string srgb = chunk("sRGB", std::string(1, '\0'));
  ASSERT_EQ(bytes.substr(kHead, srgb.size()), srgb);
  bytes.replace(kHead, srgb.size(), chunk("gAMA", std::string("\x00\x01\x86\xA0", 4)));  // 1.0
  EXPECT_EQ(read(bytes).pixels, pixels);
}

TEST_F(ReadPngOfOthers, AveragesColoursAsMapServerDoes) {
  // 89 and a third, 89, 205 and a third, 0 in the mean.
  EXPECT_EQ(states(read(png({90, 89, 89, 89, 89, 89, 205, 205, 206, 0, 0, 0}, 3))), "uofo");
  // With alpha in the mean: 63.75, 89.25, 217.5, 191.25 of one that nobody sees.
  const std::string with_alpha =
      png({0, 0, 0, 255, 34, 34, 34, 255, 205, 205, 205, 255, 255, 255, 255, 0}, 4);
  EXPECT_EQ(states(read(with_alpha)), "oufu");
  EXPECT_EQ(states(read(with_alpha, "negate: 0\nmode: scale")), "ooff") << "without alpha";
  EXPECT_EQ(states(read(png({150, 255, 150, 0}, 2), "negate: 0\nmode: scale")), "uu")
      << "between, or not seen";
}

TEST_F(ReadPngOfOthers, SaysWhatIsWrong) {
  const std::string sound = png(std::vector<std::uint8_t>(300, 7), 1);
  EXPECT_EQ(refusal(sound), "(no error)");
  EXPECT_TRUE(contains(refusal(sound.substr(0, 20)), "a.pgm' is a damaged PNG ("));
  EXPECT_TRUE(contains(refusal(sound.substr(0, sound.size() - 20)),
                       "a.pgm' is a PNG that is cut off or damaged ("))
      << refusal(sound.substr(0, sound.size() - 20));
  std::string flipped = sound;
  flipped[sound.size() - 20] = static_cast<char>(flipped[sound.size() - 20] ^ 1);
  EXPECT_TRUE(contains(refusal(flipped), "cut off or damaged (")) << refusal(flipped);
  EXPECT_TRUE(
      contains(refusal("GIF89a"), "is not a PGM (it begins with neither P5 nor P2), nor a PNG"));
}

TEST_F(ReadMapOfOthers, SaysWhichFileIsMissing) {
  (void)read("P5\n1 1\n255\na");
  std::filesystem::remove(folder_ / "images/a.pgm");
  EXPECT_EQ(error_text<FileError>([&] { (void)read_map(folder_ / "map.yaml"); }),
            "cannot read '" + (folder_ / "images/a.pgm") + "': No such file or directory");
}

}  // namespace
}  // namespace matchbox_slam
