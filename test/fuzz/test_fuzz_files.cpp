// Files that were mutated, to every reader of text and of maps. Each is either read, and then holds
// numbers only, or refused as a FileError that says why.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <typeinfo>
#include <vector>

#include "fuzz/fuzz.hpp"
#include "io/gzip.hpp"
#include "io/png_image.hpp"
#include "io/relations_file.hpp"
#include "io/stata_truth.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "matchbox_slam/io/map_file.hpp"
#include "matchbox_slam/io/saved_map.hpp"
#include "matchbox_slam/matching/hough/hough_matcher.hpp"
#include "matchbox_slam/matching/olson/olson_matcher.hpp"

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

constexpr double kMostCells = 1e6;  // of a saved map, so that it stays quick
constexpr std::size_t kMostImageBytes = std::size_t{1} << 29U;  // that such a map takes

TEST(FuzzFiles, MutatedMapsAreReadOrRefused) {
  const TemporaryFolder folder;
  const std::string yaml =
      "image: map.pgm\nresolution: 0.050000\norigin: [-1.0, 2.0, 0.1]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
  const std::string image =
      "P5\n# a map\n4 3\n255\n" + std::string(4, '\0') + std::string(8, '\xfe');
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
    MapOptions options;
    options.max_cells = kMostCells;
    try {
      const EngineState start = map_from_image(map, "fuzz", options, {});
      ASSERT_LE(start.map.occupancy.bytes() + start.map.field.bytes(), kMostImageBytes);
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()), "");
    }
  };
  fuzz_text(yaml, 2000, 34, [&](const std::string& text) { read(text, image); });
  fuzz_text(image, 2000, 35, [&](const std::string& text) { read(yaml, text); });
  const std::string png = gray_png(4, 3, std::vector<std::uint8_t>(12, 205));
  fuzz_text(png, 2000, 36, [&](const std::string& text) { read(yaml, text); });
}

// --- saved maps ---

EngineOptions small_options() {
  EngineOptions options;
  options.map.resolution = 0.1;
  options.map.max_cells = kMostCells;
  options.slam.insert_distance = 0.0;
  options.slam.insert_angle = 0.0;
  return options;
}

ScanInput small_scan(double stamp) {
  ScanInput input;
  input.scan = {stamp, -3.0, 0.25, 0.0, 0.1, 10.0, {}};
  for (int k = 0; k < 24; ++k) {
    input.scan.ranges.push_back(k % 8 == 0 ? 0.8F : 1.2F);
  }
  return input;
}

/// A true map of two scans, without the compression.
std::string small_map() {
  SlamEngine engine(small_options(), std::make_shared<OlsonMatcher>(), 1);
  engine.process(small_scan(1.0));
  engine.process(small_scan(1.1));
  return decompress(to_saved_map(engine.snapshot()), "fuzz");
}

