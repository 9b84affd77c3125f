// Recordings of other formats than bags of ROS 1 that were cut off or had bytes changed, through
// all that map_bag does with them. Each is mapped, or its sound part is, or it is refused; what is
// wrong is told and names the file.

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "bag/ros2_recordings.hpp"
#include "fuzz/recording_fuzzer.hpp"
#include "io/gzip.hpp"
#include "matchbox_slam/io/file.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {
namespace {

constexpr std::size_t kScans = 20;

std::string carmen_log() {
  std::ostringstream log;
  log << "PARAM robot_frontlaser_offset 0.2 host 0\n";
  for (std::size_t k = 0; k < kScans; ++k) {
    const double time = 1000.0 + 0.1 * static_cast<double>(k);
    log << "ODOM " << 0.002 * static_cast<double>(k) << " 0 0 0.02 0 0 " << time << " host "
        << time - 1000.0 << "\nROBOTLASER1 0 -2 4 0.05 30 0.01 0 80";
    for (const float range : make_scan(time, "laser", 80).ranges) {
      log << ' ' << range;
    }
    log << " 0 0.2 0 0 " << 0.002 * static_cast<double>(k) << " 0 0 0 0 0 0 0 " << time << " host "
        << time - 1000.0 << '\n';
  }
  return log.str();
}

class FuzzRecordings : public RecordingFuzzer {
 protected:
  FuzzRecordings() {
    SmallBag recipe;
    recipe.scans = kScans;
    const std::string bag = folder_ / "small.bag";
    write_small_bag(bag, recipe);
    const std::vector<Ros2Message> messages = as_ros2(bag);
    for (const std::string compression : {"", "lz4", "zstd"}) {
      McapRecipe mcap;
      mcap.compression = compression;
      recordings_.push_back(to_mcap(messages, mcap));
    }
    McapRecipe unchunked;
    unchunked.chunk_messages = 0;
    recordings_.push_back(to_mcap(messages, unchunked));
    for (const bool packs_messages : {false, true}) {
      const std::string database = folder_ / "small.db3";
      std::filesystem::remove(database);
      write_db3(database, messages, packs_messages);
      recordings_.push_back(read_file(database));
    }
    recordings_.push_back(carmen_log());
    recordings_.push_back(compress(carmen_log()));
  }

  std::vector<std::string> recordings_;  ///< in each format
};

TEST_F(FuzzRecordings, CutOffAtEveryKilobyteTheirSoundPartIsMapped) {
  for (const std::string& recording : recordings_) {
    EXPECT_EQ(map(recording), "");
    EXPECT_EQ(poses(), kScans);
    for (std::size_t size = 0; size < recording.size(); size += 1024) {
      const std::string text = read(recording.substr(0, size));
      // A log that is cut off is one whose last line is bad, which is a warning.
      EXPECT_TRUE(text.empty() || text.find("recording'") != std::string::npos)
          << size << ": " << text;
    }
  }
}

TEST_F(FuzzRecordings, WithFlippedBytesTheyAreMappedOrRefused) {
  const std::uint64_t first = first_fuzz_input();
  const std::uint64_t count = fuzz_inputs(1000);
  std::uint64_t refused = 0;
  for (std::uint64_t number = first; number < first + count && !HasFailure(); ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number));
    Random random(mix_seed(43, number));
    const std::string bytes = damaged_bytes(one_of(recordings_, random), random);
    refused += (number % 50 == 0 ? map(bytes) : read(bytes)).empty() ? 0 : 1;
  }
  EXPECT_TRUE(is_enough(refused, count, 0.1)) << refused << ": harmless damage tries little";
}

TEST_F(FuzzRecordings, WithOtherWordsAndPiecesTheyAreMappedOrRefused) {
  using namespace std::string_literals;
  const std::vector<std::string> words = {"FLASER ",
                                          " 181 ",
                                          " -1 ",
                                          " 1e300 ",
                                          " nan ",
                                          "\n",
                                          "\x89MCAP0\r\n",
                                          "\xFF\xFF\xFF\xFF",
                                          "\xFF\xFF\xFF\xFF\xFF\xFF\xFF\x7F",
                                          "\0\0\0\0"s,
                                          "\x28\xB5\x2F\xFD",
                                          "\x04\x22\x4D\x18",
                                          "zstd",
                                          "cdr",
                                          "/tf_static"};
  const std::uint64_t first = first_fuzz_input();
  const std::uint64_t count = fuzz_inputs(1000);
  for (std::uint64_t number = first; number < first + count && !HasFailure(); ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number));
    Random random(mix_seed(44, number));
    (void)read(mutated(one_of(recordings_, random), words, random));
  }
}

}  // namespace
}  // namespace matchbox_slam
