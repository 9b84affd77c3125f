// Bags that were cut off or had bytes flipped, through all that map_bag does with them. Each is
// mapped, or its sound part is, or it is refused; what is wrong is told in each case.

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fuzz/recording_fuzzer.hpp"
#include "matchbox_slam/io/file.hpp"
#include "ros/messages.hpp"

namespace matchbox_slam {
namespace {

class FuzzBags : public RecordingFuzzer {
 protected:
  FuzzBags() {
    for (const auto compression :
         {rosbag::compression::Uncompressed, rosbag::compression::BZ2, rosbag::compression::LZ4}) {
      SmallBag recipe;
      recipe.scans = 20;
      recipe.compression = compression;
      write_small_bag(path_, recipe);
      bags_.push_back(read_file(path_));
    }
  }

  std::vector<std::string> bags_;  ///< packed in each way
};

TEST_F(FuzzBags, CutOffAtEveryKilobyteTheyAreRefused) {
  for (const std::string& bag : bags_) {
    EXPECT_EQ(map(bag), "");
    EXPECT_EQ(poses(), 20U);
    for (std::size_t size = 0; size < bag.size(); size += 1024) {
      const std::string text = map(bag.substr(0, size));
      EXPECT_NE(text.find(path_), std::string::npos) << size << ": " << text;
    }
  }
}

TEST(Fuzz, AShareIsAskedOfManyInputsAlone) {
  EXPECT_TRUE(is_enough(0, 1, 0.1));  // MATCHBOX_FUZZ_INPUTS=1, to see a failure again
  EXPECT_TRUE(is_enough(101, 1000, 0.1));
  EXPECT_FALSE(is_enough(100, 1000, 0.1));
}

TEST_F(FuzzBags, WithFlippedBytesTheyAreMappedOrRefused) {
  const std::uint64_t first = first_fuzz_input();
  const std::uint64_t count = fuzz_inputs(1000);
  std::uint64_t refused = 0;
  for (std::uint64_t number = first; number < first + count && !HasFailure(); ++number) {
    SCOPED_TRACE("MATCHBOX_FUZZ_FIRST=" + std::to_string(number));
    Random random(mix_seed(41, number));
    const std::string bytes = damaged_bytes(one_of(bags_, random), random);
    refused += (number % 50 == 0 ? map(bytes) : read(bytes)).empty() ? 0 : 1;
  }
  EXPECT_TRUE(is_enough(refused, count, 0.1)) << refused << ": harmless damage tries little";
}

}  // namespace
}  // namespace matchbox_slam