/// Where the fields of a saved map are, so that damage reaches every check behind its head.
class SavedFields {
 public:
  explicit SavedFields(const std::string& bytes)
      : bytes_(bytes), at_(std::string("matchbox_slam map, version 17\n").size()) {
    add(3, 8, numbers);
    for (std::uint64_t rows = count(); rows > 0; --rows) {
      add(2, 4, coordinates);
      std::uint32_t cells = 0;
      std::memcpy(&cells, bytes.data() + at_, sizeof cells);
      add(1, 4, coordinates);  // how many cells: damaged by the same values
      add(cells, 2, rest);
    }
    for (std::uint64_t walls = count(); walls > 0; --walls) {
      add(2, 4, coordinates);
      add(7, 2, rest);
      add(2, 1, rest);
    }
    for (std::uint64_t key_scans = count(); key_scans > 0; --key_scans) {
      add(3, 8, numbers);
      add(1, 4, rest);
      add(1, 1, rest);  // measured
      add(6, 8, numbers);
      add(count(), 4, rest);
      add(12 + 3 + 9, 8, numbers);
      EXPECT_EQ(count(), 0U) << "no masked angles";
      add(1, 1, rest);
      add(12, 8, numbers);
    }
    add(3 + 9 + 9, 8, state);
    add(1, 1, rest);
    add(1, 8, state);
    add(1, 4, rest);
    add(2, 1, rest);
    add(3, 8, state);
    add(1, 1, rest);
    add(8 + 2, 8, state);
    add(3 + 9 + 2, 8, state);
    add(1, 1, rest);
    add(1 + 3 + 3 + 3, 8, state);
    for (std::uint64_t lasers = count(); lasers > 0; --lasers) {
      add(1, 4, rest);
      add(3, 8, state);
    }
    add(1, 8, rest);
    EXPECT_EQ(count(), 0U) << "no maps apart";
    add(1, 8, rest);
    add(72 + 1, 8, state);
    add(1, 1, rest);
    EXPECT_EQ(count() + count(), 0U) << "no fork, and no scans that wait";
    add(1, 8, state);
    add(1, 8, rest);
    add(2, 4, rest);
    EXPECT_EQ(count() + count(), 0U) << "no key scans of a lost robot, and no places of it";
    EXPECT_EQ(count(), 2U) << "key scans in the graph";
    for (std::uint64_t edges = count(); edges > 0; --edges) {
      add(2, 8, counts);
      add(3 + 9, 8, state);
      add(2, 1, rest);
      add(3, 8, state);
    }
    EXPECT_EQ(count(), 0U) << "no loops";
    add(1, 8, state);
    add(1, 8, rest);
    EXPECT_EQ(count(), 0U) << "no key scans of another robot";
    add(5, 1, rest);
    add(2, 4, rest);
    add(1, 8, state);
    EXPECT_EQ(count(), 0U) << "no secondary lasers";
    EXPECT_EQ(at_, bytes.size()) << "the format has changed";
  }

  std::vector<std::size_t> counts, numbers, coordinates, state, rest;

 private:
  void add(std::size_t count, std::size_t size, std::vector<std::size_t>& fields) {
    for (; count > 0; --count, at_ += size) {
      if (at_ + size > bytes_.size()) {
        throw std::logic_error("the format has changed");
      }
      fields.push_back(at_);
    }
  }

  std::uint64_t count() {
    std::uint64_t value = 0;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    add(1, sizeof value, counts);
    return value;
  }

  const std::string& bytes_;
  std::size_t at_;
};

template <typename Value>
void put(Value value, std::size_t at, std::string& bytes) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

/// Writes odd values into one to three fields.
void damage_fields(const SavedFields& fields, std::string& bytes, Random& random) {
  static const std::vector<std::uint64_t> kCounts = {0,   1,       2,           3,           7,
                                                     100, 1000000, 1ULL << 32U, 1ULL << 60U, ~0ULL};
  static const std::vector<std::int32_t> kCoordinates = {-1,
                                                         0,
                                                         64,
                                                         900,
                                                         -900,
                                                         30000,
                                                         -30000,
                                                         1 << 24,
                                                         -(1 << 24),
                                                         (1 << 24) + 1,
                                                         std::numeric_limits<std::int32_t>::max(),
                                                         std::numeric_limits<std::int32_t>::min()};
  for (std::size_t left = 1 + below(3, random); left > 0; --left) {
    switch (below(6, random)) {
      case 0:
        put(one_of(kCounts, random), one_of(fields.counts, random), bytes);
        break;
      case 1:
      case 2:
        put(one_of(kCoordinates, random), one_of(fields.coordinates, random), bytes);
        break;
      case 3:
        bytes[one_of(fields.rest, random)] = static_cast<char>(random.next());
        break;
      case 4:
        put(odd_number(random), one_of(fields.numbers, random), bytes);
        break;
      default:  // where the robot is, how sure that is, and how it moves
        put(odd_number(random), one_of(fields.state, random), bytes);
        break;
    }
  }
}

