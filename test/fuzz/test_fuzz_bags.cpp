// Bags that were cut off or had bytes flipped, through all that map_bag does with them. Each is
// mapped, or its sound part is, or it is refused; what is wrong is told in each case.

#include <gtest/gtest.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <typeinfo>

#include "fuzz/fuzz.hpp"
#include "geometry/trajectory.hpp"
#include "io/temporary_folder.hpp"
#include "io/tum.hpp"
#include "matchbox_slam/io/file.hpp"
#include "ros/messages.hpp"
#include "tools/bag_mapper.hpp"

namespace matchbox_slam {
namespace {

class FuzzBags : public testing::Test {
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

  /// Maps a bag of these bytes. Returns what is wrong with it; empty: nothing.
  std::string map(const std::string& bytes) {
    return what_is_wrong(bytes, [this] {
      MapBagRequest request;
      request.recording.bags = {path_};
      request.out = folder_ / "out";
      request.matcher = "odometry_only";
      map_bag(request, dialog_);
    });
  }

  /// The same without the files that map_bag writes, which take most of its time.
  std::string read(const std::string& bytes) {
    return what_is_wrong(bytes, [this] {
      BagRequest request;
      request.bags = {path_};
      BagScans scans(request, dialog_);
      (void)scans.prepare({}, {});
      while (scans.next()) {
      }
      if (!scans.facts().damage.empty()) {
        throw BagError(scans.facts().damage);
      }
    });
  }

  template <typename Work>
  std::string what_is_wrong(const std::string& bytes, Work&& work) {
    // Not replace_file, nor over a file that is there: both wait for the disk.
    std::filesystem::remove(path_);
    std::ofstream(path_, std::ios::binary) << bytes;
    try {
      work();
    } catch (const BagError& error) {
      return error.what();
    } catch (const ConfigurationError& error) {
      return error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << typeid(error).name() << ": " << error.what();
    }
    return "";
  }

  [[nodiscard]] std::size_t poses() const {
    return read_tum(folder_ / "out/trajectory.tum").size();
  }

  RunDialog dialog_ = {[](const std::string& /*line*/) {}, [](const std::string& /*line*/) {},
                       [](double /*fraction*/, const std::string& /*text*/) {},
                       [] { return false; }};
  TemporaryFolder folder_;
  std::string path_ = folder_ / "small.bag";
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

/// Flips bits, or writes other bytes, at up to four places.
std::string damaged(std::string bytes, Random& random) {
  for (std::size_t left = 1 + below(4, random); left > 0; --left) {
    const std::size_t at = below(bytes.size(), random);
    const std::size_t count = happens(0.7, random) ? 1 : below(16, random);
    for (std::size_t k = at; k < std::min(bytes.size(), at + count); ++k) {
      bytes[k] = happens(0.5, random) ? static_cast<char>(bytes[k] ^ (1 << below(8, random)))
                                      : static_cast<char>(random.next());
    }
  }
  return bytes;
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
    const std::string bytes = damaged(one_of(bags_, random), random);
    refused += (number % 50 == 0 ? map(bytes) : read(bytes)).empty() ? 0 : 1;
  }
  EXPECT_TRUE(is_enough(refused, count, 0.1)) << refused << ": harmless damage tries little";
}

}  // namespace
}  // namespace matchbox_slam
