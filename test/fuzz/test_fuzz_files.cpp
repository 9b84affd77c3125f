// Files that were mutated, to every reader of text and of maps. Each is either read, and then holds
// numbers only, or refused as a FileError that says why.

#include <gtest/gtest.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <typeinfo>

#include "fuzz/fuzz.hpp"
#include "io/temporary_folder.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/relations_file.hpp"
#include "matchbox_slam/io/stata_truth.hpp"
#include "matchbox_slam/io/tum.hpp"

namespace matchbox_slam {
namespace {

const std::vector<std::string>& words() {
  static const std::vector<std::string> kWords = {" ",
                                                  "\n",
                                                  "\r\n",
                                                  "\t",
                                                  ",",
                                                  "#",
                                                  "nan",
                                                  "inf",
                                                  "-",
                                                  "+",
                                                  ".",
                                                  "e",
                                                  "1e400",
                                                  "-1e400",
                                                  "1e308",
                                                  "0",
                                                  "1",
                                                  "1327500000",
                                                  "4294967296",
                                                  "0x1p3",
                                                  std::string(1, '\0'),
                                                  "\xff",
                                                  "P5",
                                                  "P2",
                                                  "255",
                                                  "65535",
                                                  "1048577",
                                                  "[",
                                                  "]",
                                                  "{",
                                                  "}",
                                                  "&a ",
                                                  "*a",
                                                  "image: ",
                                                  "mode: scale\n",
                                                  "/dev/null",
                                                  "origin: ",
                                                  "negate: 2\n",
                                                  ".nan",
                                                  ".inf",
                                                  "9999999999999999999999"};
  return kWords;
}

/// Tries `count` mutations of a sound text, each from a number of its own.
template <typename Work>
void fuzz_text(const std::string& sound, std::uint64_t usual_count, std::uint64_t seed,
               Work&& work) {
  const std::uint64_t first = first_fuzz_input();
  const std::uint64_t count = fuzz_inputs(usual_count);
  for (std::uint64_t number = first; number < first + count; ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number));
    Random random(mix_seed(seed, number));
    const std::string text = mutated(sound, words(), random);
    try {
      work(text);
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()), "") << text;
    } catch (const std::exception& error) {
      ADD_FAILURE() << typeid(error).name() << ": " << error.what() << "\nof the input:\n" << text;
    }
    if (testing::Test::HasFailure()) {
      return;
    }
  }
}

void expect_numbers(const Trajectory& trajectory) {
  double last = -std::numeric_limits<double>::infinity();
  for (const StampedPose2& pose : trajectory.poses()) {
    ASSERT_TRUE(std::isfinite(pose.stamp) && pose.pose.is_finite());
    ASSERT_GT(pose.stamp, last);
    last = pose.stamp;
  }
}

TEST(FuzzFiles, MutatedTrajectoriesAreReadOrRefused) {
  std::string sound = "# stamp x y z qx qy qz qw\n";
  for (int k = 0; k < 5; ++k) {
    sound += "132750000" + std::to_string(k) + ".125 1.5 -2 0 0 0 0.6 0.8\n";
  }
  fuzz_text(sound, 5000, 31, [](const std::string& text) {
    const Trajectory trajectory = parse_tum(text, "fuzz");
    expect_numbers(trajectory);
    (void)to_tum(trajectory);
  });
}

TEST(FuzzFiles, MutatedGroundTruthIsReadOrRefused) {
  fuzz_text("1327500000000000,29.5,131.0,0.376\n1327500000050000,29.6,131.1,-0.4\n\n# end\n", 5000,
            32, [](const std::string& text) {
              (void)looks_like_stata_truth(text);
              expect_numbers(parse_stata_truth(text, "fuzz"));
            });
}

TEST(FuzzFiles, MutatedRelationsAreReadOrRefused) {
  fuzz_text(
      "976052857.1 976052857.5 0.1 0.2 0 0 0 0.3\n1 2 3 4 5 6 7 8\n", 5000, 33,
      [](const std::string& text) {
        for (const Relation& relation : parse_relations(text, "fuzz")) {
          ASSERT_TRUE(std::isfinite(relation.first_stamp) && std::isfinite(relation.second_stamp));
          ASSERT_TRUE(relation.first_from_second.is_finite());
        }
      });
}

TEST(FuzzFiles, MutatedMapsAreReadOrRefused) {
  const TemporaryFolder folder;
  const std::string yaml =
      "image: map.pgm\nresolution: 0.050000\norigin: [-1.0, 2.0, 0.1]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
  const std::string image = "P5\n# a map\n4 3\n255\n" + std::string(12, '\xcd');
  const auto read = [&](const std::string& mutated_yaml, const std::string& mutated_image) {
    // Not replace_file, nor over a file that is there: both wait for the disk.
    std::filesystem::remove(folder / "map.yaml");
    std::filesystem::remove(folder / "map.pgm");
    std::ofstream(folder / "map.yaml", std::ios::binary) << mutated_yaml;
    std::ofstream(folder / "map.pgm", std::ios::binary) << mutated_image;
    const MapImage map = read_map(folder / "map.yaml");
    ASSERT_EQ(map.pixels.size(),
              static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
    ASSERT_TRUE(std::isfinite(map.resolution) && map.resolution > 0.0 && map.origin.is_finite());
    (void)map.state({0, 0});
    (void)map.state({map.width - 1, map.height - 1});
  };
  fuzz_text(yaml, 2000, 34, [&](const std::string& text) { read(text, image); });
  fuzz_text(image, 2000, 35, [&](const std::string& text) { read(yaml, text); });
}

}  // namespace
}  // namespace matchbox_slam