std::string damaged_map(const std::string& sound, const SavedFields& fields, Random& random) {
  std::string bytes = sound;
  const double kind = random.uniform();
  if (kind < 0.6) {
    damage_fields(fields, bytes, random);
  } else if (kind < 0.85) {
    bytes = mutated(bytes, words(), random);
  }
  bytes = compress(bytes);
  return kind < 0.85 ? bytes : mutated(bytes, words(), random);
}

/// What map_bag does with a map that it was told to go on with.
void go_on_with(EngineState start, bool hough) {
  ASSERT_LE(start.map.occupancy.bytes() + start.map.field.bytes(), kMostImageBytes);
  ASSERT_LE(make_map_image(start.map.occupancy).pixels.size(), kMostCells);
  std::shared_ptr<const ScanMatcher> matcher = std::make_shared<OlsonMatcher>();
  if (hough) {
    matcher = std::make_shared<HoughMatcher>();
  }
  SlamEngine engine(small_options(), matcher, 1);
  const double since = 2.0 - start.motion.stamp.value_or(2.0);
  if (!(since > 0.0 && since <= 10.0)) {  // it is of another drive
    start.begin_anew(start.motion.fixed_from_base, start.motion.covariance);
  }
  engine.start_from(start);
  const ScanOutcome outcome = engine.process(small_scan(2.0));
  ASSERT_TRUE(outcome.map_from_base.is_finite() && outcome.covariance.allFinite());
  (void)to_saved_map(engine.snapshot());
}

TEST(FuzzFiles, MutatedSavedMapsAreReadOrRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "map.slam";
  const std::string sound = small_map();
  const SavedFields fields(sound);
  const std::uint64_t first = first_fuzz_input();
  const std::uint64_t count = fuzz_inputs(2000);
  std::uint64_t read = 0;
  for (std::uint64_t number = first; number < first + count && !HasFailure(); ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number));
    Random random(mix_seed(36, number));
    std::filesystem::remove(path);  // as above
    std::ofstream(path, std::ios::binary) << damaged_map(sound, fields, random);
    try {
      go_on_with(read_engine_state(path, small_options()), number % 2 == 0);
      ++read;
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()), "");
    } catch (const ConfigurationError& error) {  // another resolution or field
      EXPECT_NE(std::string(error.what()), "");
    } catch (const std::exception& error) {
      ADD_FAILURE() << typeid(error).name() << ": " << error.what();
    }
  }
  EXPECT_TRUE(is_enough(read, count, 0.05)) << read << ": always refused they try little";
}

/// Of which parts are read by code of their own.
TEST(FuzzFiles, MutatedMapsOfRelease1AreReadOrRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "map.slam";
  const std::string written = std::string(MATCHBOX_SOURCE_DIR) + "/test/io/version_7.slam";
  const std::string sound = decompress(read_file(written), written);
  const std::uint64_t first = first_fuzz_input();
  const std::uint64_t count = fuzz_inputs(2000);
  std::uint64_t read = 0;
  for (std::uint64_t number = first; number < first + count && !HasFailure(); ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number));
    Random random(mix_seed(37, number));
    std::string bytes = sound;
    for (std::size_t left = 1 + below(4, random); left > 0; --left) {
      bytes[below(bytes.size(), random)] = static_cast<char>(random.next());
    }
    std::filesystem::remove(path);  // as above
    std::ofstream(path, std::ios::binary) << compress(bytes);
    try {
      (void)to_saved_map(read_saved_map(path, kMostCells));
      ++read;
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()), "");
    } catch (const std::exception& error) {
      ADD_FAILURE() << typeid(error).name() << ": " << error.what();
    }
  }
  EXPECT_TRUE(is_enough(read, count, 0.05)) << read << ": always refused they try little";
}

}  // namespace
}  // namespace matchbox_slam
