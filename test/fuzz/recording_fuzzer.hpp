#pragma once

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
#include "tools/bag_mapper.hpp"

namespace matchbox_slam {

/// Gives recordings of any bytes to all that map_bag does with them.
class RecordingFuzzer : public testing::Test {
 protected:
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
  std::string path_ = folder_ / "recording";
};

/// Flips bits, or writes other bytes, at up to four places.
[[nodiscard]] inline std::string damaged_bytes(std::string bytes, Random& random) {
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

}  // namespace matchbox_slam
